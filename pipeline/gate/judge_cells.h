// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {

struct GateLimits {
  double smallest_percent = 1.0;       // of an error or a number; less is not worth a word
  double smallest_loss_percent = 0.5;  // of the samples asked
  double take_loss_percent = 10.0;     // of one take's answers, where both nights saw the same recordings
  double chance = 0.01;                // of a false alarm in the whole night; each part has a share of it
};

// Which compared cells of a whole night are findings. A cell is worse or better when its 95 % interval leaves
// no change out, the probability of chance by Holm over all cells of the night is at most half of `chance`,
// and the change is larger than the smallest. Coverage is judged in the same way at 0.05 of `chance`, of the
// first alignment's cells, as samples lost; and with the same recordings also take by take, without chance:
// there is none. So are answers that are clamped, at 0.05; of other statuses that moved it is told. A change
// of which one cluster says nothing of chance counts when it is larger than the smallest. Only what is worse
// is an alarm. `studies_with_same_inputs`: whose recordings are the baseline's.
std::vector<GateFinding> judge_cells(std::span<const ComparedCell> cells, const GateLimits& limits,
                                     const std::vector<std::string>& studies_with_same_inputs);

struct NumberChanges {
  std::vector<GateFinding> findings;  // alarms, the largest first; at most kMostNumbers
  std::uint64_t differing = 0;        // values that differ at all
  double largest_percent = 0.0;       // of the numbers among them
};
inline constexpr std::size_t kMostNumbers = 100;

// What differs between two documents of a deterministic study, which are equal when nothing changed: numbers
// by more than the smallest effect of the number before, and whatever else. Whether more is better nobody
// says, so each is an alarm: somebody should look.
NumberChanges judge_numbers(const std::string& study, const Json& now, const Json& before,
                            const GateLimits& limits);

}  // namespace trilat
