// SPDX-License-Identifier: MIT
#include "pipeline/summarise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include <tbb/task_arena.h>

#include "evaluators/metrics/error_statistics.h"
#include "pipeline/aligned_errors.h"
#include "pipeline/parallel.h"
#include "pipeline/spilled_values.h"
#include "pipeline/statistics.h"

namespace trilat {
namespace {

// Everything one take adds to the cells of its condition.
struct TakeSums {
  std::vector<ErrorSums> errors;
  std::vector<CompensatedSum> gdop, iterations;
  std::vector<std::uint64_t> with_gdop;

  explicit TakeSums(std::size_t cells) : errors(cells), gdop(cells), iterations(cells), with_gdop(cells) {}
  void add(std::size_t cell, const AlignedError& e, const SampleBlock& block, std::size_t slot) {
    errors[cell].add(e.status, e.error_m);
    if (!is_usable(e.status)) return;
    iterations[cell].add(block.iterations[slot]);
    const float value = block.gdop[slot];
    if (!std::isfinite(value)) return;
    gdop[cell].add(static_cast<double>(value));
    ++with_gdop[cell];
  }
  void merge(const TakeSums& later) {
    for (std::size_t c = 0; c < errors.size(); ++c) {
      errors[c].merge(later.errors[c]);
      gdop[c].merge(later.gdop[c]);
      iterations[c].merge(later.iterations[c]);
      with_gdop[c] += later.with_gdop[c];
    }
  }
};

// Adds one take to sums, writes the error column of the first alignment, and gives away the distances of
// answered samples: to the groups of its condition, which begin at `first_group` with a cell each.
TakeSums sum_take(SamplesFile& samples, std::size_t take, const Axes& axes, const TakeAlignments& alignments,
                  SpilledValues::Writer distances_m, std::size_t first_group) {
  TakeSums sums(axes.cells());
  std::vector<float> errors;
  const auto visit = [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot,
                         const SampleView& view) {
    errors.resize(view.block.status.size() * 3, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t a = 0; a < axes.alignments; ++a) {
      const AlignedError e = error_of(view, i, j, m, slot, alignments[a].own);
      if (!e.asked) continue;
      for (std::size_t set = 0; set < view.sets(i, j); ++set) {
        const std::size_t cell = axes.cell(set, axes.group_of_joint[j], m, a);
        sums.add(cell, e, view.block, slot);
        if (is_usable(e.status)) distances_m.add(first_group + cell, e.error_m.norm());
      }
      for (int axis = 0; a == 0 && axis < 3; ++axis)
        errors[slot * 3 + static_cast<std::size_t>(axis)] = static_cast<float>(e.error_m[axis]);
    }
  };
  stream_take(samples, take, axes, SampleColumns::all, visit, [&](const SampleBlock& block) {
    errors.resize(block.status.size() * 3, std::numeric_limits<float>::quiet_NaN());
    samples.write_errors(take, block.first_instant, errors);
    errors.clear();
  });
  distances_m.finish();
  return sums;
}

std::vector<QuantileSelection> quantiles_of(const SpilledValues& distances_m, std::size_t first_group,
                                            std::size_t cells) {
  std::vector<QuantileSelection> selections(cells, QuantileSelection(kErrorQuantiles));
  parallel_for_index(cells, 1, [&](std::size_t cell) {
    while (!selections[cell].done()) {
      distances_m.visit(first_group + cell, [&](std::span<const double> values_m) {
        for (double distance_m : values_m) selections[cell].add(distance_m);
      });
      selections[cell].end_pass();
    }
  });
  return selections;
}

SummaryCell cell_of(const TakeSums& sums, std::size_t cell, const QuantileSelection& quantiles) {
  const ErrorStatistics s = ErrorStatistics::of(sums.errors[cell], quantiles);
  SummaryCell result;
  result.asked = static_cast<std::uint64_t>(s.asked);
  result.answered = static_cast<std::uint64_t>(s.answered);
  for (std::size_t status = 0; status < s.status_counts.size(); ++status)
    if (s.status_counts[status] > 0)
      result.statuses[std::string(name_of(static_cast<SolveStatus>(status)))] =
          static_cast<std::uint64_t>(s.status_counts[status]);
  result.mae_m = s.mae_m;
  result.axis_mae_m = {s.axis_mae_m.x(), s.axis_mae_m.y(), s.axis_mae_m.z()};
  result.rmse_m = s.rmse_m;
  result.p05_m = s.p05_m;
  result.p25_m = s.p25_m;
  result.median_m = s.median_m;
  result.p75_m = s.p75_m;
  result.p90_m = s.p90_m;
  result.p95_m = s.p95_m;
  result.max_m = s.max_m;
  if (sums.with_gdop[cell] > 0)
    result.mean_gdop = sums.gdop[cell].value() / static_cast<double>(sums.with_gdop[cell]);
  if (result.answered > 0)
    result.mean_iterations = sums.iterations[cell].value() / static_cast<double>(result.answered);
  return result;
}

void add_condition(const std::vector<QuantileSelection>& quantiles, const std::vector<std::size_t>& takes,
                   const Axes& axes, const std::vector<TakeSums>& by_take, const std::string& activity,
                   ResultsSummary& summary) {
  TakeSums sums(axes.cells());
  for (std::size_t t : takes) sums.merge(by_take[t]);
  for (std::size_t c = 0; c < axes.cells(); ++c) {
    SummaryCell cell = cell_of(sums, c, quantiles[c]);
    if (cell.asked == 0) continue;
    cell.alignment = summary.alignments[c % axes.alignments];
    cell.method = summary.methods[c / axes.alignments % axes.methods];
    cell.group = summary.groups[c / (axes.alignments * axes.methods) % axes.groups];
    const bool all = c < axes.cells() / axes.sets;
    cell.condition = all ? activity : occluded_condition(activity);
    summary.cells.push_back(std::move(cell));
  }
}

Axes axes_of(const Plan& plan, std::vector<std::string>& groups) {
  Axes axes;
  axes.joints = plan.joints.size();
  axes.methods = plan.methods.size();
  axes.alignments = plan.study.alignments.size();
  axes.sets = plan.study.occluded_apart ? 2 : 1;
  for (Joint joint : plan.joints) {
    const std::string group = table_group(joint);
    auto found = std::find(groups.begin(), groups.end(), group);
    if (found == groups.end()) found = groups.insert(groups.end(), group);
    axes.group_of_joint.push_back(static_cast<std::size_t>(found - groups.begin()));
  }
  axes.groups = groups.size();
  return axes;
}

ResultsSummary empty_summary(const Plan& plan, const RunOutcome& outcome) {
  ResultsSummary summary;
  summary.study = plan.study.name;
  summary.campaign = plan.campaign.name;
  summary.simulated = plan.simulated;
  summary.takes = plan.takes.size();
  summary.takes_failed =
      static_cast<std::uint64_t>(std::count(outcome.evaluated.begin(), outcome.evaluated.end(), false));
  std::set<std::string> participants;
  for (const PlannedTake& take : plan.takes) participants.insert(take.take.participant);
  for (const std::string& activity : activities_of(plan)) {
    summary.conditions.push_back(activity);
    if (plan.study.occluded_apart) summary.conditions.push_back(occluded_condition(activity));
  }
  summary.participants = participants.size();
  for (const Method& method : plan.methods) summary.methods.push_back(method.spec.name);
  summary.reference = plan.methods[plan.reference].spec.name;
  for (AlignmentKind kind : plan.study.alignments) summary.alignments.emplace_back(name_of(kind));
  summary.notes = outcome.notes;
  summary.cross_check = outcome.cross_check;
  return summary;
}

}  // namespace

ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, SamplesFile& samples,
                         std::uint64_t budget_bytes, const std::function<void(double)>& progress) {
  ResultsSummary summary = empty_summary(plan, outcome);
  const Axes axes = axes_of(plan, summary.groups);
  const std::vector<std::string> activities = activities_of(plan);
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  SpilledValues distances_m(activities.size() * axes.cells(), samples.path().parent_path(), budget_bytes,
                            threads);
  std::vector<TakeAlignments> alignments(plan.takes.size());
  std::vector<TakeSums> sums(plan.takes.size(), TakeSums(axes.cells()));
  parallel_for_index(plan.takes.size(), 1, [&](std::size_t t) {
    const auto activity = std::find(activities.begin(), activities.end(), plan.takes[t].take.activity);
    const auto first_group = static_cast<std::size_t>(activity - activities.begin()) * axes.cells();
    alignments[t] =
        align_take(samples, t, axes, plan.study.alignments, plan.study.training_share, plan.reference);
    sums[t] = sum_take(samples, t, axes, alignments[t], SpilledValues::Writer(distances_m), first_group);
  });
  if (progress) progress(0.5);
  for (std::size_t a = 0; a < activities.size(); ++a) {
    std::vector<std::size_t> takes;
    for (std::size_t t = 0; t < plan.takes.size(); ++t)
      if (plan.takes[t].take.activity == activities[a]) takes.push_back(t);
    add_condition(quantiles_of(distances_m, a * axes.cells(), axes.cells()), takes, axes, sums, activities[a],
                  summary);
  }
  if (progress) progress(0.6);
  add_statistics(plan, outcome, samples, axes, alignments, summary);
  if (progress) progress(1.0);
  return summary;
}

}  // namespace trilat
