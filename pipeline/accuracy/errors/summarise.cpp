// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/errors/summarise.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/skeleton/skeleton.h"
#include "evaluators/metrics/body_metrics.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "pipeline/accuracy/errors/participant_errors.h"

namespace trilat {
namespace {

// A mean, as sums by cluster.
struct ClusterSums {
  std::vector<double> sum, n;
  void add(std::size_t cluster, double more, double count) {
    if (sum.size() <= cluster) {
      sum.resize(cluster + 1);
      n.resize(cluster + 1);
    }
    sum[cluster] += more;
    n[cluster] += count;
  }
  // Of so many clusters.
  WeightedRatio ratio(std::size_t clusters, double weight = 1.0) const {
    WeightedRatio ratio{sum, n, weight};
    ratio.numerator.resize(clusters);
    ratio.denominator.resize(clusters);
    return ratio;
  }
};

// All samples of one group, method and alignment.
struct CellSums {
  std::uint64_t asked = 0, answered = 0, iterations = 0;
  std::array<std::uint64_t, kMostStatuses> statuses{};
  double length_m2 = 0.0, largest_m = 0.0;
  std::array<double, 3> absolute_m{};
  ClusterSums length_m;
  std::vector<std::uint64_t> histogram;

  void add(const ErrorRow& row, std::size_t cluster) {
    asked += row.asked();
    answered += row.answered;
    iterations += row.iterations;
    for (std::size_t s = 0; s < kMostStatuses; ++s) statuses[s] += row.statuses[s];
    length_m2 += row.length_m2;
    largest_m = std::max(largest_m, row.largest_m);
    for (std::size_t axis = 0; axis < 3; ++axis) absolute_m[axis] += row.absolute_m[axis];
    length_m.add(cluster, row.length_m, row.answered);
  }
  void add(std::span<const BinRow> bins) {
    histogram.resize(kLastBin + 1);
    for (const BinRow& row : bins) histogram[row.bin] += row.n;
  }
  // The length that so many are shorter than, when the samples of a bin are spread evenly over it.
  double length_at(std::uint64_t place) const {
    std::uint64_t before = 0;
    for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
      if (place < before + histogram[bin]) {
        const double low_m = static_cast<double>(bin) * kBin_m;
        const double high_m = bin == kLastBin ? largest_m : low_m + kBin_m;
        const double share =
            (static_cast<double>(place - before) + 0.5) / static_cast<double>(histogram[bin]);
        return std::min(largest_m, low_m + (high_m - low_m) * share);
      }
      before += histogram[bin];
    }
    return largest_m;
  }
  // Type 7 of Hyndman and Fan 1996.
  double quantile_m(double q) const {
    if (answered == 0) return kNoNumber;
    const double place = q * static_cast<double>(answered - 1);
    const auto below = static_cast<std::uint64_t>(place);
    const double low_m = length_at(below), high_m = length_at(std::min(below + 1, answered - 1));
    return low_m + (place - static_cast<double>(below)) * (high_m - low_m);
  }
};

struct PairSums {
  std::uint64_t n = 0;
  ClusterSums first_m, difference_m, second_m;  // difference: first - second
};

// What the tables are grouped by.
struct Axes {
  std::vector<std::size_t> group_of_joint;
  std::size_t groups = 0, methods = 0, alignments = 0;

  // Of whatever track.
  std::size_t joint_of(const auto& row) const { return row.quantity % group_of_joint.size(); }
  std::size_t group_of(const auto& row) const { return group_of_joint[joint_of(row)]; }

