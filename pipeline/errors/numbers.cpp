// SPDX-License-Identifier: MIT
// From the sums of a study's errors to its numbers.
#include "pipeline/errors/numbers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "evaluators/metrics/agreement.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {
namespace {

constexpr std::array kAxes{"x", "y", "z"};
constexpr std::array<std::pair<const char*, double>, 6> kQuantiles{
    {{"p05", 0.05}, {"p25", 0.25}, {"median", 0.5}, {"p75", 0.75}, {"p90", 0.9}, {"p95", 0.95}}};

double quotient(double sum, std::uint64_t n) { return n == 0 ? kNoNumber : sum / static_cast<double>(n); }

double sum_of(const ClusterSums& sums) {
  double sum = 0.0;
  for (const double part : sums.sum) sum += part;
  return sum;
}

Agreement agreement_of(const CellSums& cell, std::size_t axis) {
  std::vector<DifferenceSums> clusters;
  for (std::size_t k = 0; k < cell.error_m[axis].n.size(); ++k)
    clusters.push_back({cell.error_m[axis].n[k], cell.error_m[axis].sum[k], cell.error_m2[axis].sum[k]});
  return limits_of_agreement(clusters);
}

class StudyNumbers {
 public:
  StudyNumbers(const StudyErrors& errors, ResultsSummary& summary)
      : errors_(errors), axes_(errors.axes()), summary_(summary), numbers_(summary.numbers) {}

  void add() {
    find_reference();
    for (const std::string& condition : summary_.conditions) add_condition(condition);
    for (const TakeTable& take : errors_.takes()) {
      add_take(take, Subset::all, take.activity);
      add_take(take, Subset::occluded, occluded_condition(take.activity));
    }
  }

 private:
  std::size_t place_of(const std::string& method) const {
    return static_cast<std::size_t>(std::ranges::find(summary_.methods, method) - summary_.methods.begin());
  }
  void find_reference() {
    reference_ = place_of(summary_.reference);
    std::vector<bool> answers(axes_.methods);
    for (const TakeTable& take : errors_.takes())
      for (const ErrorRow& row : take.errors.errors)
        if (row.answered > 0 && row.alignment == 0) answers[row.method] = true;
    const auto first = std::ranges::find(answers, true);
    if (answers[reference_] || first == answers.end()) return;
    const std::string silent = summary_.reference;
    reference_ = static_cast<std::size_t>(first - answers.begin());
    summary_.reference = summary_.methods[reference_];
    summary_.notes.push_back(
        {"", false, "study \"" + summary_.study + "\" /reference",
         fmt::format("\"{}\" answers nothing in any take; the others are compared with \"{}\"", silent,
                     summary_.reference)});
  }

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
    for (const MethodFamily& family : summary_.families) add_family(errors, condition, family);
    const bool is_whole_activity = std::ranges::any_of(
        errors_.takes(), [&](const TakeTable& take) { return take.activity == condition; });
    if (!is_whole_activity) return;
    for (std::size_t m = 0; m < axes_.methods; ++m) add_bodies(errors, condition, m);
    add_jerk_of_truth(errors, condition);
  }

  // The groups of each row: each alone, and, where there are several, all.
  static std::vector<std::vector<std::size_t>> rows_of(const ConditionErrors& errors) {
    std::vector<std::vector<std::size_t>> rows;
    for (const std::size_t g : errors.groups()) rows.push_back({g});
    if (rows.size() > 1) rows.push_back(errors.groups());
    return rows;
  }
  std::string name_of_row(const std::vector<std::size_t>& groups) const {
    return groups.size() > 1 ? kAverageGroup : summary_.groups[groups.front()];
  }

  void add(const NumberKey& key, const char* measure, const char* statistic, double value, std::uint64_t n) {
    numbers_.add({key.with({.measure = measure, .statistic = statistic}), value, kNoNumber, kNoNumber, n});
  }
  // A number with the interval of `e`, from `low` on.
  void add(const NumberKey& key, const char* measure, const char* statistic, const ContrastEstimate& e,
           double low, std::uint64_t n) {
    numbers_.add(
        {key.with({.measure = measure, .statistic = statistic}), e.value, low, e.high(), n, e.clusters});
  }

