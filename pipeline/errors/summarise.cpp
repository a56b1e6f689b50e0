// SPDX-License-Identifier: MIT
#include "pipeline/errors/summarise.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/metrics/cluster_ratios.h"

namespace trilat {
namespace {

void set_interval(SummaryCell& cell, const ContrastEstimate& mean) {
  cell.mae_m = mean.value;
  cell.mae_low_m = mean.low_of_size();
  cell.mae_high_m = mean.high();
  cell.clusters = mean.clusters;
}

double quotient(double sum, std::uint64_t n) { return n == 0 ? kNoNumber : sum / static_cast<double>(n); }

class Summary {
 public:
  Summary(const StudyErrors& errors, ResultsSummary& summary)
      : errors_(errors),
        takes_(errors.takes()),
        joints_(errors.joints()),
        axes_(errors.axes()),
        summary_(summary) {}

  void fill() {
    find_reference();
    std::vector<SummaryCell> averages;
    for (const std::string& condition : summary_.conditions) add_condition(condition, averages);
    std::ranges::move(averages, std::back_inserter(summary_.cells));
    for (const TakeTable& take : takes_)
      for (const Subset subset : {Subset::all, Subset::occluded}) add_rows_of_take(take, subset);
  }

 private:
  std::size_t place_of(const std::string& method) const {
    return static_cast<std::size_t>(std::ranges::find(summary_.methods, method) - summary_.methods.begin());
  }
  void find_reference() {
    reference_ = place_of(summary_.reference);
    std::vector<bool> answers(axes_.methods);
    for (const TakeTable& take : takes_)
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

  void add_condition(const std::string& condition, std::vector<SummaryCell>& averages) {
    const ConditionErrors errors = errors_.in(condition);
    for (const std::size_t g : errors.groups())
      for (std::size_t m = 0; m < axes_.methods; ++m)
        for (std::size_t a = 0; a < axes_.alignments; ++a)
          if (errors.cell(g, m, a).asked > 0) summary_.cells.push_back(cell_of(errors, condition, g, m, a));
    for (std::size_t m = 0; m < axes_.methods; ++m)
      for (std::size_t a = 0; a < axes_.alignments; ++a) {
        std::vector<std::vector<std::size_t>> rows;
        for (const std::size_t g : errors.groups()) rows.push_back({g});
        if (rows.size() >= 2) {
          rows.push_back(errors.groups());
          averages.push_back(average_of(errors, condition, m, a));
        }
        for (const auto& groups : rows)
          if (m != reference_) summary_.differences.push_back(difference_of(errors, condition, groups, m, a));
      }
    add_best(errors, condition);
    for (const MethodFamily& family : summary_.families) add_family(errors, condition, family);
    const bool is_whole_activity =
        std::ranges::any_of(takes_, [&](const TakeTable& take) { return take.activity == condition; });
    if (!is_whole_activity) return;
    for (std::size_t m = 0; m < axes_.methods; ++m) summary_.bodies.push_back(body_of(errors, condition, m));
  }

  SummaryCell head_of(const std::string& condition, const std::string& group, std::size_t m,
                      std::size_t a) const {
    SummaryCell cell;
    cell.method = summary_.methods[m];
    cell.condition = condition;
    cell.group = group;
    cell.alignment = summary_.alignments[a];
    return cell;
  }
  static void count(SummaryCell& cell, const CellSums& sums) {
    cell.asked += sums.asked;
    cell.answered += sums.answered;
    for (std::size_t s = 0; s < kSolveStatusCount; ++s)
      if (sums.statuses[s] > 0)
        cell.statuses[std::string(name_of(static_cast<SolveStatus>(s)))] += sums.statuses[s];
  }

  static double bias_of(const CellSums& sums, std::size_t axis) {
    double sum_m = 0.0;
    for (const double part_m : sums.error_m[axis].sum) sum_m += part_m;
    return quotient(sum_m, sums.answered);
  }

  SummaryCell cell_of(const ConditionErrors& errors, const std::string& condition, std::size_t g,
                      std::size_t m, std::size_t a) const {
    SummaryCell cell = head_of(condition, summary_.groups[g], m, a);
    const CellSums& sums = errors.cell(g, m, a);
    count(cell, sums);
    set_interval(cell, errors.mean_m(std::array{g}, m, a));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell.axis_mae_m[axis] = quotient(sums.absolute_m[axis], sums.answered);
      cell.bias_m[axis] = bias_of(sums, axis);
    }
    cell.rmse_m = std::sqrt(quotient(sums.length_m2, sums.answered));
    cell.p05_m = sums.quantile_m(0.05);
    cell.p25_m = sums.quantile_m(0.25);
    cell.median_m = sums.quantile_m(0.5);
    cell.p75_m = sums.quantile_m(0.75);
    cell.p90_m = sums.quantile_m(0.9);
    cell.p95_m = sums.quantile_m(0.95);
    if (sums.answered > 0) cell.max_m = sums.largest_m;
    cell.mean_iterations = quotient(static_cast<double>(sums.iterations), sums.asked);
    return cell;
  }