  Axes(const std::vector<std::string>& joints, std::size_t methods_, std::size_t alignments_)
      : methods(methods_), alignments(alignments_) {
    const std::vector<std::string> names = groups_of(joints);
    groups = names.size();
    for (const std::string& joint : joints)
      group_of_joint.push_back(
          static_cast<std::size_t>(std::ranges::find(names, trilat::group_of(joint)) - names.begin()));
  }
};

// The samples of the takes of one activity, of one subset, by group, method and alignment.
class ConditionErrors {
 public:
  ConditionErrors(std::span<const TakeTable> takes, const std::string& activity, Subset subset,
                  std::size_t participants, const Axes& axes)
      : axes_(axes),
        cells_(axes.groups * axes.methods * axes.alignments),
        pairs_(cells_.size() * axes.methods),
        bodies_(2 * axes.methods) {
    for (const TakeTable& take : takes)
      if (take.activity == activity) takes_.push_back(&take);
    std::vector<std::string> names;
    const bool by_block = participants < kFewestParticipants && takes_.size() == 1;
    for (const TakeTable* take : takes_) {
      const std::string& name = participants < kFewestParticipants ? take->id : take->participant;
      auto found = std::ranges::find(names, name);
      if (found == names.end()) found = names.insert(names.end(), name);
      add(take->errors, subset, by_block, static_cast<std::size_t>(found - names.begin()));
    }
    clusters_ = names.size();
    for (const CellSums& sums : cells_) clusters_ = std::max(clusters_, sums.length_m.n.size());
    for (std::size_t g = 0; g < axes.groups; ++g)
      if (cell(g, 0, 0).asked > 0 || std::ranges::any_of(cells_of(g), is_asked)) groups_.push_back(g);
  }

  const std::vector<const TakeTable*>& takes() const { return takes_; }
  // Those of which anything is asked.
  const std::vector<std::size_t>& groups() const { return groups_; }
  const CellSums& cell(std::size_t group, std::size_t method, std::size_t alignment) const {
    return cells_[(group * axes_.methods + method) * axes_.alignments + alignment];
  }

  // The plain mean of some groups' mean errors.
  ContrastEstimate mean_m(std::span<const std::size_t> groups, std::size_t method,
                          std::size_t alignment) const {
    Contrast mean;
    for (const std::size_t g : groups)
      mean.value.push_back(cell(g, method, alignment).length_m.ratio(clusters_, weight(groups)));
    return solve_contrast(mean);
  }

  // Of two methods on the samples that both answer.
  struct Difference {
    std::uint64_t n = 0;
    ContrastEstimate m, share;  // first - second, and that over the second's
  };
  Difference difference(std::span<const std::size_t> groups, std::size_t first, std::size_t second,
                        std::size_t alignment) const {
    Difference difference;
    Contrast m, share;
    for (const std::size_t g : groups) {
      const PairSums& sums = pairs_[pair(g, first, second, alignment)];
      difference.n += sums.n;
      m.value.push_back(sums.difference_m.ratio(clusters_, weight(groups)));
      share.base.push_back(sums.second_m.ratio(clusters_, weight(groups)));
    }
    share.value = m.value;
    difference.m = solve_contrast(m);
    difference.share = solve_contrast(share);
    return difference;
  }
  // The first method's mean error on these; NaN without any.
  double paired_m(std::size_t group, std::size_t first, std::size_t second, std::size_t alignment) const {
    return solve_contrast({{pairs_[pair(group, first, second, alignment)].first_m.ratio(clusters_)}, {}})
        .value;
  }

  ContrastEstimate mpjpe_m(std::size_t method) const {
    return solve_contrast({{bodies_[2 * method].ratio(clusters_)}, {}});
  }
  ContrastEstimate pa_mpjpe_m(std::size_t method) const {
    return solve_contrast({{bodies_[2 * method + 1].ratio(clusters_)}, {}});
  }
  std::uint64_t bodies(std::size_t method) const {
    double n = 0.0;
    for (const double more : bodies_[2 * method].n) n += more;
    return static_cast<std::uint64_t>(n);
  }

 private:
  static bool is_asked(const CellSums& sums) { return sums.asked > 0; }
  static double weight(std::span<const std::size_t> groups) {
    return 1.0 / static_cast<double>(groups.size());
  }
  std::span<const CellSums> cells_of(std::size_t group) const {
    const std::size_t count = axes_.methods * axes_.alignments;
    return std::span(cells_).subspan(group * count, count);
  }
  CellSums& cell_of(const auto& row) {
    return cells_[(axes_.group_of(row) * axes_.methods + row.method) * axes_.alignments + row.alignment];
  }
  std::size_t pair(std::size_t group, std::size_t first, std::size_t second, std::size_t alignment) const {
    return ((group * axes_.methods + first) * axes_.methods + second) * axes_.alignments + alignment;
  }

