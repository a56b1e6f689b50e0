// SPDX-License-Identifier: MIT
// From the sums of a study's errors to its numbers.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/metrics/statistics.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {
namespace {

constexpr std::array kAxes{"x", "y", "z"};
constexpr std::pair<const char*, double> kQuantiles[]{{"p05", 0.05}, {"p25", 0.25}, {"median", 0.5},
                                                      {"p75", 0.75}, {"p90", 0.9},  {"p95", 0.95}};

double quotient(double sum, std::uint64_t n) { return n == 0 ? kNaN : sum / static_cast<double>(n); }

Agreement agreement_of(const MeasureSums& sums) {
  std::vector<DifferenceSums> clusters;
  for (std::size_t k = 0; k < sums.sum.n.size(); ++k)
    clusters.push_back({sums.sum.n[k], sums.sum.sum[k], sums.squares.sum[k]});
  return limits_of_agreement(clusters);
}

std::size_t place_of(const ResultsSummary& summary, const std::string& method) {
  return static_cast<std::size_t>(std::ranges::find(summary.methods, method) - summary.methods.begin());
}

// The groups of each row: each alone, and, where there are several, all.
std::vector<std::vector<std::size_t>> rows_of(const ConditionErrors& errors) {
  std::vector<std::vector<std::size_t>> rows;
  for (const std::size_t g : errors.groups()) rows.push_back({g});
  if (rows.size() > 1) rows.push_back(errors.groups());
  return rows;
}

bool is_of_set(const ResultsSummary& summary, std::size_t method) {
  return std::ranges::any_of(summary.families, [&](const SensorSetGroup& family) {
    return family.sensors > 1 && family.methods.size() > 1 &&
           std::ranges::find(family.methods, summary.methods[method]) != family.methods.end();
  });
}

// The methods that compete in some groups, the one that errs least first.
std::vector<std::size_t> competitors(const ConditionErrors& errors, const std::vector<std::size_t>& groups,
                                     const ResultsSummary& summary, std::size_t methods) {
  constexpr double kCompetes = 0.95;  // of what it is asked: to answer the easy samples alone wins nothing
  struct Competitor {
    std::size_t method;
    double mean_m, coverage;
  };
  std::vector<Competitor> all;
  for (std::size_t m = 0; m < methods; ++m) {
    CellSums counts;
    for (const std::size_t g : groups) counts.add_counts(errors.cell(g, m, 0));
    const double mean_m = errors.mean_m(groups, m, 0).value;
    if (!std::isnan(mean_m) && !is_of_set(summary, m))
      all.push_back({m, mean_m, quotient(static_cast<double>(counts.answered), counts.asked)});
  }
  const auto is_silent = [](const Competitor& c) { return !(c.coverage >= kCompetes); };
  if (!std::ranges::all_of(all, is_silent)) std::erase_if(all, is_silent);
  std::ranges::stable_sort(all, {}, &Competitor::mean_m);
  std::vector<std::size_t> sorted;
  for (const Competitor& c : all) sorted.push_back(c.method);
  return sorted;
}

class StudyNumbers {
 public:
  StudyNumbers(const StudyErrors& errors, ResultsSummary& summary)
      : errors_(errors),
        axes_(errors.axes()),
        summary_(summary),
        numbers_(summary.numbers),
        reference_(place_of(summary, summary.reference)) {}

  void add() {
    for (const std::string& condition : summary_.conditions) add_condition(condition);
    for (const TakeTable& take : errors_.takes()) {
      add_take(take, Subset::all, take.activity);
      add_take(take, Subset::occluded, occluded_condition(take.activity));
    }
  }

