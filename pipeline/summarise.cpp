// SPDX-License-Identifier: MIT
#include "pipeline/summarise.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "datasets/base/check.h"
#include "datasets/results/samples.h"
#include "evaluators/metrics/error_statistics.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 1024;

struct Axes {
  std::size_t joints, methods, groups, alignments;
  std::vector<std::size_t> group_of_joint;
  std::size_t cell(std::size_t group, std::size_t method, std::size_t alignment) const {
    return (group * methods + method) * alignments + alignment;
  }
  std::size_t cells() const { return groups * methods * alignments; }
};

// One take's alignments: by alignment, then joint (one entry for rigid), then method.
using TakeAlignments = std::vector<std::vector<Alignment>>;

struct SampleView {
  const SampleBlock& block;
  const Axes& axes;
  std::size_t slot(std::uint64_t i, std::size_t j, std::size_t m) const {
    return (i * axes.joints + j) * axes.methods + m;
  }
  Eigen::Vector3d truth(std::uint64_t i, std::size_t j) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.truth_m[(i * axes.joints + j) * 3]);
  }
  Eigen::Vector3d estimate(std::size_t slot) const {
    return Eigen::Map<const Eigen::Vector3d>(&block.estimate_m[slot * 3]);
  }
  SolveStatus status(std::size_t slot) const { return static_cast<SolveStatus>(block.status[slot]); }
};

// Calls visit(i, j, m, slot, view) for every sample that has a truth, and end_block(block) behind each block.
template <class Visit, class EndBlock>
void stream_take(const SamplesFile& samples, std::size_t take, const Axes& axes, SampleColumns columns,
                 const Visit& visit, const EndBlock& end_block) {
  const std::uint64_t instants = samples.header().takes[take].instants;
  for (std::uint64_t first = 0; first < instants; first += kBlock) {
    const SampleBlock block = samples.read(take, first, std::min(kBlock, instants - first), columns);
    const SampleView view{block, axes};
    for (std::uint64_t i = 0; i < block.instants; ++i)
      for (std::size_t j = 0; j < axes.joints; ++j) {
        if (!view.truth(i, j).allFinite()) continue;
        for (std::size_t m = 0; m < axes.methods; ++m) visit(i, j, m, view.slot(i, j, m), view);
      }
    end_block(block);
  }
}

constexpr auto kNothing = [](const SampleBlock&) {};

TakeAlignments align_take(const SamplesFile& samples, std::size_t take, const Axes& axes,
                          const std::vector<AlignmentKind>& kinds) {
  std::vector<AlignmentSums> sums(axes.joints * axes.methods);
  stream_take(
      samples, take, axes, SampleColumns::positions,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        if (is_usable(view.status(slot)))
          sums[j * axes.methods + m].add(view.estimate(slot), view.truth(i, j));
      },
      kNothing);
  TakeAlignments result;
  for (AlignmentKind kind : kinds) {
    std::vector<Alignment> solved(axes.joints * axes.methods);
    for (std::size_t m = 0; m < axes.methods; ++m) {
      AlignmentSums whole;
      for (std::size_t j = 0; j < axes.joints; ++j) whole.merge(sums[j * axes.methods + m]);
      for (std::size_t j = 0; j < axes.joints; ++j)
        solved[j * axes.methods + m] =
            solve_alignment(kind == AlignmentKind::rigid ? whole : sums[j * axes.methods + m], kind);
    }
    result.push_back(std::move(solved));
  }
  return result;
}

struct AlignedError {
  SolveStatus status;
  Eigen::Vector3d error_m;
};

// The error after alignment. A usable estimate whose alignment failed has no error and counts as not solved.
AlignedError error_of(const SampleView& view, std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot,
                      const std::vector<Alignment>& alignment) {
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(kNaN);
  const SolveStatus status = view.status(slot);
  if (!is_usable(status)) return {status, none};
  const Alignment& a = alignment[j * view.axes.methods + m];
  if (a.status != AlignmentStatus::aligned) return {SolveStatus::not_solved, none};
  return {status, a.truth_from_estimate * view.estimate(slot) - view.truth(i, j)};
}

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

// Adds one take to sums and writes the error column of the first alignment.
TakeSums sum_take(SamplesFile& samples, std::size_t take, const Axes& axes,
                  const TakeAlignments& alignments) {
  TakeSums sums(axes.cells());
  const std::uint64_t instants = samples.header().takes[take].instants;
  std::vector<float> errors;
  const auto fresh = [&](std::uint64_t count) {
    errors.assign(count * axes.joints * axes.methods * 3, std::numeric_limits<float>::quiet_NaN());
  };
  fresh(std::min(kBlock, instants));
  stream_take(
      samples, take, axes, SampleColumns::all,
      [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
        for (std::size_t a = 0; a < axes.alignments; ++a) {
          const AlignedError e = error_of(view, i, j, m, slot, alignments[a]);
          sums.add(axes.cell(axes.group_of_joint[j], m, a), e, view.block, slot);
          for (int axis = 0; a == 0 && axis < 3; ++axis)
            errors[slot * 3 + static_cast<std::size_t>(axis)] = static_cast<float>(e.error_m[axis]);
        }
      },
      [&](const SampleBlock& block) {
        samples.write_errors(take, block.first_instant, errors);
        fresh(std::min(kBlock, instants - block.first_instant - block.instants));
      });
  return sums;
}