  void add(const ErrorTable& table, Subset subset, bool by_block, std::size_t cluster) {
    const auto is_of = [&](const auto& row) { return row.subset == static_cast<std::uint32_t>(subset); };
    const auto cluster_of = [&](const auto& row) { return by_block ? row.block : cluster; };
    for (const ErrorRow& row : table.errors)
      if (is_of(row)) cell_of(row).add(row, cluster_of(row));
    std::span<const BinRow> bins(table.bins);
    for (const HistogramRow& row : table.histograms) {
      if (is_of(row)) cell_of(row).add(bins.first(row.bins));
      bins = bins.subspan(row.bins);
    }
    for (const PairRow& row : table.pairs) {
      if (!is_of(row)) continue;
      const std::size_t g = axes_.group_of(row);
      add(pairs_[pair(g, row.first, row.second, row.alignment)], row, row.first_m, row.second_m,
          cluster_of(row));
      add(pairs_[pair(g, row.second, row.first, row.alignment)], row, row.second_m, row.first_m,
          cluster_of(row));
    }
    for (const BodyRow& row : table.bodies) {
      if (row.method != row.with) continue;
      bodies_[2 * row.method].add(cluster_of(row), row.mpjpe_m, row.n);
      bodies_[2 * row.method + 1].add(cluster_of(row), row.pa_mpjpe_m, row.pa_n);
    }
  }
  static void add(PairSums& sums, const PairRow& row, double first_m, double second_m, std::size_t cluster) {
    sums.n += row.n;
    sums.first_m.add(cluster, first_m, row.n);
    sums.difference_m.add(cluster, first_m - second_m, row.n);
    sums.second_m.add(cluster, second_m, row.n);
  }

  const Axes& axes_;
  std::vector<const TakeTable*> takes_;
  std::size_t clusters_ = 0;
  std::vector<CellSums> cells_;
  std::vector<PairSums> pairs_;
  std::vector<ClusterSums> bodies_;  // by method: MPJPE, PA-MPJPE
  std::vector<std::size_t> groups_;
};

// A mean distance is not negative, whatever the width of its interval; NaN stays.
double not_below_zero(double distance_m) { return distance_m < 0.0 ? 0.0 : distance_m; }

void set_interval(SummaryCell& cell, const ContrastEstimate& mean) {
  cell.mae_m = mean.value;
  cell.mae_low_m = not_below_zero(mean.low());
  cell.mae_high_m = mean.high();
  cell.clusters = mean.clusters;
}

double quotient(double sum, std::uint64_t n) { return n == 0 ? kNoNumber : sum / static_cast<double>(n); }

class Summary {
 public:
  Summary(std::span<const TakeTable> takes, const std::vector<std::string>& joints, ResultsSummary& summary)
      : takes_(takes),
        joints_(joints),
        summary_(summary),
        axes_(joints, summary.methods.size(), summary.alignments.size()) {}

  void fill() {
    find_reference();
    std::vector<SummaryCell> averages;
    for (const std::string& condition : summary_.conditions) add_condition(condition, averages);
    std::ranges::move(averages, std::back_inserter(summary_.cells));
    for (const TakeTable& take : takes_)
      for (const Subset subset : {Subset::all, Subset::occluded}) add_rows_of_take(take, subset);
    const ParticipantErrors errors(summary_);
    for (const std::string& condition : summary_.conditions)
      for (const MethodFamily& family : summary_.families) add_family(errors, condition, family);
  }

