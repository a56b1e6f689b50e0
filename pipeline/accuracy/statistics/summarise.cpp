// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/summarise.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "evaluators/metrics/error_statistics.h"
#include "pipeline/accuracy/statistics/aligned_errors.h"
#include "pipeline/accuracy/statistics/participant_errors.h"
#include "pipeline/accuracy/statistics/statistics.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr double kTakesShare = 0.8, kCellsShare = 0.9;  // of the progress, at the end of each

// `distances_m`: |error| of the answered samples.
SummaryCell cell_of(const CellSums& sums, std::vector<double> distances_m) {
  const ErrorSums& errors = sums.errors;
  TRILAT_CHECK(std::ssize(distances_m) == errors.answered(), "distances are of the same samples");
  SummaryCell result;
  result.asked = static_cast<std::uint64_t>(errors.asked());
  result.answered = static_cast<std::uint64_t>(errors.answered());
  for (std::size_t k = 0; k < kSolveStatusCount; ++k)
    if (const auto status = static_cast<SolveStatus>(k); errors.count_of(status) > 0)
      result.statuses[std::string(name_of(status))] = static_cast<std::uint64_t>(errors.count_of(status));
  result.mae_m = errors.mae_m();
  Eigen::Map<Eigen::Vector3d>(result.axis_mae_m.data()) = errors.axis_mae_m();
  result.rmse_m = errors.rmse_m();
  result.max_m = errors.max_m();
  const auto q = quantiles_of(std::move(distances_m), {0.05, 0.25, 0.5, 0.75, 0.9, 0.95});
  std::tie(result.p05_m, result.p25_m, result.median_m) = std::tie(q[0], q[1], q[2]);
  std::tie(result.p75_m, result.p90_m, result.p95_m) = std::tie(q[3], q[4], q[5]);
  if (result.asked > 0) result.mean_iterations = sums.iterations.value() / static_cast<double>(result.asked);
  return result;
}

// Takes the distances of its takes.
void add_condition(std::span<TakeSummary* const> takes, const Axes& axes, const std::string& activity,
                   ResultsSummary& summary) {
  std::vector<SummaryCell> cells(axes.cells());
  parallel_for_index(axes.cells(), 1, [&](std::size_t c) {
    CellSums sums;
    std::vector<double> all_m;
    for (const TakeSummary* take : takes) sums.merge(take->statistics.sums[c]);
    all_m.reserve(static_cast<std::size_t>(sums.errors.answered()));
    for (TakeSummary* take : takes) {
      const std::vector<double> of_take_m = std::exchange(take->distances_m[c], {});
      all_m.insert(all_m.end(), of_take_m.begin(), of_take_m.end());
    }
    cells[c] = cell_of(sums, std::move(all_m));
  });
  for (std::size_t c = 0; c < axes.cells(); ++c) {
    SummaryCell& cell = cells[c];
    if (cell.asked == 0) continue;
    cell.alignment = summary.alignments[c % axes.alignments];
    cell.method = summary.methods[c / axes.alignments % axes.methods];
    cell.group = summary.groups[c / (axes.alignments * axes.methods) % axes.groups];
    const bool all = c < axes.cells() / axes.sets;
    cell.condition = all ? activity : occluded_condition(activity);
    summary.cells.push_back(std::move(cell));
  }
}

PairedErrors errors_of(const PairedSums& sums) {
  return {sums.method_m.n, sums.method_m.value(), sums.reference_m.value()};
}

void add_take_rows(const Plan& plan, const StatisticsLayout& layout, std::size_t take,
                   const TakeStatistics& statistics, ResultsSummary& summary) {
  const Take& of = plan.takes[take].take;
  const Axes& axes = layout.axes;
  for (std::size_t k = 0; k < statistics.of_joint.size(); ++k) {
    const JointSums& sums = statistics.of_joint[k];
    if (sums.asked == 0) continue;
    const std::size_t j = k / axes.methods % axes.joints;
    const bool all = k < axes.joints * axes.methods;
    summary.by_take.push_back({of.id,
                               of.participant,
                               all ? of.activity : occluded_condition(of.activity),
                               summary.groups[axes.group_of_joint[j]],
                               std::string(name_of(plan.joints[j])),
                               summary.methods[k % axes.methods],
                               sums.asked,
                               sums.distance_m.n,
                               sums.distance_m.value(),
                               errors_of(sums.both),
                               errors_of(sums.complete),
                               {sums.slow_m.n, sums.fast_m.n, sums.slow_m.value(), sums.fast_m.value()}});
  }
}