 private:
  void add_condition(const std::string& condition) {
    const ConditionErrors errors = errors_.in(condition);
    summary_.clusters[condition] = errors.clusters();
    for (std::size_t m = 0; m < axes_.methods; ++m)
      for (std::size_t a = 0; a < axes_.alignments; ++a) {
        const NumberKey key{
            .condition = condition, .method = summary_.methods[m], .alignment = summary_.alignments[a]};
        for (const auto& groups : rows_of(errors)) add_groups(errors, groups, m, a, key);
      }
    add_best(errors, condition);
    for (const SensorSetGroup& family : summary_.families) add_family(errors, condition, family);
    const bool is_whole_activity = std::ranges::any_of(
        errors_.takes(), [&](const TakeTable& take) { return take.activity == condition; });
    if (!is_whole_activity) return;
    for (std::size_t m = 0; m < axes_.methods; ++m) {
      add_bodies(errors, condition, m);
      add_angles(errors, condition, m);
    }
    const MeasureSums& truth = errors.other("", axes_.methods, Measure::jerk);
    add({.condition = condition}, "jerk", "mean_of_truth", quotient(truth.total(), truth.n), truth.n);
  }

  std::string name_of_row(const std::vector<std::size_t>& groups) const {
    return groups.size() > 1 ? kAverageGroup : summary_.groups[groups.front()];
  }

  void add(const NumberKey& key, const char* measure, const char* statistic, double value, std::uint64_t n) {
    numbers_.add({key.with({.measure = measure, .statistic = statistic}), value, kNaN, kNaN, n});
  }
  // A number with the interval of `e`, from `low` on.
  void add(const NumberKey& key, const char* measure, const char* statistic, const Estimate& e, double low,
           std::uint64_t n) {
    numbers_.add(
        {key.with({.measure = measure, .statistic = statistic}), e.value, low, e.high(), n, e.clusters});
  }

  void add_groups(const ConditionErrors& errors, const std::vector<std::size_t>& groups, std::size_t m,
                  std::size_t a, NumberKey key) {
    key.group = name_of_row(groups);
    CellSums counts;
    for (const std::size_t g : groups) counts.add_counts(errors.cell(g, m, a));
    if (counts.asked == 0) return;
    const Estimate mean_m = errors.mean_m(groups, m, a);
    add(key, "distance", "mean", mean_m, mean_m.low_of_size(), counts.answered);
    add_counts(key, counts);
    if (groups.size() == 1) add_statistics(key, errors.cell(groups.front(), m, a));
    if (groups.size() > 1) add_mean_bias(key, errors, groups, m, a);
    if (m != reference_) add_difference(key, errors.difference(groups, m, reference_, a));
  }

  void add_counts(const NumberKey& key, const CellSums& counts) {
    add(key, "answered", "share", quotient(static_cast<double>(counts.answered), counts.asked), counts.asked);
    for (std::size_t s = 0; s < kSolveStatusCount; ++s)
      if (counts.statuses[s] > 0)
        numbers_.add(
            {key.with({.measure = "status", .statistic = std::string(name_of(static_cast<SolveStatus>(s)))}),
             quotient(static_cast<double>(counts.statuses[s]), counts.asked), kNaN, kNaN,
             counts.statuses[s]});
  }

  void add_statistics(const NumberKey& key, const CellSums& cell) {
    add(key, "iterations", "mean", quotient(static_cast<double>(cell.iterations), cell.asked), cell.asked);
    if (cell.answered == 0) return;
    add(key, "distance", "rms", std::sqrt(quotient(cell.distance.total_squares(), cell.answered)),
        cell.answered);
    for (const auto& [name, q] : kQuantiles) add(key, "distance", name, cell.quantile_m(q), cell.answered);
    add(key, "distance", "max", cell.distance.largest, cell.answered);
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      const MeasureSums& sums = cell.axes[axis];
      add(key, kAxes[axis], "mean_abs", quotient(sums.sum_abs, sums.n), sums.n);
      const Agreement agreement = agreement_of(sums);
      if (key.alignment == "none" || key.alignment == "mean")
        add_agreement(key, kAxes[axis], agreement, sums.n);
      else
        add(key, kAxes[axis], "bias", agreement.bias, sums.n);
    }
  }

