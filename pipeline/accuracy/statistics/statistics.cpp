// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "datasets/results/summary.h"
#include "evaluators/metrics/body_metrics.h"
#include "pipeline/accuracy/statistics/take_statistics.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// The takes of one activity that were evaluated, and what counts as one cluster of their samples: all of a
// participant; of fewer than three participants a take; of a single take each of its time blocks.
struct ConditionTakes {
  std::vector<const TakeStatistics*> takes;
  std::vector<std::size_t> cluster;  // by take
  bool blocks = false;               // each block of the one take is a cluster
  std::size_t clusters = 0;

  // Adds the sums that `of` gives of every take, blocks x columns, to those of its cluster.
  template <class Of>
  RowMatrix cluster_sums(std::size_t columns, const Of& of) const {
    RowMatrix sums = RowMatrix::Zero(static_cast<Eigen::Index>(clusters), static_cast<Eigen::Index>(columns));
    for (std::size_t t = 0; t < takes.size(); ++t) {
      const auto rows = of(*takes[t]);
      if (blocks)
        sums = rows;
      else
        sums.row(static_cast<Eigen::Index>(cluster[t])) += rows.colwise().sum();
    }
    return sums;
  }
};

// What the intervals of one method are, in one set of samples.
struct CellInterval {
  std::size_t group = 0;  // that of the axes, or their number: the average
  std::size_t alignment = 0;
  double low_m = kNoNumber, high_m = kNoNumber;
  std::uint64_t clusters = 0;
};
struct MethodIntervals {
  std::vector<CellInterval> cells;
  std::vector<DifferenceCell> differences;  // without names; empty for the reference
};

using Eigen::Index;

Index as_index(std::size_t i) { return static_cast<Index>(i); }

// The sums of one method by alignment, group and column, gathered from all takes.
RowMatrix cell_sums(const ConditionTakes& condition, const StatisticsLayout& layout, std::size_t set,
                    std::size_t method, const std::vector<std::size_t>& groups) {
  const Axes& axes = layout.axes;
  const std::size_t columns = axes.alignments * groups.size() * CellColumns::count;
  return condition.cluster_sums(columns, [&](const TakeStatistics& take) {
    RowMatrix sums(take.cells.rows(), as_index(columns));
    for (std::size_t a = 0; a < axes.alignments; ++a)
      for (std::size_t g = 0; g < groups.size(); ++g)
        sums.middleCols(as_index((a * groups.size() + g) * CellColumns::count),
                        as_index(CellColumns::count)) =
            take.cells.middleCols(as_index(axes.cell(set, groups[g], method, a) * CellColumns::count),
                                  as_index(CellColumns::count));
    return sums;
  });
}

// The ratios and quantities of every alignment: distances, differences and percentages of each group, then of
// their average.
struct Wanted {
  std::vector<RatioColumns> ratios;
  std::vector<RatioQuantity> quantities;
};

Wanted wanted_of(std::size_t alignments, std::size_t groups, bool with_differences) {
  Wanted wanted;
  for (std::size_t a = 0; a < alignments; ++a) {
    const std::size_t distances = wanted.ratios.size();
    const std::size_t differences = distances + groups, references = differences + groups;
    const auto add_ratios = [&](std::size_t numerator, std::size_t denominator) {
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t first = (a * groups + g) * CellColumns::count;
        wanted.ratios.push_back({first + numerator, first + denominator});
      }
    };
    const auto add_quantities = [&](std::size_t group, std::size_t count) {
      wanted.quantities.push_back({{distances + group, count}});
      if (!with_differences) return;
      wanted.quantities.push_back({{differences + group, count}});
      wanted.quantities.push_back({{differences + group, count}, RatioRange{references + group, count}});
    };
    add_ratios(CellColumns::distance, CellColumns::answered);
    if (with_differences) {
      add_ratios(CellColumns::difference, CellColumns::both);
      add_ratios(CellColumns::reference, CellColumns::both);
    }
    for (std::size_t g = 0; g < groups; ++g) add_quantities(g, 1);
    if (groups >= 2) add_quantities(0, groups);
  }
  return wanted;
}

