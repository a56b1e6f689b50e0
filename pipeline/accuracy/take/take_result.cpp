// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_result.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/tracking_summary.h"

namespace trilat {
namespace {

void add(const RuleRow& more, RuleRow& row) {
  row.views += more.views;
  row.hidden += more.hidden;
  row.marked += more.marked;
  row.both += more.both;
}

void add(const BoundRow& more, BoundRow& row) {
  row.n += more.n;
  row.ranges += more.ranges;
  row.range_error_m2 += more.range_error_m2;
  row.gdop += more.gdop;
}

// Sums of one condition, group and rule stand in one row.
template <class Row>
void add_row(const Row& more, std::vector<Row>& rows) {
  const auto same = std::ranges::find_if(rows, [&](const Row& row) {
    bool is_same = row.condition == more.condition && row.group == more.group;
    if constexpr (requires { row.rule; }) is_same = is_same && row.rule == more.rule;
    return is_same;
  });
  if (same == rows.end())
    rows.push_back(more);
  else
    add(more, *same);
}

TrackingSummary sum_tracking(const Plan& plan, std::span<const TakeResult> takes) {
  TrackingSummary summary{plan.study.name, plan.simulated, plan.study.stage.repair_exchanges};
  for (const TakeResult& take : takes) {
    const TakeTracking& tracking = take.tracking;
    std::ranges::copy(tracking.checks, std::back_inserter(summary.checks));
    if (!tracking.clock.status.empty()) summary.clocks.push_back(tracking.clock);
    if (!tracking.rays.take.empty()) summary.rays.push_back(tracking.rays);
    for (const RuleRow& row : tracking.rules) add_row(row, summary.rules);
    for (const BoundRow& row : tracking.bounds) add_row(row, summary.bounds);
  }
  return summary;
}

}  // namespace

void TakeCheck::merge(const TakeCheck& later) {
  samples += later.samples;
  disagreements += later.disagreements;
  lost += later.lost;
  if (disagreed_at.empty()) disagreed_at = later.disagreed_at;
  if (later.worst_m > worst_m) {
    worst_m = later.worst_m;
    worst_at = later.worst_at;
  }
}

StudyTotals outcome_of(const Plan& plan, std::span<const TakeResult> takes, bool cross_check) {
  StudyTotals outcome;
  const std::vector<const Method*> checked = checked_methods(plan);
  std::vector<TakeCheck> checks(checked.size());
  for (const TakeResult& take : takes) {
    outcome.notes.insert(outcome.notes.end(), take.notes.begin(), take.notes.end());
    outcome.evaluated.push_back(take.evaluated);
    for (std::size_t m = 0; m < std::min(checks.size(), take.checks.size()); ++m)
      checks[m].merge(take.checks[m]);
  }
  outcome.tracking = sum_tracking(plan, takes);
  for (std::size_t m = 0; cross_check && m < checks.size(); ++m) {
    const TakeCheck& check = checks[m];
    outcome.cross_checks.push_back({checked[m]->spec.name, check.samples, check.disagreements, check.lost,
                                    check.worst_m, plan.study.cross_check_limit_m,
                                    check.disagreements > 0 ? check.disagreed_at : check.worst_at});
  }
  return outcome;
}

}  // namespace trilat
