// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "pipeline/accuracy/statistics/condition_statistics.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// The cells of a summary by method, condition, group and alignment.
class CellIndex {
 public:
  explicit CellIndex(const ResultsSummary& summary) {
    for (std::size_t c = 0; c < summary.cells.size(); ++c) {
      const SummaryCell& cell = summary.cells[c];
      place_[{cell.method, cell.condition, cell.group, cell.alignment}] = c;
    }
  }
  SummaryCell* find(ResultsSummary& summary, const std::string& method, const std::string& condition,
                    const std::string& group, const std::string& alignment) const {
    const auto found = place_.find({method, condition, group, alignment});
    return found == place_.end() ? nullptr : &summary.cells[found->second];
  }

 private:
  std::map<std::array<std::string, 4>, std::size_t> place_;
};

struct Names {
  std::string method, condition;
};

// The groups that a condition has cells of, by number.
std::vector<std::size_t> asked_groups(const ResultsSummary& summary, const std::string& condition) {
  std::vector<std::size_t> groups;
  for (std::size_t g = 0; g < summary.groups.size(); ++g)
    if (std::any_of(summary.cells.begin(), summary.cells.end(), [&](const SummaryCell& cell) {
          return cell.condition == condition && cell.group == summary.groups[g];
        }))
      groups.push_back(g);
  return groups;
}

// The mean of the groups, without its interval; NaN when one of them was not answered.
SummaryCell average_cell(ResultsSummary& summary, const CellIndex& index, const Names& names,
                         const std::vector<std::size_t>& groups, const CellInterval& interval) {
  SummaryCell average;
  average.method = names.method;
  average.condition = names.condition;
  average.group = kAverageGroup;
  average.alignment = summary.alignments[interval.alignment];
  double sum_m = 0.0;
  for (const std::size_t g : groups) {
    const SummaryCell* cell =
        index.find(summary, names.method, names.condition, summary.groups[g], average.alignment);
    sum_m += cell ? cell->mae_m : kNoNumber;
    if (!cell) continue;
    average.asked += cell->asked;
    average.answered += cell->answered;
    for (const auto& [status, n] : cell->statuses) average.statuses[status] += n;
  }
  average.mae_m = sum_m / static_cast<double>(groups.size());
  return average;
}

void set_interval(SummaryCell& cell, const CellInterval& interval) {
  cell.mae_low_m = interval.low_m;
  cell.mae_high_m = interval.high_m;
  cell.clusters = interval.clusters;
  cell.one_frame_m = interval.one_frame_m;
}

void add_method(ResultsSummary& summary, const CellIndex& index, const Names& names,
                const std::vector<std::size_t>& groups, MethodIntervals found) {
  std::vector<SummaryCell> averages;
  for (std::size_t k = 0; k < found.cells.size(); ++k) {
    const CellInterval& interval = found.cells[k];
    const bool is_average = interval.group == summary.groups.size();
    const std::string group = is_average ? kAverageGroup : summary.groups[interval.group];
    const std::string& alignment = summary.alignments[interval.alignment];
    if (is_average) {
      averages.push_back(average_cell(summary, index, names, groups, interval));
      set_interval(averages.back(), interval);
    } else if (SummaryCell* cell = index.find(summary, names.method, names.condition, group, alignment)) {
      set_interval(*cell, interval);
    }
    if (found.differences.empty()) continue;
    DifferenceCell& difference = found.differences[k];
    difference.method = names.method;
    difference.condition = names.condition;
    difference.group = group;
    difference.alignment = alignment;
    summary.differences.push_back(std::move(difference));
  }
  summary.cells.insert(summary.cells.end(), averages.begin(), averages.end());
}

void add_bodies_and_truth(const ConditionTakes& condition, const StatisticsLayout& layout,
                          const std::string& activity, const std::vector<std::size_t>& groups,
                          double clock_error_s, ResultsSummary& summary) {
  std::vector<BodyCell> bodies(layout.axes.methods);
  parallel_for_index(bodies.size(), 1, [&](std::size_t m) { bodies[m] = body_cell(condition, m); });
  for (std::size_t m = 0; m < bodies.size(); ++m) {
    bodies[m].method = summary.methods[m];
    bodies[m].condition = activity;
    bodies[m].alignment = summary.alignments[layout.body_alignment];
    summary.bodies.push_back(bodies[m]);
  }
  if (summary.left_out) return;  // a floor is of mocap
  for (const std::size_t g : groups) {
    TruthFloor floor = truth_floor(condition, g, clock_error_s);
    floor.condition = activity;
    floor.group = summary.groups[g];
    summary.truth_floor.push_back(std::move(floor));
  }
}

// The takes of an activity that have samples, and whose they are.
ConditionTakes takes_of(const Plan& plan, const RunOutcome& outcome, const std::string& activity,
                        std::span<const TakeSummary> summaries) {
  std::vector<const TakeStatistics*> takes;
  std::vector<std::size_t> participants;
  std::vector<std::string> names;
  for (std::size_t t = 0; t < plan.takes.size(); ++t) {
    const Take& take = plan.takes[t].take;
    if (take.activity != activity || !outcome.evaluated[t] || summaries[t].statistics.cells.rows() == 0)
      continue;
    auto name = std::find(names.begin(), names.end(), take.participant);
    if (name == names.end()) name = names.insert(names.end(), take.participant);
    takes.push_back(&summaries[t].statistics);
    participants.push_back(static_cast<std::size_t>(name - names.begin()));
  }
  return condition_takes(std::move(takes), std::move(participants), {plan.study.resamples, 1});
}

void add_activity(const ConditionTakes& condition, const StatisticsLayout& layout, const Plan& plan,
                  const std::string& activity, const CellIndex& index, ResultsSummary& summary) {
  const Axes& axes = layout.axes;
  for (std::size_t set = 0; set < axes.sets; ++set) {
    const std::string name = set == 0 ? activity : occluded_condition(activity);
    const std::vector<std::size_t> groups = asked_groups(summary, name);
    if (groups.empty()) continue;
    std::vector<MethodIntervals> found(axes.methods);
    parallel_for_index(axes.methods, 1, [&](std::size_t m) {
      found[m] = method_intervals(condition, layout, set, m, groups);
    });
    for (std::size_t m = 0; m < axes.methods; ++m)
      add_method(summary, index, {summary.methods[m], name}, groups, std::move(found[m]));
    if (set == 0)
      add_bodies_and_truth(condition, layout, activity, groups, plan.study.clock_error_s, summary);
  }
}

}  // namespace

void add_statistics(const Plan& plan, const RunOutcome& outcome, const StatisticsLayout& layout,
                    std::span<const TakeSummary> takes, ResultsSummary& summary) {
  summary.resamples = plan.study.resamples;
  summary.block_s = static_cast<double>(layout.block_instants) / layout.rate_hz;
  const CellIndex index(summary);
  for (const std::string& activity : activities_of(plan))
    add_activity(takes_of(plan, outcome, activity, takes), layout, plan, activity, index, summary);
}

}  // namespace trilat