  void add_groups(const ConditionErrors& errors, const std::vector<std::size_t>& groups, std::size_t m,
                  std::size_t a, NumberKey key) {
    key.group = name_of_row(groups);
    CellSums counts;
    for (const std::size_t g : groups) counts.add_counts(errors.cell(g, m, a));
    if (counts.asked == 0) return;
    const ContrastEstimate mean_m = errors.mean_m(groups, m, a);
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
             quotient(static_cast<double>(counts.statuses[s]), counts.asked), kNoNumber, kNoNumber,
             counts.statuses[s]});
  }

  void add_statistics(const NumberKey& key, const CellSums& cell) {
    add(key, "iterations", "mean", quotient(static_cast<double>(cell.iterations), cell.asked), cell.asked);
    if (cell.answered == 0) return;
    add(key, "distance", "rms", std::sqrt(quotient(cell.length_m2, cell.answered)), cell.answered);
    for (const auto& [name, q] : kQuantiles) add(key, "distance", name, cell.quantile_m(q), cell.answered);
    add(key, "distance", "max", cell.largest_m, cell.answered);
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      add(key, kAxes[axis], "mean_abs", quotient(cell.absolute_m[axis], cell.answered), cell.answered);
      const Agreement agreement = agreement_of(cell, axis);
      if (key.alignment == "none" || key.alignment == "mean")
        add_agreement(key, kAxes[axis], agreement, cell.answered);
      else
        add(key, kAxes[axis], "bias", agreement.bias, cell.answered);
    }
  }

  void add_agreement(const NumberKey& key, const char* measure, const Agreement& a, std::uint64_t n) {
    const auto add = [&](const char* statistic, double value, double low, double high) {
      numbers_.add({key.with({.measure = measure, .statistic = statistic}), value, low, high, n, a.persons});
    };
    add("bias", a.bias, a.bias_low, a.bias_high);
    add("sd", a.sd, kNoNumber, kNoNumber);
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
        sum_m += quotient(sum_of(cell.error_m[axis]), cell.answered);
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

  void add_bodies(const ConditionErrors& errors, const std::string& condition, std::size_t m) {
    NumberKey key{.condition = condition, .method = summary_.methods[m]};
    const ContrastEstimate mpjpe = errors.mpjpe_m(m), pa_mpjpe = errors.pa_mpjpe_m(m);
    add(key, "pa_mpjpe", "mean", pa_mpjpe, pa_mpjpe.low_of_size(), errors.bodies(m));
    double bone_sd_m = 0.0, jerk_m_s3 = 0.0;
    std::uint64_t bones = 0, all_bones = 0, jerks = 0;
    std::size_t alignment = 0;
    for (const TakeTable* take : errors.takes()) {
      alignment = take->errors.body_alignment;
      for (const ShapeRow& shape : take->errors.shapes) {
        if (shape.method != m) continue;
        bones = std::max<std::uint64_t>(bones, shape.bones);
        all_bones += shape.bones;
        bone_sd_m += shape.bone_sd_m;
        jerks += shape.jerks;
        jerk_m_s3 += shape.jerk_m_s3;
      }
    }
    add(key, "bone", "sd", quotient(bone_sd_m, all_bones), bones);
    add(key, "jerk", "mean", quotient(jerk_m_s3, jerks), jerks);
    key.alignment = summary_.alignments[alignment];
    add(key, "mpjpe", "mean", mpjpe, mpjpe.low_of_size(), errors.bodies(m));
    add_shares_within(key, errors, m, alignment);
  }

  // Of all samples; one without an answer counts as not near.
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

  void add_jerk_of_truth(const ConditionErrors& errors, const std::string& condition) {
    double jerk_m_s3 = 0.0;
    std::uint64_t jerks = 0;
    for (const TakeTable* take : errors.takes())
      for (const TruthRow& truth : take->errors.truth) {
        jerks += truth.jerks;
        jerk_m_s3 += truth.jerk_m_s3;
      }
    add({.condition = condition}, "jerk", "mean_of_truth", quotient(jerk_m_s3, jerks), jerks);
  }

  // Each joint of one take, under the first alignment.
  void add_take(const TakeTable& take, Subset subset, const std::string& condition) {
    std::vector<TakeJointRow> rows;
    std::vector<double> length_m(errors_.joints().size() * axes_.methods);
    for (const std::string& joint : errors_.joints())
      for (const std::string& method : summary_.methods)
        rows.push_back({take.id, take.participant, condition, group_of(joint), joint, method});
    for (const ErrorRow& row : take.errors.errors) {
      if (row.subset != static_cast<std::uint32_t>(subset) || row.alignment != 0) continue;
      const std::size_t k = axes_.joint_of(row) * axes_.methods + row.method;
      rows[k].asked += row.asked();
      rows[k].answered += row.answered;
      length_m[k] += row.length_m;
    }
    for (std::size_t k = 0; k < rows.size(); ++k) {
      rows[k].mae_m = quotient(length_m[k], rows[k].answered);
      if (rows[k].asked > 0) trilat::add_row(rows[k], summary_);
    }
  }

  // On average over the joint groups, over what its methods answer.
  void add_family(const ConditionErrors& errors, const std::string& condition, const MethodFamily& family) {
    if (errors.groups().empty()) return;
    Contrast mean;
    CellSums counts;
    for (const std::size_t g : errors.groups()) {
      ClusterSums sums;
      for (const std::string& method : family.methods) {
        const CellSums& cell = errors.cell(g, place_of(method), 0);
        sums.add(cell.length_m);
        counts.add_counts(cell);
      }
      mean.value.push_back(
          sums.ratio(errors.cluster_count(), 1.0 / static_cast<double>(errors.groups().size())));
    }
    const ContrastEstimate mean_m = solve_contrast(mean);
    const NumberKey key{.condition = condition,
                        .group = kAverageGroup,
                        .method = family.name,
                        .alignment = summary_.alignments.front()};
    add(key, "distance", "mean_of_sets", mean_m, mean_m.low_of_size(), counts.answered);
    add(key, "answered", "share_of_sets", quotient(static_cast<double>(counts.answered), counts.asked),
        counts.asked);
  }

  bool is_of_set(std::size_t method) const {
    return std::ranges::any_of(summary_.families, [&](const MethodFamily& family) {
      return family.sensors > 1 && family.methods.size() > 1 &&
             std::ranges::find(family.methods, summary_.methods[method]) != family.methods.end();
    });
  }

  void add_best(const ConditionErrors& errors, const std::string& condition) {
    for (const auto& groups : rows_of(errors)) {
      const std::vector<std::size_t> methods = competitors(errors, groups);
      if (methods.empty()) continue;
      // The methods cannot be compared without an interval, so none is best.
      if (methods.size() > 1 && errors.mean_m(groups, methods.front(), 0).clusters < 2) continue;
      BestMethod best{condition, name_of_row(groups), summary_.methods[methods.front()], {}};
      for (const std::size_t m : std::span(methods).subspan(1)) {
        const ContrastEstimate e = errors.difference(groups, m, methods.front(), 0).m;
        if (e.clusters >= 2 && !is_told_apart(e, methods.size() - 1))
          best.like_best.push_back(summary_.methods[m]);
      }
      summary_.best.push_back(std::move(best));
    }
  }

  // The methods that compete in some groups, the one that errs least first.
  std::vector<std::size_t> competitors(const ConditionErrors& errors,
                                       const std::vector<std::size_t>& groups) const {
    constexpr double kCompetes = 0.95;  // of what it is asked: to answer the easy samples alone wins nothing
    struct Competitor {
      std::size_t method;
      double mean_m, coverage;
    };
    std::vector<Competitor> all;
    for (std::size_t m = 0; m < axes_.methods; ++m) {
      CellSums counts;
      for (const std::size_t g : groups) counts.add_counts(errors.cell(g, m, 0));
      const double mean_m = errors.mean_m(groups, m, 0).value;
      if (!std::isnan(mean_m) && !is_of_set(m))
        all.push_back({m, mean_m, quotient(static_cast<double>(counts.answered), counts.asked)});
    }
    const auto is_silent = [](const Competitor& c) { return !(c.coverage >= kCompetes); };
    if (!std::ranges::all_of(all, is_silent)) std::erase_if(all, is_silent);
    std::ranges::stable_sort(all, {}, &Competitor::mean_m);
    std::vector<std::size_t> methods;
    for (const Competitor& c : all) methods.push_back(c.method);
    return methods;
  }

  const StudyErrors& errors_;
  const TableAxes& axes_;
  ResultsSummary& summary_;
  Numbers& numbers_;
  std::size_t reference_ = 0;
};

}  // namespace

void add_numbers(const StudyErrors& errors, ResultsSummary& summary) { StudyNumbers(errors, summary).add(); }

}  // namespace trilat
