// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "pipeline/study/study.h"
#include "pipeline/sweep/sweep_spec.h"

namespace trilat {

// Trials that one thread sums up; the sums of a cell's chunks are added in their order.
inline constexpr std::size_t kChunkTrials = 8192;

// An item is the cells of one interpretation, or some of them. Its summary.json is a SweepSummary, its
// timings.json SweepTimings.
Study sweep_study(const SweepSpec& spec);

}  // namespace trilat
