// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/study/study.h"
#include "pipeline/sweep/sweep_plan.h"

namespace trilat {

// Trials that one thread sums up; the sums of a cell's chunks are added in their order.
inline constexpr std::size_t kChunkTrials = 8192;
// An item has no more trials than that, some seconds, unless a single cell has more.
inline constexpr std::uint64_t kItemTrials = std::uint64_t{1} << 22;
// One threshold alone is an item only when it has so many, so that many small ones cost little.
inline constexpr std::uint64_t kFewTrials = std::uint64_t{1} << 17;

// Cells of one reading that follow each other.
struct SweepItem {
  std::string id;
  std::size_t first_cell = 0, cells = 0;
};
std::uint64_t trials_in(const SweepPlan& plan, const SweepItem& item);
// In the order of the cells.
std::vector<SweepItem> items_of(const SweepPlan& plan);
// Equal for items of equal outcome, whatever else their studies hold.
std::string key_of_item(const SweepPlan& plan, const SweepItem& item);

// Its summary.json is a SweepSummary, its timings.json SweepTimings.
Study sweep_study(const SweepPlan& plan);

}  // namespace trilat
