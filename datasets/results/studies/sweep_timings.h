// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/described.h"

namespace trilat {

// Nanoseconds a solve, start included, of one cell of a sweep.
struct SweepCellTiming {
  std::size_t interpretation = 0;
  std::size_t threshold = 0;
  std::size_t range = 0;
  double scalar_median_ns = 0.0, scalar_min_ns = 0.0;    // one problem at a time, over the repeats
  double batched_median_ns = 0.0, batched_min_ns = 0.0;  // many problems side by side

  TRILAT_FIELDS(interpretation, threshold, range, scalar_median_ns, scalar_min_ns, batched_median_ns,
                batched_min_ns)
};

// What differs from machine to machine and run to run.
struct SweepTimings {
  std::string study;
  std::string processor;
  std::uint64_t problems = 0;  // of each cell, in each repeat
  std::uint64_t repeats = 0;
  std::vector<SweepCellTiming> cells;

  TRILAT_FIELDS(study, processor, problems, repeats, cells)
};

// timings.json, beside the sweep's summary.json.
void write_sweep_timings(const std::filesystem::path& folder, const SweepTimings& timings);
// Nothing when the sweep was not timed; InputError when the file is not one of these.
std::optional<SweepTimings> read_sweep_timings(const std::filesystem::path& folder);

}  // namespace trilat
