// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_result.h"

#include <nlohmann/json.hpp>

#include "datasets/results/studies/tracking_summary.h"
#include "pipeline/accuracy/take/solve_block.h"

namespace trilat {
void TakeCheck::merge(const TakeCheck& later) {
  samples += later.samples;
  disagreements += later.disagreements;
  if (disagreed_at.empty()) disagreed_at = later.disagreed_at;
  if (later.worst_m > worst_m) {
    worst_m = later.worst_m;
    worst_at = later.worst_at;
  }
}

RunOutcome outcome_of(const Plan& plan, std::span<const EvaluatedTake> takes, bool cross_check) {
  RunOutcome outcome;
  TakeCheck check;
  std::vector<TakeTracking> tracking;
  for (const EvaluatedTake& take : takes) {
    tracking.push_back(take.result.tracking);
    outcome.notes.insert(outcome.notes.end(), take.result.notes.begin(), take.result.notes.end());
    outcome.evaluated.push_back(take.result.evaluated);
    check.merge(take.result.check);
  }
  outcome.tracking = sum_tracking(plan, tracking);
  if (cross_check)
    outcome.cross_check = CrossCheck{checked_method(plan)->spec.name,
                                     check.samples,
                                     check.disagreements,
                                     check.worst_m,
                                     plan.study.cross_check_limit_m,
                                     check.disagreements > 0 ? check.disagreed_at : check.worst_at};
  return outcome;
}

}  // namespace trilat