  SummaryCell average_of(const ConditionErrors& errors, const std::string& condition, std::size_t m,
                         std::size_t a) const {
    SummaryCell cell = head_of(condition, kAverageGroup, m, a);
    for (const std::size_t g : errors.groups()) count(cell, errors.cell(g, m, a));
    set_interval(cell, errors.mean_m(errors.groups(), m, a));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double sum_m = 0.0;
      for (const std::size_t g : errors.groups()) sum_m += bias_of(errors.cell(g, m, a), axis);
      cell.bias_m[axis] = quotient(sum_m, errors.groups().size());
    }
    return cell;
  }

  DifferenceCell difference_of(const ConditionErrors& errors, const std::string& condition,
                               const std::vector<std::size_t>& groups, std::size_t m, std::size_t a) const {
    const MethodDifference d = errors.difference(groups, m, reference_, a);
    DifferenceCell cell;
    cell.method = summary_.methods[m];
    cell.condition = condition;
    cell.group = groups.size() > 1 ? kAverageGroup : summary_.groups[groups[0]];
    cell.alignment = summary_.alignments[a];
    cell.n = d.n;
    cell.clusters = d.m.clusters;
    cell.difference_m = d.m.value;
    cell.low_m = d.m.low();
    cell.high_m = d.m.high();
    cell.percent_of_reference = 100.0 * d.share.value;
    cell.percent_low = 100.0 * d.share.low();
    cell.percent_high = 100.0 * d.share.high();
    cell.percent_of_method = 100.0 * d.share.value / (1.0 + d.share.value);
    if (!std::isfinite(cell.percent_of_method)) cell.percent_of_method = kNoNumber;
    return cell;
  }

  BodyCell body_of(const ConditionErrors& errors, const std::string& condition, std::size_t m) const {
    BodyCell cell;
    cell.method = summary_.methods[m];
    cell.condition = condition;
    const ContrastEstimate mpjpe = errors.mpjpe_m(m), pa_mpjpe = errors.pa_mpjpe_m(m);
    cell.instants = errors.bodies(m);
    cell.clusters = mpjpe.clusters;
    cell.mpjpe_m = mpjpe.value;
    cell.mpjpe_low_m = mpjpe.low_of_size();
    cell.mpjpe_high_m = mpjpe.high();
    cell.pa_mpjpe_m = pa_mpjpe.value;
    cell.pa_mpjpe_low_m = pa_mpjpe.low_of_size();
    cell.pa_mpjpe_high_m = pa_mpjpe.high();
    std::size_t alignment = 0;
    double bone_sd_m = 0.0, jerk_m_s3 = 0.0, truth_jerk_m_s3 = 0.0;
    std::uint64_t bones = 0, jerks = 0, truth_jerks = 0;
    for (const TakeTable* take : errors.takes()) {
      alignment = take->errors.body_alignment;
      for (const ShapeRow& shape : take->errors.shapes) {
        if (shape.method != m) continue;
        cell.bones = std::max<std::uint64_t>(cell.bones, shape.bones);
        bones += shape.bones;
        bone_sd_m += shape.bone_sd_m;
        jerks += shape.jerks;
        jerk_m_s3 += shape.jerk_m_s3;
      }
      for (const TruthRow& truth : take->errors.truth) {
        truth_jerks += truth.jerks;
        truth_jerk_m_s3 += truth.jerk_m_s3;
      }
    }
    cell.alignment = summary_.alignments[alignment];
    cell.bone_length_sd_m = quotient(bone_sd_m, bones);
    cell.jitter_m_s3 = quotient(jerk_m_s3, jerks);
    cell.truth_jitter_m_s3 = quotient(truth_jerk_m_s3, truth_jerks);
    cell.pck = pck_of(errors, m, alignment);
    return cell;
  }

  // The share is taken of all samples; one without an answer counts as not near.
  std::array<double, 3> pck_of(const ConditionErrors& errors, std::size_t m, std::size_t a) const {
    std::array<double, 3> pck{};
    for (std::size_t r = 0; r < pck.size(); ++r) {
      std::uint64_t asked = 0, within = 0;
      for (const std::size_t g : errors.groups()) {
        const CellSums& sums = errors.cell(g, m, a);
        asked += sums.asked;
        within += sums.below(static_cast<std::size_t>(std::llround(kPckRadii_m[r] / kBin_m)));
      }
      pck[r] = quotient(static_cast<double>(within), asked);
    }
    return pck;
  }