  void add_agreement(const NumberKey& key, const char* measure, const Agreement& a, std::uint64_t n) {
    const auto add = [&](const char* statistic, double value, double low, double high) {
      numbers_.add({key.with({.measure = measure, .statistic = statistic}), value, low, high, n, a.persons});
    };
    add("bias", a.bias, a.bias_low, a.bias_high);
    add("sd", a.sd, kNaN, kNaN);
    add("lower_limit", a.lower, a.lower_low, a.lower_high);
    add("upper_limit", a.upper, a.upper_low, a.upper_high);
  }

  void add_mean_bias(const NumberKey& key, const ConditionErrors& errors,
                     const std::vector<std::size_t>& groups, std::size_t m, std::size_t a) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      double sum_m = 0.0;
      std::uint64_t n = 0;
      for (const std::size_t g : groups) {
        const CellSums& cell = errors.cell(g, m, a);
        sum_m += quotient(cell.axes[axis].total(), cell.answered);
        n += cell.answered;
      }
      add(key, kAxes[axis], "bias", quotient(sum_m, groups.size()), n);
    }
  }

  void add_difference(NumberKey key, const MethodDifference& d) {
    key.against = summary_.methods[reference_];
    key.measure = "distance";
    for (const auto& [statistic, e] : {std::pair{"difference", &d.m}, {"relative_difference", &d.share}})
      numbers_.add({key.with({.statistic = statistic}), e->value, e->low(), e->high(), d.n, e->clusters,
                    e->p_value()});
  }

  // A mean with its interval, of a size or of what may be below zero.
  void add_mean(const ConditionErrors& errors, const NumberKey& key, const char* measure,
                const char* statistic, const ClusterSums& sums, std::uint64_t n, bool is_size) {
    const Estimate mean = solve_contrast({{sums.ratio(errors.cluster_count())}, {}});
    add(key, measure, statistic, mean, is_size ? mean.low_of_size() : mean.low(), n);
  }

  void add_bodies(const ConditionErrors& errors, const std::string& condition, std::size_t m) {
    const NumberKey key{.condition = condition, .method = summary_.methods[m]};
    const std::size_t alignment = body_alignment();
    const NumberKey aligned = key.with({.alignment = summary_.alignments[alignment]});
    const auto sums = [&](Measure measure) -> const MeasureSums& { return errors.other("", m, measure); };
    const MeasureSums &mpjpe = sums(Measure::mpjpe), &range = sums(Measure::range),
                      &jerk = sums(Measure::jerk);
    add_mean(errors, aligned, "mpjpe", "mean", mpjpe.sum, mpjpe.n, true);
    add_mean(errors, key, "pa_mpjpe", "mean", sums(Measure::pa_mpjpe).sum, mpjpe.n, true);
    add_mean(errors, key, "bone", "sd", sums(Measure::bone).sum, bones_of(errors, m), true);
    add_mean(errors, key, "jerk", "mean", jerk.sum, jerk.n, true);
    add_mean(errors, key, "range", "mean_abs", range.absolute, range.n, true);
    add_mean(errors, key, "range", "bias", range.sum, range.n, false);
    add_mean(errors, key, "bearing", "mean", sums(Measure::bearing).sum, range.n, true);
    add_shares_within(aligned, errors, m, alignment);
  }

  std::size_t body_alignment() const {
    const auto none = std::ranges::find(summary_.alignments, "none");
    return none == summary_.alignments.end() ? 0
                                             : static_cast<std::size_t>(none - summary_.alignments.begin());
  }

  // Bones of one take.
  static std::uint64_t bones_of(const ConditionErrors& errors, std::size_t m) {
    std::uint64_t bones = 0;
    for (const TakeTable* take : errors.takes())
      for (const ErrorSums& row : take->errors.sums)
        if (row.is(Measure::bone) && row.method == m) bones = std::max<std::uint64_t>(bones, row.n);
    return bones;
  }

  void add_angles(const ConditionErrors& errors, const std::string& condition, std::size_t m) {
    for (const std::string& angle : errors.angles()) {
      const NumberKey key{.condition = condition, .group = angle, .method = summary_.methods[m]};
      const MeasureSums& error = errors.other(angle, m, Measure::angle);
      add_mean(errors, key, "angle", "mean_abs", error.absolute, error.n, true);
      add(key, "angle", "rms", std::sqrt(quotient(error.total_squares(), error.n)), error.n);
      add_agreement(key, "angle", agreement_of(error), error.n);
      for (const auto& [measure, statistic] : {std::pair{Measure::motion_range, "motion_range"},
                                               {Measure::true_motion_range, "true_motion_range"}}) {
        const MeasureSums& range = errors.other(angle, m, measure);
        add(key, "angle", statistic, quotient(range.total(), range.n), range.n);
      }
    }
  }

  // Adds the share of all asked samples that lie within each radius; one without an answer does not.
  void add_shares_within(const NumberKey& key, const ConditionErrors& errors, std::size_t m, std::size_t a) {
    for (const double radius_m : kPckRadii_m) {
      std::uint64_t asked = 0, within = 0;
      for (const std::size_t g : errors.groups()) {
        asked += errors.cell(g, m, a).asked;
        within += errors.cell(g, m, a).below(static_cast<std::size_t>(std::llround(radius_m / kBin_m)));
      }
      const std::string radius = fmt::format("{:.0f}_cm", 100.0 * radius_m);
      add(key, "within", radius.c_str(), quotient(static_cast<double>(within), asked), asked);
    }
  }

  // Each joint of one take, under the first alignment.
  void add_take(const TakeTable& take, Subset subset, const std::string& condition) {
    std::vector<TakeJointRow> rows;
    std::vector<double> length_m(errors_.joints().size() * axes_.methods);
    for (const std::string& joint : errors_.joints())
      for (const std::string& method : summary_.methods)
        rows.push_back({take.id, take.participant, condition, group_of(joint), joint, method});
    const auto place = [&](const auto& row) { return axes_.joint_of(row) * axes_.methods + row.method; };
    const auto is_of_subset = [&](const auto& row) {
      return row.subset == static_cast<std::uint32_t>(subset);
    };
    for (const EndedRow& row : take.errors.ended)
      if (is_of_subset(row) && (row.test > 0 || !leaves_training_out(summary_.alignments.front())))
        rows[place(row)].asked += row.asked();
    for (const ErrorSums& row : take.errors.sums)
      if (is_of_subset(row) && row.is(Measure::distance) && row.alignment == 0) {
        rows[place(row)].answered += row.n;
        length_m[place(row)] += row.sum;
      }
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows[k].mae_m = quotient(length_m[k], rows[k].answered);
      if (rows[k].asked > 0) trilat::add_row(rows[k], summary_);
    }
    if (subset == Subset::all) add_angles_of_take(take, condition);
  }

  // Mean error of each angle of one take, and the mean of the truth.
  void add_angles_of_take(const TakeTable& take, const std::string& condition) {
    for (const auto& [measure, statistic] :
         {std::pair{Measure::angle, "bias"}, {Measure::true_angle, "mean_of_truth"}}) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, ErrorSums> sums;
      for (const ErrorSums& row : take.errors.sums)
        if (row.is(measure)) sums[{row.quantity, row.method}].add(row);
      for (const auto& [of, sum] : sums)
        add({.condition = condition,
             .group = take.errors.quantities[of.first],
             .method = summary_.methods[of.second],
             .take = take.id},
            "angle", statistic, quotient(sum.sum, sum.n), sum.n);
    }
  }

  // On average over the joint groups, over what its methods answer.
  void add_family(const ConditionErrors& errors, const std::string& condition, const SensorSetGroup& family) {
    if (errors.groups().empty()) return;
    Contrast mean;
    CellSums counts;
    for (const std::size_t g : errors.groups()) {
      ClusterSums sums;
      for (const std::string& method : family.methods) {
        const CellSums& cell = errors.cell(g, place_of(summary_, method), 0);
        sums.add(cell.distance.sum);
        counts.add_counts(cell);
      }
      mean.value.push_back(
          sums.ratio(errors.cluster_count(), 1.0 / static_cast<double>(errors.groups().size())));
    }
    const Estimate mean_m = solve_contrast(mean);
    const NumberKey key{.condition = condition,
                        .group = kAverageGroup,
                        .method = family.name,
                        .alignment = summary_.alignments.front()};
    add(key, "distance", "mean_of_sets", mean_m, mean_m.low_of_size(), counts.answered);
    add(key, "answered", "share_of_sets", quotient(static_cast<double>(counts.answered), counts.asked),
        counts.asked);
  }

  void add_best(const ConditionErrors& errors, const std::string& condition) {
    for (const auto& groups : rows_of(errors)) {
      const std::vector<std::size_t> methods = competitors(errors, groups, summary_, axes_.methods);
      if (methods.empty()) continue;
      // The methods cannot be compared without an interval, so none is best.
      if (methods.size() > 1 && errors.mean_m(groups, methods.front(), 0).clusters < 2) continue;
      BestMethod best{condition, name_of_row(groups), summary_.methods[methods.front()], {}};
      for (const std::size_t m : std::span(methods).subspan(1)) {
        const Estimate e = errors.difference(groups, m, methods.front(), 0).m;
        if (e.clusters >= 2 && !differs_significantly(e, methods.size() - 1))
          best.not_distinguished.push_back(summary_.methods[m]);
      }
      summary_.best.push_back(std::move(best));
    }
  }

  const StudyErrors& errors_;
  const TableAxes& axes_;
  ResultsSummary& summary_;
  Numbers& numbers_;
  const std::size_t reference_;
};

}  // namespace

