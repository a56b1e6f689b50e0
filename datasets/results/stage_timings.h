// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/time_spread.h"

namespace trilat {

// From the depth images to the joints: body tracking as the study declares it, and trilateration as measured.
inline constexpr const char* kDepthToJoints = "body tracking (simulated) and trilateration";

// What a frame costs in one stage of its way, measured.
struct StageTiming {
  std::string name;    // "trilateration"
  std::string method;  // of the stage, where it has several; else empty
  TimeSpread time;     // a frame
};

// What differs from machine to machine and run to run.
struct StageTimings {
  std::string study;
  std::string processor;
  std::vector<StageTiming> stages;
};

// timings.json, beside the summary.json of a study of kind "recording".
void write_stage_timings(const std::filesystem::path& folder, const StageTimings& timings);
// Nothing when nothing was timed; InputError when the file is not one of these.
std::optional<StageTimings> read_stage_timings(const std::filesystem::path& folder);

}  // namespace trilat
