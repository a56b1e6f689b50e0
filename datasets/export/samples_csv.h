// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "datasets/results/samples.h"

namespace trilat {

inline constexpr const char* kSamplesCsvHead =
    "take,time_ns,joint,truth_x_m,truth_y_m,truth_z_m,method,status,estimate_x_m,estimate_y_m,estimate_z_m\n";

// One row a take, instant, joint and method, in the world of the ground truth: where the joint was and where
// the method says it was. What is not known is an empty field. Returns the number of rows.
std::int64_t export_samples_csv(const SamplesFile& samples, const std::filesystem::path& output,
                                const std::function<void(double)>& progress = {});

}  // namespace trilat