 private:
  void find_reference() {
    const auto place_of = [&](const std::string& method) {
      return static_cast<std::size_t>(std::ranges::find(summary_.methods, method) - summary_.methods.begin());
    };
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

  // The activity and the subset that a condition's name says.
  ConditionErrors errors_in(const std::string& condition) const {
    for (const TakeTable& take : takes_)
      if (occluded_condition(take.activity) == condition)
        return {takes_, take.activity, Subset::occluded, summary_.participants, axes_};
    return {takes_, condition, Subset::all, summary_.participants, axes_};
  }

  void add_condition(const std::string& condition, std::vector<SummaryCell>& averages) {
    const ConditionErrors errors = errors_in(condition);
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
    const bool is_whole_activity =
        std::ranges::any_of(takes_, [&](const TakeTable& take) { return take.activity == condition; });
    if (!is_whole_activity) return;
    for (std::size_t m = 0; m < axes_.methods; ++m) summary_.bodies.push_back(body_of(errors, condition, m));
    if (summary_.left_out()) return;  // a sensor stands for the truth
    for (const std::size_t g : errors.groups())
      summary_.truth_speed.push_back({condition, summary_.groups[g], speed_of(errors, g)});
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

  SummaryCell cell_of(const ConditionErrors& errors, const std::string& condition, std::size_t g,
                      std::size_t m, std::size_t a) const {
    SummaryCell cell = head_of(condition, summary_.groups[g], m, a);
    const CellSums& sums = errors.cell(g, m, a);
    count(cell, sums);
    set_interval(cell, errors.mean_m(std::array{g}, m, a));
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell.axis_mae_m[axis] = quotient(sums.absolute_m[axis], sums.answered);
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
    return cell;
  }

  DifferenceCell difference_of(const ConditionErrors& errors, const std::string& condition,
                               const std::vector<std::size_t>& groups, std::size_t m, std::size_t a) const {
    const ConditionErrors::Difference d = errors.difference(groups, m, reference_, a);
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
    cell.mpjpe_low_m = not_below_zero(mpjpe.low());
    cell.mpjpe_high_m = mpjpe.high();
    cell.pa_mpjpe_m = pa_mpjpe.value;
    cell.pa_mpjpe_low_m = not_below_zero(pa_mpjpe.low());
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
        const auto bins = static_cast<std::size_t>(std::llround(kPckRadii_m[r] / kBin_m));
        for (std::size_t bin = 0; bin < std::min(bins, sums.histogram.size()); ++bin)
          within += sums.histogram[bin];
      }
      pck[r] = quotient(static_cast<double>(within), asked);
    }
    return pck;
  }

  double speed_of(const ConditionErrors& errors, std::size_t group) const {
    double speed_m_s = 0.0;
    std::uint64_t n = 0;
    for (const TakeTable* take : errors.takes())
      for (const TruthRow& row : take->errors.truth)
        if (axes_.group_of(row) == group) {
          speed_m_s += row.speed_m_s;
          n += row.speeds;
        }
    return quotient(speed_m_s, n);
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
  // The same of every method and the reference, on the samples that both answer.
  std::vector<std::pair<OfJoint, OfJoint>> pairs_of(const ErrorTable& table, Subset subset) const {
    std::vector<std::pair<OfJoint, OfJoint>> sums(joints_.size() * axes_.methods);
    for (const PairRow& row : table.pairs) {
      const bool is_second = row.second == reference_;
      if (row.subset != static_cast<std::uint32_t>(subset) || row.alignment != 0) continue;
      if (!is_second && row.first != reference_) continue;
      auto& [own, reference] =
          sums[axes_.joint_of(row) * axes_.methods + (is_second ? row.first : row.second)];
      own.answered += row.n;
      own.length_m += is_second ? row.first_m : row.second_m;
      reference.length_m += is_second ? row.second_m : row.first_m;
    }
    return sums;
  }

  void add_rows_of_take(const TakeTable& take, Subset subset) {
    const std::vector<OfJoint> all = joints_of(take.errors, subset);
    const std::vector<OfJoint> fast =
        subset == Subset::all ? joints_of(take.errors, Subset::fast) : std::vector<OfJoint>(all.size());
    const auto pairs = pairs_of(take.errors, subset);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const std::size_t j = k / axes_.methods, m = k % axes_.methods;
      if (all[k].asked == 0) continue;
      const OfJoint &own = all[k], &reference = all[j * axes_.methods + reference_];
      TakeJointRow row{take.id,
                       take.participant,
                       subset == Subset::all ? take.activity : occluded_condition(take.activity),
                       group_of(joints_[j]),
                       joints_[j],
                       summary_.methods[m],
                       own.asked,
                       own.answered,
                       quotient(own.length_m, own.answered)};
      const auto& [of_both, reference_of_both] = m == reference_ ? std::pair{own, own} : pairs[k];
      row.both = {of_both.answered, quotient(of_both.length_m, of_both.answered),
                  quotient(reference_of_both.length_m, of_both.answered)};
      const std::uint64_t any = own.answered + reference.answered - of_both.answered;
      row.complete = {any, quotient(own.length_m + reference.length_m - reference_of_both.length_m, any),
                      quotient(reference.length_m + own.length_m - of_both.length_m, any)};
      if (subset == Subset::all) {
        const std::uint64_t slow = own.answered - fast[k].answered;
        row.by_speed = {slow, fast[k].answered, quotient(own.length_m - fast[k].length_m, slow),
                        quotient(fast[k].length_m, fast[k].answered)};
      }
      summary_.by_take.push_back(std::move(row));
    }
  }