  // Under the first alignment, by joint and method, of one subset.
  struct OfJoint {
    std::uint64_t asked = 0, answered = 0;
    double length_m = 0.0;
  };
  std::vector<OfJoint> joints_of(const ErrorTable& table, Subset subset) const {
    std::vector<OfJoint> sums(joints_.size() * axes_.methods);
    for (const ErrorRow& row : table.errors) {
      if (row.subset != static_cast<std::uint32_t>(subset) || row.alignment != 0) continue;
      OfJoint& of = sums[axes_.joint_of(row) * axes_.methods + row.method];
      of.asked += row.asked();
      of.answered += row.answered;
      of.length_m += row.length_m;
    }
    return sums;
  }
  void add_rows_of_take(const TakeTable& take, Subset subset) {
    const std::vector<OfJoint> all = joints_of(take.errors, subset);
    for (std::size_t k = 0; k < all.size(); ++k)
      if (const OfJoint& own = all[k]; own.asked > 0) {
        const std::string& joint = joints_[k / axes_.methods];
        summary_.by_take.push_back({take.id, take.participant,
                                    subset == Subset::all ? take.activity : occluded_condition(take.activity),
                                    group_of(joint), joint, summary_.methods[k % axes_.methods], own.asked,
                                    own.answered, quotient(own.length_m, own.answered)});
      }
  }

  // On average over the joint groups, over what its methods answer.
  void add_family(const ConditionErrors& errors, const std::string& condition, const MethodFamily& family) {
    Contrast mean;
    std::uint64_t asked = 0, answered = 0;
    for (const std::size_t g : errors.groups()) {
      ClusterSums sums;
      for (const std::string& method : family.methods) {
        const CellSums& cell = errors.cell(g, place_of(method), 0);
        sums.add(cell.length_m);
        asked += cell.asked;
        answered += cell.answered;
      }
      mean.value.push_back(
          sums.ratio(errors.cluster_count(), 1.0 / static_cast<double>(errors.groups().size())));
    }
    const ContrastEstimate own = solve_contrast(mean);
    summary_.family_cells.push_back({family.name, condition, own.value, own.low_of_size(), own.high(),
                                     quotient(static_cast<double>(answered), asked)});
  }

  bool is_of_set(std::size_t method) const {
    return std::ranges::any_of(summary_.families, [&](const MethodFamily& family) {
      return family.sensors > 1 && family.methods.size() > 1 &&
             std::ranges::find(family.methods, summary_.methods[method]) != family.methods.end();
    });
  }

  void add_best(const ConditionErrors& errors, const std::string& condition) {
    std::vector<std::vector<std::size_t>> rows;
    for (const std::size_t g : errors.groups()) rows.push_back({g});
    if (rows.size() > 1) rows.push_back(errors.groups());
    for (const auto& groups : rows) {
      const std::vector<std::size_t> methods = competitors(errors, groups);
      if (methods.empty()) continue;
      // The methods cannot be compared without an interval, so none is best.
      if (methods.size() > 1 && errors.mean_m(groups, methods.front(), 0).clusters < 2) continue;
      BestMethod best{condition,
                      groups.size() > 1 ? kAverageGroup : summary_.groups[groups[0]],
                      summary_.methods[methods.front()],
                      {}};
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
      std::uint64_t asked = 0, answered = 0;
      for (const std::size_t g : groups) {
        asked += errors.cell(g, m, 0).asked;
        answered += errors.cell(g, m, 0).answered;
      }
      const double mean_m = errors.mean_m(groups, m, 0).value;
      if (!std::isnan(mean_m) && !is_of_set(m))
        all.push_back({m, mean_m, quotient(static_cast<double>(answered), asked)});
    }
    const auto is_silent = [](const Competitor& c) { return !(c.coverage >= kCompetes); };
    if (!std::ranges::all_of(all, is_silent)) std::erase_if(all, is_silent);
    std::ranges::stable_sort(all, {}, &Competitor::mean_m);
    std::vector<std::size_t> methods;
    for (const Competitor& c : all) methods.push_back(c.method);
    return methods;
  }

  const StudyErrors& errors_;
  const std::span<const TakeTable> takes_;
  const std::vector<std::string>& joints_;
  const TableAxes& axes_;
  ResultsSummary& summary_;
  std::size_t reference_ = 0;
};

}  // namespace

void summarise(const StudyErrors& errors, ResultsSummary& summary) { Summary(errors, summary).fill(); }

}  // namespace trilat
