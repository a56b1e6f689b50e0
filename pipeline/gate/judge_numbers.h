// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "pipeline/gate/gate_report.h"
#include "pipeline/gate/judge_cells.h"

namespace trilat {

struct NumberChanges {
  std::vector<GateFinding>
      findings;  // larger than the smallest effect, largest first, a place of the document each
  std::uint64_t differing = 0;   // numbers that differ at all
  double largest_percent = 0.0;  // of these
};

// The numbers of a deterministic study, which are equal when nothing changed. Sizes are relative to the
// number before; where that is nearly 0 beside its fellows (the same key all over the document), to their
// root mean square. Whether more is worse is known by the key (errors, iterations: more; digits, answered:
// fewer); where it is not, a change is an alarm too, because somebody should look. Ends of intervals and
// spreads are told, not judged; long lists of samples are judged by their mean.
NumberChanges judge_numbers(const std::string& study, const Json& now, const Json& before,
                            const GateLimits& limits);

}  // namespace trilat