// A mean distance is not negative, whatever the width of its interval; NaN stays.
double not_below_zero(double distance_m) { return distance_m < 0.0 ? 0.0 : distance_m; }

DifferenceCell difference_of(const IntervalEstimate& difference, const IntervalEstimate& share) {
  DifferenceCell cell;
  cell.clusters = difference.clusters;
  cell.difference_m = difference.value;
  cell.low_m = difference.low;
  cell.high_m = difference.high;
  cell.percent_of_reference = 100.0 * share.value;
  cell.percent_low = 100.0 * share.low;
  cell.percent_high = 100.0 * share.high;
  cell.percent_of_method = 100.0 * share.value / (1.0 + share.value);
  if (!std::isfinite(cell.percent_of_method)) cell.percent_of_method = kNoNumber;
  return cell;
}

// By alignment and group, each followed by the average of the groups when there are two or more. `groups`:
// those that were asked for.
MethodIntervals method_intervals(const ConditionTakes& condition, const StatisticsLayout& layout,
                                 std::size_t set, std::size_t method,
                                 const std::vector<std::size_t>& groups) {
  const bool with_differences = method != layout.reference;
  const RowMatrix sums = cell_sums(condition, layout, set, method, groups);
  const Wanted wanted = wanted_of(layout.axes.alignments, groups.size(), with_differences);
  const auto found = student_intervals(sums, wanted.ratios, wanted.quantities);
  MethodIntervals result;
  std::size_t next = 0;
  for (std::size_t a = 0; a < layout.axes.alignments; ++a) {
    std::uint64_t both_sum = 0;
    for (std::size_t g = 0; g < groups.size() + (groups.size() >= 2 ? 1 : 0); ++g) {
      const bool is_average = g == groups.size();
      const IntervalEstimate& e = found[next++];
      CellInterval cell;
      cell.group = is_average ? layout.axes.groups : groups[g];
      cell.alignment = a;
      cell.low_m = not_below_zero(e.low);
      cell.high_m = e.high;
      cell.clusters = e.clusters;
      result.cells.push_back(cell);
      if (!with_differences) continue;
      DifferenceCell difference = difference_of(found[next], found[next + 1]);
      next += 2;
      const std::size_t column = (a * groups.size() + g) * CellColumns::count + CellColumns::both;
      difference.n = is_average ? both_sum : static_cast<std::uint64_t>(sums.col(as_index(column)).sum());
      both_sum += difference.n;
      result.differences.push_back(difference);
    }
  }
  return result;
}

// Without names.
BodyCell body_cell(const ConditionTakes& condition, std::size_t method) {
  const RowMatrix sums = condition.cluster_sums(BodySumColumns::count, [&](const TakeStatistics& take) {
    return RowMatrix(
        take.bodies.middleCols(as_index(method * BodySumColumns::count), as_index(BodySumColumns::count)));
  });
  TakeBodies bodies;
  Mean truth_jerk_m_s3;
  for (const TakeStatistics* take : condition.takes) {
    const TakeBodies& here = take->of_method[method];
    for (std::size_t r = 0; r < bodies.within.size(); ++r) bodies.within[r] += here.within[r];
    bodies.joints += here.joints;
    bodies.bones = std::max(bodies.bones, here.bones);
    bodies.bone_sd_m.merge(here.bone_sd_m);
    bodies.jerk_m_s3.merge(here.jerk_m_s3);
    truth_jerk_m_s3.merge(take->truth_jerk_m_s3);
  }
  const std::vector<RatioColumns> ratios{{BodySumColumns::mpjpe, BodySumColumns::whole},
                                         {BodySumColumns::pa_mpjpe, BodySumColumns::pa_whole}};
  const std::vector<RatioQuantity> quantities{{{0, 1}}, {{1, 1}}};
  const auto found = student_intervals(sums, ratios, quantities);
  BodyCell cell;
  cell.instants = static_cast<std::uint64_t>(sums.col(as_index(BodySumColumns::whole)).sum());
  cell.clusters = found[0].clusters;
  cell.mpjpe_m = found[0].value;
  cell.mpjpe_low_m = not_below_zero(found[0].low);
  cell.mpjpe_high_m = found[0].high;
  cell.pa_mpjpe_m = found[1].value;
  cell.pa_mpjpe_low_m = not_below_zero(found[1].low);
  cell.pa_mpjpe_high_m = found[1].high;
  for (std::size_t r = 0; bodies.joints > 0 && r < cell.pck.size(); ++r)
    cell.pck[r] = static_cast<double>(bodies.within[r]) / static_cast<double>(bodies.joints);
  cell.bones = bodies.bones;
  cell.bone_length_sd_m = bodies.bone_sd_m.value();
  cell.jitter_m_s3 = bodies.jerk_m_s3.value();
  cell.truth_jitter_m_s3 = truth_jerk_m_s3.value();
  return cell;
}

