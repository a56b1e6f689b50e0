// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

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