void add_families(const Plan& plan, ResultsSummary& summary) {
  for (const Method& method : plan.methods) {
    const MethodSpec& spec = method.spec;
    if (spec.family.empty()) continue;
    if (summary.families.empty() || summary.families.back().name != spec.family)
      summary.families.push_back({spec.family, spec.sensors.size(), {}});
    summary.families.back().methods.push_back(spec.name);
  }
}

// The plain mean of a name's errors over the groups.
ContrastEstimate mean_error_m(const ParticipantErrors& errors, const std::string& name,
                              const std::string& condition) {
  Contrast mean;
  const std::vector<std::string> groups = errors.groups_of(condition);
  for (const std::string& group : groups) {
    mean.value.push_back(errors.error_m(name, condition, group));
    mean.value.back().weight = 1.0 / static_cast<double>(groups.size());
  }
  return solve_contrast(mean);
}

void complete_differences(const ParticipantErrors& errors, ResultsSummary& summary) {
  for (DifferenceCell& cell : summary.differences) {
    if (cell.alignment != summary.alignments.front()) continue;
    const auto groups =
        cell.group == kAverageGroup ? errors.groups_of(cell.condition) : std::vector<std::string>{cell.group};
    const ContrastEstimate e = solve_contrast(
        errors.difference(cell.method, summary.reference, cell.condition, groups, ComparedSamples::complete));
    cell.complete_percent = 100.0 * e.value;
    cell.complete_percent_low = 100.0 * e.low();
    cell.complete_percent_high = 100.0 * e.high();
  }
}

// Of all that the family's methods are asked in the condition.
double answered_share(const ResultsSummary& summary, const MethodFamily& family,
                      const std::string& condition) {
  double asked = 0.0, answered = 0.0;
  for (const TakeJointRow& row : summary.by_take) {
    if (row.condition != condition || std::ranges::find(family.methods, row.method) == family.methods.end())
      continue;
    asked += static_cast<double>(row.asked);
    answered += static_cast<double>(row.answered);
  }
  return answered / asked;
}

void add_family_cells(const ParticipantErrors& errors, ResultsSummary& summary) {
  for (const std::string& condition : summary.conditions)
    for (const MethodFamily& family : summary.families) {
      const ContrastEstimate own = mean_error_m(errors, family.name, condition);
      FamilyCell cell{.family = family.name,
                      .condition = condition,
                      .mae_m = own.value,
                      .low_m = own.low(),
                      .high_m = own.high(),
                      .answered = answered_share(summary, family, condition)};
      summary.family_cells.push_back(std::move(cell));
    }
}

bool is_of_set(const ResultsSummary& summary, const std::string& method) {
  return std::ranges::any_of(summary.families, [&](const MethodFamily& family) {
    return family.sensors > 1 && family.methods.size() > 1 &&
           std::ranges::find(family.methods, method) != family.methods.end();
  });
}

// Of the methods that compete in a condition and group, the one that errs least, first.
std::vector<const SummaryCell*> competitors(const ResultsSummary& summary, const std::string& condition,
                                            const std::string& group) {
  constexpr double kCompetes = 0.95;  // of what it is asked: to answer the easy samples alone wins nothing
  std::vector<const SummaryCell*> cells;
  for (const SummaryCell& c : summary.cells)
    if (c.condition == condition && c.group == group && c.alignment == summary.alignments.front() &&
        !std::isnan(c.mae_m) && !is_of_set(summary, c.method))
      cells.push_back(&c);
  const auto is_silent = [](const SummaryCell* c) { return !(c->coverage() >= kCompetes); };
  if (!std::ranges::all_of(cells, is_silent)) std::erase_if(cells, is_silent);
  std::ranges::stable_sort(cells, {}, &SummaryCell::mae_m);
  return cells;
}

// Two methods on the samples that both answer, in one condition.
class PairedDifferences {
 public:
  PairedDifferences(const Plan& plan, const StatisticsLayout& layout, std::size_t participants,
                    std::span<const TakeSummary> takes)
      : plan_(plan), layout_(layout), participants_(participants), takes_(takes) {}

  // The mean of the groups' differences first - second in metres; clusters as of all intervals.
  ContrastEstimate between(const std::string& first, const std::string& second, const std::string& condition,
                           const std::vector<std::string>& groups) const {
    const std::size_t a = competitor(first), b = competitor(second);
    const std::vector<std::string> all = groups_of(plan_);
    Contrast difference;
    for (const std::string& group : groups) {
      WeightedRatio ratio{{}, {}, 1.0 / static_cast<double>(groups.size())};
      const auto g = static_cast<std::size_t>(std::ranges::find(all, group) - all.begin());
      std::map<std::string, PairSums> by_cluster;
      for (std::size_t t = 0; t < takes_.size(); ++t) add_take(t, condition, g, a, b, by_cluster);
      for (const auto& [name, sums] : by_cluster) {
        ratio.numerator.push_back(sums.first_m - sums.second_m);
        ratio.denominator.push_back(static_cast<double>(sums.n));
      }
      difference.value.push_back(std::move(ratio));
    }
    return solve_contrast(difference);
  }

