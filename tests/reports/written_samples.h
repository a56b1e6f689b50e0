// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/results/samples.h"
#include "datasets/results/summary.h"

namespace trilat {

inline constexpr std::uint8_t kAnswered = 1, kUnanswered = 2;

// Two joints by default, at 30 instants a second.
inline SamplesHeader samples_of(std::vector<std::string> methods, std::vector<TakeShape> takes,
                                std::vector<std::string> joints = {"head", "wrist_right"}) {
  return {std::move(joints),
          std::move(methods),
          {"not_solved", "converged", "too_few_ranges"},
          "none",
          std::move(takes)};
}

// Heights of one joint at one instant; NaN truth: none, NaN estimate: no answer.
using Height = std::function<double(std::size_t take, double time_s, std::size_t joint)>;
using MethodHeight =
    std::function<double(std::size_t take, double time_s, std::size_t joint, std::size_t method)>;

inline void write_samples(const std::filesystem::path& folder, const SamplesHeader& header,
                          const Height& truth_m, const MethodHeight& estimate_m) {
  std::filesystem::create_directories(folder);
  SamplesFile file = SamplesFile::create(folder / "samples.h5", header);
  const std::size_t joints = header.joints.size(), methods = header.methods.size();
  for (std::size_t take = 0; take < header.takes.size(); ++take) {
    SampleBlock block;
    block.reset(0, header.takes[take].instants, joints, methods);
    for (std::uint64_t i = 0; i < block.instants; ++i) {
      const double time_s = static_cast<double>(i) / 30.0;
      block.time_ns[i] = 5'000'000'000 + std::llround(time_s * 1e9);
      for (std::size_t j = 0; j < joints; ++j) {
        const std::size_t row = i * joints + j;
        for (std::size_t axis = 0; axis < 3; ++axis)
          block.truth_m[row * 3 + axis] = truth_m(take, time_s, j) + (axis == 1 ? 0.0 : 7.0);
        for (std::size_t m = 0; m < methods; ++m) {
          const std::size_t slot = row * methods + m;
          const double y = estimate_m(take, time_s, j, m);
          block.status[slot] = std::isfinite(y) ? kAnswered : kUnanswered;
          // what was not answered may still hold a last iterate
          for (std::size_t axis = 0; axis < 3; ++axis)
            block.estimate_m[slot * 3 + axis] = std::isfinite(y) ? y + (axis == 1 ? 0.0 : 7.0) : 99.0;
        }
      }
    }
    file.write(take, block);
  }
  file.finish();
}

}  // namespace trilat