double truth_speed_m_s(const ConditionTakes& condition, std::size_t group) {
  Mean speed_m_s;
  for (const TakeStatistics* take : condition.takes) speed_m_s.merge(take->truth_speed_m_s[group]);
  return speed_m_s.value();
}

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
    if (std::ranges::any_of(summary.cells, [&](const SummaryCell& cell) {
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
                          ResultsSummary& summary) {
  std::vector<BodyCell> bodies(layout.axes.methods);
  parallel_for_index(bodies.size(), 1, [&](std::size_t m) { bodies[m] = body_cell(condition, m); });
  for (std::size_t m = 0; m < bodies.size(); ++m) {
    bodies[m].method = summary.methods[m];
    bodies[m].condition = activity;
    bodies[m].alignment = summary.alignments[layout.body_alignment];
    summary.bodies.push_back(bodies[m]);
  }
  if (summary.left_out()) return;  // a sensor stands for the truth
  for (const std::size_t g : groups)
    summary.truth_speed.push_back({activity, summary.groups[g], truth_speed_m_s(condition, g)});
}

ConditionTakes takes_of(const Plan& plan, const RunOutcome& outcome, const std::string& activity,
                        std::size_t participants, std::span<const TakeSummary> summaries) {
  ConditionTakes condition;
  std::vector<std::string> names;
  for (std::size_t t = 0; t < plan.takes.size(); ++t) {
    const Take& take = plan.takes[t].take;
    if (take.activity != activity || !outcome.evaluated[t] || summaries[t].statistics.cells.rows() == 0)
      continue;
    const std::string& cluster = participants < kFewestParticipants ? take.id : take.participant;
    auto name = std::ranges::find(names, cluster);
    if (name == names.end()) name = names.insert(names.end(), cluster);
    condition.takes.push_back(&summaries[t].statistics);
    condition.cluster.push_back(static_cast<std::size_t>(name - names.begin()));
  }
  condition.blocks = participants < kFewestParticipants && condition.takes.size() == 1;
  condition.clusters =
      condition.blocks ? static_cast<std::size_t>(condition.takes[0]->cells.rows()) : names.size();
  return condition;
}

void add_activity(const ConditionTakes& condition, const StatisticsLayout& layout,
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
    if (set == 0) add_bodies_and_truth(condition, layout, activity, groups, summary);
  }
}

}  // namespace

void add_statistics(const Plan& plan, const RunOutcome& outcome, const StatisticsLayout& layout,
                    std::span<const TakeSummary> takes, ResultsSummary& summary) {
  const CellIndex index(summary);
  for (const std::string& activity : activities_of(plan))
    add_activity(takes_of(plan, outcome, activity, summary.participants, takes), layout, activity, index,
                 summary);
}

}  // namespace trilat
