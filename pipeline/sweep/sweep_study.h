// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>

#include "pipeline/study/study.h"
#include "pipeline/sweep/sweep_spec.h"

namespace trilat {

// Trials that one thread sums up; the sums of a cell's chunks are added in their order.
inline constexpr std::size_t kChunkTrials = 8192;

// Solves the sweep's trials on the threads of the current arena. An item is the cells of one interpretation,
// or some of them; summary.json is a SweepSummary, timings.json SweepTimings. Throws Interrupted.
ItemCounts run_sweep(const SweepSpec& spec, const std::filesystem::path& folder, const StudyOptions& options);

}  // namespace trilat