  // On average over the joint groups, over what its methods answer.
  void add_family(const ParticipantErrors& errors, const std::string& condition, const MethodFamily& family) {
    Contrast mean;
    const std::vector<std::string> groups = errors.groups_of(condition);
    for (const std::string& group : groups) {
      mean.value.push_back(errors.error_m(family.name, condition, group));
      mean.value.back().weight = 1.0 / static_cast<double>(groups.size());
    }
    const ContrastEstimate own = solve_contrast(mean);
    double asked = 0.0, answered = 0.0;
    for (const TakeJointRow& row : summary_.by_take) {
      const bool is_of = std::ranges::find(family.methods, row.method) != family.methods.end();
      if (row.condition != condition || !is_of) continue;
      asked += static_cast<double>(row.asked);
      answered += static_cast<double>(row.answered);
    }
    summary_.family_cells.push_back(
        {family.name, condition, own.value, own.low(), own.high(), answered / asked});
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

  std::span<const TakeTable> takes_;
  const std::vector<std::string>& joints_;
  ResultsSummary& summary_;
  const Axes axes_;
  std::size_t reference_ = 0;
};

}  // namespace

std::string group_of(const std::string& joint) {
  const std::optional<Joint> known = joint_from_name(joint);
  return known ? table_group(*known) : joint;
}

std::vector<std::string> groups_of(const std::vector<std::string>& joints) {
  std::vector<std::string> groups;
  for (const std::string& joint : joints)
    if (std::ranges::find(groups, group_of(joint)) == groups.end()) groups.push_back(group_of(joint));
  return groups;
}

void summarise(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
               ResultsSummary& summary) {
  Summary(takes, joints, summary).fill();
}

std::vector<double> paired_errors_m(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
                                    std::size_t methods, const std::string& activity) {
  const std::size_t alignments = takes.empty() ? 0 : takes.front().errors.alignments.size();
  const Axes axes(joints, methods, alignments);
  const ConditionErrors errors(takes, activity, Subset::all, 0, axes);
  std::vector<double> paired_m;
  for (std::size_t a = 0; a < alignments; ++a)
    for (std::size_t m = 0; m < methods; ++m)
      for (std::size_t with = 0; with < methods; ++with) {
        double sum_m = 0.0;
        for (std::size_t g = 0; g < axes.groups; ++g)
          sum_m += m == with ? errors.mean_m(std::array{g}, m, a).value : errors.paired_m(g, m, with, a);
        paired_m.push_back(sum_m / static_cast<double>(axes.groups));
      }
  return paired_m;
}

}  // namespace trilat