void set_reference(const StudyErrors& errors, ResultsSummary& summary) {
  std::vector<bool> answers(errors.axes().methods);
  for (const TakeTable& take : errors.takes())
    for (const ErrorSums& row : take.errors.sums)
      if (row.is(Measure::distance) && row.alignment == 0) answers[row.method] = true;
  const auto first = std::ranges::find(answers, true);
  if (answers[place_of(summary, summary.reference)] || first == answers.end()) return;
  const std::string silent =
      std::exchange(summary.reference, summary.methods[static_cast<std::size_t>(first - answers.begin())]);
  summary.notes.push_back(
      {"", false, "study \"" + summary.study + "\" /reference",
       fmt::format("\"{}\" answers nothing in any take; the others are compared with \"{}\"", silent,
                   summary.reference)});
}

std::vector<MethodPair> pairs_of(const StudyErrors& errors, const ResultsSummary& summary,
                                 std::span<const std::string> more) {
  std::set<std::size_t> against{place_of(summary, summary.reference)};
  for (const std::string& condition : summary.conditions) {
    const ConditionErrors in = errors.in(condition);
    for (const auto& groups : rows_of(in))
      if (const auto methods = competitors(in, groups, summary, summary.methods.size()); !methods.empty())
        against.insert(methods.front());
  }
  for (const std::string& method : more)
    if (place_of(summary, method) < summary.methods.size()) against.insert(place_of(summary, method));
  std::set<MethodPair> pairs;
  for (std::uint32_t m = 0; m < summary.methods.size(); ++m)
    for (const std::size_t other : against)
      if (m != other)
        pairs.insert(
            {std::min(m, static_cast<std::uint32_t>(other)), std::max(m, static_cast<std::uint32_t>(other))});
  return {pairs.begin(), pairs.end()};
}

void add_numbers(const StudyErrors& errors, ResultsSummary& summary) { StudyNumbers(errors, summary).add(); }

}  // namespace trilat