 private:
  std::size_t competitor(const std::string& method) const {
    const auto found = std::ranges::find_if(
        layout_.competitors, [&](std::size_t m) { return plan_.methods[m].spec.name == method; });
    TRILAT_CHECK(found != layout_.competitors.end(), "the best is one of those that compete");
    return static_cast<std::size_t>(found - layout_.competitors.begin());
  }

  void add_take(std::size_t t, const std::string& condition, std::size_t group, std::size_t a, std::size_t b,
                std::map<std::string, PairSums>& by_cluster) const {
    const Take& take = plan_.takes[t].take;
    const bool all = take.activity == condition, occluded = occluded_condition(take.activity) == condition;
    if (takes_[t].pairs.cells.empty() || (!all && !occluded)) return;
    PairSums& sums = by_cluster[participants_ < kFewestParticipants ? take.id : take.participant];
    for (std::size_t j = 0; j < layout_.axes.joints; ++j) {
      if (layout_.axes.group_of_joint[j] != group) continue;
      const PairSums& here = takes_[t].pairs.at(all ? 0 : 1, j, a, b);
      sums.n += here.n;
      sums.first_m += here.first_m;
      sums.second_m += here.second_m;
    }
  }

  const Plan& plan_;
  const StatisticsLayout& layout_;
  std::size_t participants_;
  std::span<const TakeSummary> takes_;
};

void add_best(const ParticipantErrors& errors, const PairedDifferences& pairs, ResultsSummary& summary) {
  for (const std::string& condition : summary.conditions) {
    std::vector<std::string> groups = errors.groups_of(condition);
    if (groups.size() > 1) groups.emplace_back(kAverageGroup);
    for (const std::string& group : groups) {
      const std::vector<const SummaryCell*> cells = competitors(summary, condition, group);
      if (cells.empty()) continue;
      BestMethod best{condition, group, cells.front()->method, {}};
      for (const SummaryCell* cell : cells) {
        if (cell == cells.front()) continue;
        const ContrastEstimate e =
            pairs.between(cell->method, best.method, condition,
                          group == kAverageGroup ? errors.groups_of(condition) : std::vector{group});
        if (e.clusters >= 2 && !is_told_apart(e, cells.size() - 1)) best.like_best.push_back(cell->method);
      }
      summary.best.push_back(std::move(best));
    }
  }
}

ResultsSummary empty_summary(const Plan& plan, const RunOutcome& outcome) {
  ResultsSummary summary;
  summary.study = plan.study.name;
  summary.campaign = plan.campaign.name;
  summary.simulated = plan.simulated;
  if (leaves_sensors_out(plan)) summary.truth = kLeftOutTruth;
  summary.takes = plan.takes.size();
  summary.takes_failed = static_cast<std::uint64_t>(std::ranges::count(outcome.evaluated, false));
  std::set<std::string> participants;
  for (std::size_t t = 0; t < plan.takes.size(); ++t)
    if (outcome.evaluated[t]) participants.insert(plan.takes[t].take.participant);
  for (const std::string& activity : activities_of(plan)) {
    summary.conditions.push_back(activity);
    if (plan.study.occluded_apart) summary.conditions.push_back(occluded_condition(activity));
  }
  summary.participants = participants.size();
  summary.groups = groups_of(plan);
  for (const Method& method : plan.methods) summary.methods.push_back(method.spec.name);
  summary.reference = plan.methods[plan.reference].spec.name;
  for (AlignmentKind kind : plan.study.alignments) summary.alignments.emplace_back(name_of(kind));
  summary.notes = outcome.notes;
  summary.cross_checks = outcome.cross_checks;
  return summary;
}

// The first method that answers anything, when the reference answers nothing in any take; else the reference.
std::size_t answering_reference(const StatisticsLayout& layout, const std::vector<TakeSummary>& takes) {
  std::vector<std::uint64_t> answered(layout.axes.methods, 0);
  for (const TakeSummary& take : takes)
    for (std::size_t k = 0; k < take.statistics.of_joint.size(); ++k)
      answered[k % answered.size()] += take.statistics.of_joint[k].distance_m.n;
  if (answered[layout.reference] > 0) return layout.reference;
  const auto first = std::ranges::find_if(answered, [](std::uint64_t n) { return n > 0; });
  return first == answered.end() ? layout.reference : static_cast<std::size_t>(first - answered.begin());
}