// One pass of all takes of a condition over the quantiles of cells [first, first + selections.size()).
void quantile_pass(const SamplesFile& samples, const std::vector<std::size_t>& takes, const Axes& axes,
                   const std::vector<TakeAlignments>& alignments, std::size_t first,
                   std::vector<QuantileSelection>& selections) {
  tbb::enumerable_thread_specific<std::vector<QuantileSelection>> local(selections);
  tbb::parallel_for(std::size_t{0}, takes.size(), [&](std::size_t t) {
    std::vector<QuantileSelection>& mine = local.local();
    stream_take(
        samples, takes[t], axes, SampleColumns::positions,
        [&](std::uint64_t i, std::size_t j, std::size_t m, std::size_t slot, const SampleView& view) {
          for (std::size_t a = 0; a < axes.alignments; ++a) {
            const std::size_t cell = axes.cell(axes.group_of_joint[j], m, a);
            if (cell < first || cell >= first + mine.size()) continue;
            const AlignedError e = error_of(view, i, j, m, slot, alignments[takes[t]][a]);
            if (is_usable(e.status)) mine[cell - first].add(e.error_m.norm());
          }
        },
        kNothing);
  });
  for (const auto& mine : local)
    for (std::size_t c = 0; c < selections.size(); ++c) selections[c].merge_pass(mine[c]);
  for (QuantileSelection& selection : selections) selection.end_pass();
}

// Cells are taken in batches, so that the histograms of all threads stay below about 60 MB.
std::vector<QuantileSelection> quantiles_of_condition(const SamplesFile& samples,
                                                      const std::vector<std::size_t>& takes, const Axes& axes,
                                                      const std::vector<TakeAlignments>& alignments) {
  constexpr std::size_t kCellBytes = 100'000, kBudgetBytes = 60'000'000;
  const auto threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t batch = std::max<std::size_t>(1, kBudgetBytes / (kCellBytes * (threads + 1)));
  std::vector<QuantileSelection> all;
  for (std::size_t first = 0; first < axes.cells(); first += batch) {
    std::vector<QuantileSelection> selections(std::min(batch, axes.cells() - first),
                                              QuantileSelection(kErrorQuantiles));
    while (!selections.front().done()) quantile_pass(samples, takes, axes, alignments, first, selections);
    std::move(selections.begin(), selections.end(), std::back_inserter(all));
  }
  return all;
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
  result.median_m = s.median_m;
  result.p90_m = s.p90_m;
  result.p95_m = s.p95_m;
  result.max_m = s.max_m;
  if (sums.with_gdop[cell] > 0)
    result.mean_gdop = sums.gdop[cell].value() / static_cast<double>(sums.with_gdop[cell]);
  if (result.answered > 0)
    result.mean_iterations = sums.iterations[cell].value() / static_cast<double>(result.answered);
  return result;
}

void add_condition(const SamplesFile& samples, const std::vector<std::size_t>& takes, const Axes& axes,
                   const std::vector<TakeAlignments>& alignments, const std::vector<TakeSums>& by_take,
                   const std::string& condition, ResultsSummary& summary) {
  TakeSums sums(axes.cells());
  for (std::size_t t : takes) sums.merge(by_take[t]);
  const auto quantiles = quantiles_of_condition(samples, takes, axes, alignments);
  for (std::size_t g = 0; g < axes.groups; ++g)
    for (std::size_t m = 0; m < axes.methods; ++m)
      for (std::size_t a = 0; a < axes.alignments; ++a) {
        SummaryCell cell = cell_of(sums, axes.cell(g, m, a), quantiles[axes.cell(g, m, a)]);
        if (cell.asked == 0) continue;
        cell.condition = condition;
        cell.group = summary.groups[g];
        cell.method = summary.methods[m];
        cell.alignment = summary.alignments[a];
        summary.cells.push_back(std::move(cell));
      }
}

Axes axes_of(const Plan& plan, std::vector<std::string>& groups) {
  Axes axes{plan.joints.size(), plan.methods.size(), 0, plan.study.alignments.size(), {}};
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
  for (const PlannedTake& take : plan.takes) {
    participants.insert(take.take.participant);
    if (std::find(summary.conditions.begin(), summary.conditions.end(), take.take.activity) ==
        summary.conditions.end())
      summary.conditions.push_back(take.take.activity);
  }
  summary.participants = participants.size();
  for (const Method& method : plan.methods) summary.methods.push_back(method.spec.name);
  for (AlignmentKind kind : plan.study.alignments) summary.alignments.emplace_back(name_of(kind));
  summary.notes = outcome.notes;
  summary.cross_check = outcome.cross_check;
  return summary;
}

}  // namespace

ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, SamplesFile& samples) {
  ResultsSummary summary = empty_summary(plan, outcome);
  const Axes axes = axes_of(plan, summary.groups);
  std::vector<TakeAlignments> alignments(plan.takes.size());
  std::vector<TakeSums> sums(plan.takes.size(), TakeSums(axes.cells()));
  tbb::parallel_for(std::size_t{0}, plan.takes.size(), [&](std::size_t t) {
    alignments[t] = align_take(samples, t, axes, plan.study.alignments);
    sums[t] = sum_take(samples, t, axes, alignments[t]);
  });
  for (const std::string& condition : summary.conditions) {
    std::vector<std::size_t> takes;
    for (std::size_t t = 0; t < plan.takes.size(); ++t)
      if (plan.takes[t].take.activity == condition) takes.push_back(t);
    add_condition(samples, takes, axes, alignments, sums, condition, summary);
  }
  return summary;
}

}  // namespace trilat