// Compares the takes with another reference than their summaries were made with.
void compare_with(std::size_t reference, std::span<const EvaluatedTake> evaluated, StatisticsLayout& layout,
                  std::vector<TakeSummary>& takes, ResultsSummary& summary) {
  const std::string silent = summary.reference;
  layout.reference = reference;
  summary.reference = summary.methods[reference];
  parallel_for_index(takes.size(), 1, [&](std::size_t t) {
    if (!evaluated[t].result.evaluated) return;
    const SamplesFile samples = SamplesFile::open(evaluated[t].folder / "samples.h5");
    takes[t].statistics = summarise_take(samples, layout, nullptr).statistics;
  });
  summary.notes.push_back(
      {"", false, "study \"" + summary.study + "\" /reference",
       fmt::format("\"{}\" answers nothing in any take; the others are compared with \"{}\"", silent,
                   summary.reference)});
}

bool has_errors_of(const SamplesHeader& there, const SamplesHeader& wanted) {
  return there.alignment == wanted.alignment && there.training_share == wanted.training_share;
}

// The item anew, with the errors that `wanted` says.
TakeSummary replace_errors(const SamplesFile& samples, const SamplesHeader& wanted,
                           const StatisticsLayout& layout) {
  constexpr std::uint64_t kCopied = 1024;  // instants at once
  const std::filesystem::path folder = samples.path().parent_path();
  const ItemStore store(folder.parent_path().parent_path());
  const ItemStore::Aside aside(store);
  const std::filesystem::path made = aside.path() / "item";
  make_folder(made);
  SamplesFile copy = SamplesFile::create(made / "samples.h5", wanted);
  SampleBlock block;
  for (std::uint64_t first = 0; first < wanted.takes[0].instants; first += kCopied) {
    samples.read(0, first, std::min(kCopied, wanted.takes[0].instants - first), SampleColumns::all, block);
    copy.write(0, block);
  }
  TakeSummary summary = summarise_take(samples, layout, &copy);
  copy.finish();
  if (std::filesystem::exists(folder / "replay.h5"))
    std::filesystem::copy_file(folder / "replay.h5", made / "replay.h5");
  std::optional<StoredItem> item = store.find(folder.filename().string());
  if (!item) throw InputError(folder.string(), "was removed while it was read");
  store.put(made, {item->id, item->key, item->outcome, {}});
  return summary;
}

TakeSummary summary_of(const EvaluatedTake& take, const SamplesHeader& wanted,
                       const StatisticsLayout& layout) {
  const SamplesFile samples = SamplesFile::open(take.folder / "samples.h5");
  return has_errors_of(samples.header(), wanted) ? summarise_take(samples, layout, nullptr)
                                                 : replace_errors(samples, wanted, layout);
}

}  // namespace

ResultsSummary summarise(const Plan& plan, const RunOutcome& outcome, std::span<EvaluatedTake> evaluated,
                         const Watch& watch) {
  ResultsSummary summary = empty_summary(plan, outcome);
  StatisticsLayout layout = statistics_layout(plan);
  const Axes& axes = layout.axes;
  add_families(plan, summary);
  std::vector<TakeSummary> takes(plan.takes.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(plan.takes.size(), 1, [&](std::size_t t) {
    watch.check();
    EvaluatedTake& take = evaluated[t];
    if (take.summary)
      takes[t] = std::move(*std::exchange(take.summary, {}));
    else if (take.result.evaluated)
      takes[t] = summary_of(take, samples_header(plan, plan.takes[t]), layout);
    watch.tell(kTakesShare * static_cast<double>(++done) / static_cast<double>(takes.size()));
  });
  if (const std::size_t reference = answering_reference(layout, takes); reference != layout.reference)
    compare_with(reference, evaluated, layout, takes, summary);
  for (const std::string& activity : activities_of(plan)) {
    std::vector<TakeSummary*> of_activity;
    for (std::size_t t = 0; t < plan.takes.size(); ++t)
      if (plan.takes[t].take.activity == activity && evaluated[t].result.evaluated)
        of_activity.push_back(&takes[t]);
    add_condition(of_activity, axes, activity, summary);
  }
  for (std::size_t t = 0; t < takes.size(); ++t) add_take_rows(plan, layout, t, takes[t].statistics, summary);
  watch.tell(kCellsShare);
  add_statistics(plan, outcome, layout, takes, summary);
  const ParticipantErrors errors(summary);
  add_family_cells(errors, summary);
  complete_differences(errors, summary);
  add_best(errors, PairedDifferences(plan, layout, summary.participants, takes), summary);
  watch.tell(1.0);
  return summary;
}

}  // namespace trilat
