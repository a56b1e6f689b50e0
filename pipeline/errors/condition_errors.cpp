// SPDX-License-Identifier: MIT
#include "pipeline/errors/condition_errors.h"

#include <algorithm>
#include <optional>
#include <set>

#include "datasets/base/error.h"
#include "datasets/rig/skeleton.h"
#include "evaluators/alignment/alignment.h"

namespace trilat {
namespace {

bool is_of(const auto& row, Subset subset) { return row.subset == static_cast<std::uint32_t>(subset); }

double weight_of(std::span<const std::size_t> groups) { return 1.0 / static_cast<double>(groups.size()); }

// By take: which participant, or which take.
std::vector<std::size_t> cluster_of(std::span<const TakeTable> takes, bool by_participant) {
  std::vector<std::string> names;
  std::vector<std::size_t> clusters;
  for (const TakeTable& take : takes) {
    const std::string& name = by_participant ? take.participant : take.id;
    auto found = std::ranges::find(names, name);
    if (found == names.end()) found = names.insert(names.end(), name);
    clusters.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  return clusters;
}

}  // namespace

bool leaves_training_out(const std::string& alignment) {
  const std::optional<AlignmentKind> kind = alignment_from_name(alignment);
  return kind && is_trained(*kind);
}

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

void ClusterSums::add(std::size_t cluster, double more, double count) {
  if (sum.size() <= cluster) {
    sum.resize(cluster + 1);
    n.resize(cluster + 1);
  }
  sum[cluster] += more;
  n[cluster] += count;
}

void ClusterSums::add(const ClusterSums& more) {
  for (std::size_t c = 0; c < more.n.size(); ++c) add(c, more.sum[c], more.n[c]);
}

WeightedRatio ClusterSums::ratio(std::size_t clusters, double weight) const {
  WeightedRatio ratio{sum, n, weight};
  ratio.numerator.resize(clusters);
  ratio.denominator.resize(clusters);
  return ratio;
}

void MeasureSums::add(const ErrorSums& row, std::size_t cluster) {
  n += row.n;
  sum_abs += row.sum_abs;
  largest = std::max(largest, row.largest);
  sum.add(cluster, row.sum, row.n);
  squares.add(cluster, row.sum_squares, row.n);
  absolute.add(cluster, row.sum_abs, row.n);
}

namespace {
double sum_of(const ClusterSums& sums) {
  double sum = 0.0;
  for (const double part : sums.sum) sum += part;
  return sum;
}
}  // namespace

double MeasureSums::total() const { return sum_of(sum); }
double MeasureSums::total_squares() const { return sum_of(squares); }

void CellSums::add(const ErrorSums& row, std::size_t cluster) {
  if (row.is(Measure::distance)) {
    answered += row.n;
    distance.add(row, cluster);
  } else {
    axes.at(row.measure - static_cast<std::uint32_t>(Measure::x)).add(row, cluster);
  }
}

void CellSums::add(const EndedRow& row) {
  asked += row.asked();
  iterations += row.iterations;
  for (std::size_t s = 0; s < kMaxStatuses; ++s) statuses[s] += row.statuses[s];
}

void CellSums::add(std::span<const BinRow> bins) {
  histogram.resize(kLastBin + 1);
  for (const BinRow& row : bins) histogram[row.bin] += row.n;
}

void CellSums::add_counts(const CellSums& more) {
  asked += more.asked;
  answered += more.answered;
  for (std::size_t s = 0; s < kMaxStatuses; ++s) statuses[s] += more.statuses[s];
}

// The length that so many are shorter than.
double CellSums::length_at(std::uint64_t place) const {
  std::uint64_t before = 0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    if (place < before + histogram[bin]) {
      const auto of_bin = static_cast<std::uint32_t>(bin);
      const double low_m = bin_starts_at_m(of_bin);
      const double high_m = bin == kLastBin ? distance.largest : bin_starts_at_m(of_bin + 1);
      const double share = (static_cast<double>(place - before) + 0.5) / static_cast<double>(histogram[bin]);
      return std::min(distance.largest, low_m + (high_m - low_m) * share);
    }
    before += histogram[bin];
  }
  return distance.largest;
}

double CellSums::quantile_m(double q) const {
  if (answered == 0) return kNaN;
  const double place = q * static_cast<double>(answered - 1);
  const auto below = static_cast<std::uint64_t>(place);
  const double low_m = length_at(below), high_m = length_at(std::min(below + 1, answered - 1));
  return low_m + (place - static_cast<double>(below)) * (high_m - low_m);
}

std::uint64_t CellSums::below(std::size_t bins) const {
  std::uint64_t sum = 0;
  for (std::size_t bin = 0; bin < std::min(bins, histogram.size()); ++bin) sum += histogram[bin];
  return sum;
}

TableAxes::TableAxes(const std::vector<std::string>& joints, std::size_t methods_, std::size_t alignments_)
    : groups(groups_of(joints)), methods(methods_), alignments(alignments_) {
  for (const std::string& joint : joints)
    group_of_joint.push_back(
        static_cast<std::size_t>(std::ranges::find(groups, trilat::group_of(joint)) - groups.begin()));
}

ConditionErrors::ConditionErrors(std::span<const TakeTable> takes, const std::string& activity, Subset subset,
                                 const TableAxes& axes)
    : axes_(axes),
      cells_(axes.groups.size() * axes.methods * axes.alignments),
      pairs_(cells_.size() * axes.methods) {
  for (const TakeTable& take : takes)
    if (take.activity == activity) takes_.push_back(&take);
  std::set<std::string> participants;
  for (const TakeTable* take : takes_) participants.insert(take->participant);
  const bool by_participant = participants.size() >= kMinParticipants;
  const bool by_block = !by_participant && takes_.size() == 1;
  if (!by_participant) cluster_kind_ = by_block ? "blocks of time" : "takes";
  const std::vector<std::size_t> clusters = cluster_of(takes, by_participant);
  for (std::size_t t = 0; t < takes.size(); ++t) {
    if (!by_block) cluster_count_ = std::max(cluster_count_, clusters[t] + 1);
    if (takes[t].activity != activity) continue;
    add(takes[t].errors, subset, clusters[t], by_block);
    for (const auto& [pair, rows] : takes[t].pairs) {
      compared_.insert(pair);
      for (const PairRow& row : rows)
        if (is_of(row, subset)) add_pair(pair, row, by_block ? row.block : clusters[t]);
    }
  }
  for (const CellSums& sums : cells_) cluster_count_ = std::max(cluster_count_, sums.distance.sum.n.size());
  for (std::size_t g = 0; g < axes.groups.size(); ++g) {
    const auto of_group = std::span(cells_).subspan(place(g, 0, 0), axes.methods * axes.alignments);
    if (std::ranges::any_of(of_group, [](const CellSums& sums) { return sums.asked > 0; }))
      groups_.push_back(g);
  }
}

std::size_t ConditionErrors::place(std::size_t group, std::size_t method, std::size_t alignment) const {
  return (group * axes_.methods + method) * axes_.alignments + alignment;
}
std::size_t ConditionErrors::place(std::size_t group, std::size_t first, std::size_t second,
                                   std::size_t alignment) const {
  return ((group * axes_.methods + first) * axes_.methods + second) * axes_.alignments + alignment;
}

const CellSums& ConditionErrors::cell(std::size_t group, std::size_t method, std::size_t alignment) const {
  return cells_[place(group, method, alignment)];
}
const PairSums& ConditionErrors::pair(std::size_t group, std::size_t first, std::size_t second,
                                      std::size_t alignment) const {
  const auto lower = static_cast<std::uint32_t>(std::min(first, second)),
             higher = static_cast<std::uint32_t>(std::max(first, second));
  TRILAT_CHECK(compared_.contains({lower, higher}), "the errors of a pair are computed before they are read");
  return pairs_[place(group, first, second, alignment)];
}

void ConditionErrors::add(const TakeErrors& errors, Subset subset, std::size_t cluster, bool by_block) {
  const auto cell_of = [&](const auto& row, std::size_t alignment) -> CellSums& {
    return cells_[place(axes_.group_of(row), row.method, alignment)];
  };
  for (const ErrorSums& row : errors.sums)
    if (is_of(row, subset)) add_sums(errors, row, subset, by_block ? row.block : cluster);
  for (const EndedRow& row : errors.ended)
    for (std::size_t a = 0; a < axes_.alignments; ++a)
      if (is_of(row, subset) && (row.test > 0 || !leaves_training_out(errors.alignments[a])))
        cell_of(row, a).add(row);
  std::span<const BinRow> bins(errors.bins);
  for (const HistogramRow& row : errors.histograms) {
    if (is_of(row, subset)) cell_of(row, row.alignment).add(bins.first(row.bins));
    bins = bins.subspan(row.bins);
  }
}

void ConditionErrors::add_sums(const TakeErrors& errors, const ErrorSums& row, Subset subset,
                               std::size_t cluster) {
  if (row.measure <= static_cast<std::uint32_t>(Measure::z)) {
    cells_[place(axes_.group_of(row), row.method, row.alignment)].add(row, cluster);
    return;
  }
  if (subset != Subset::all) return;
  const auto measure = static_cast<Measure>(row.measure);
  const bool is_angle = measure >= Measure::angle && measure <= Measure::true_motion_range;
  const std::string angle = is_angle ? errors.quantities[row.quantity] : "";
  if (is_angle && std::ranges::find(angles_, angle) == angles_.end()) angles_.push_back(angle);
  others_[{angle, row.method, measure}].add(row, cluster);
}

const MeasureSums& ConditionErrors::other(const std::string& angle, std::size_t method,
                                          Measure measure) const {
  static const MeasureSums kNone;
  const auto found = others_.find({angle, method, measure});
  return found == others_.end() ? kNone : found->second;
}

void ConditionErrors::add_pair(const MethodPair& pair, const PairRow& row, std::size_t cluster) {
  const auto add = [&](std::size_t first, std::size_t second, double first_m, double second_m) {
    PairSums& sums = pairs_[place(axes_.group_of(row), first, second, row.alignment)];
    sums.n += row.n;
    sums.first_m.add(cluster, first_m, row.n);
    sums.difference_m.add(cluster, first_m - second_m, row.n);
    sums.second_m.add(cluster, second_m, row.n);
  };
  add(pair.first, pair.second, row.first_m, row.second_m);
  add(pair.second, pair.first, row.second_m, row.first_m);
}

Estimate ConditionErrors::mean_m(std::span<const std::size_t> groups, std::size_t method,
                                 std::size_t alignment) const {
  Contrast mean;
  for (const std::size_t g : groups)
    mean.value.push_back(cell(g, method, alignment).distance.sum.ratio(cluster_count_, weight_of(groups)));
  return solve_contrast(mean);
}

MethodDifference ConditionErrors::difference(std::span<const std::size_t> groups, std::size_t first,
                                             std::size_t second, std::size_t alignment) const {
  MethodDifference difference;
  Contrast m, share;
  for (const std::size_t g : groups) {
    const PairSums& sums = pair(g, first, second, alignment);
    difference.n += sums.n;
    m.value.push_back(sums.difference_m.ratio(cluster_count_, weight_of(groups)));
    share.base.push_back(sums.second_m.ratio(cluster_count_, weight_of(groups)));
  }
  share.value = m.value;
  difference.m = solve_contrast(m);
  difference.share = solve_contrast(share);
  return difference;
}

StudyErrors::StudyErrors(std::span<const TakeTable> takes, const std::vector<std::string>& joints,
                         const ResultsSummary& names)
    : takes_(takes),
      joints_(joints),
      names_(names),
      axes_(joints, names.methods.size(), names.alignments.size()) {}

ConditionErrors StudyErrors::in(const std::string& condition, Subset subset) const {
  for (const TakeTable& take : takes_)
    if (occluded_condition(take.activity) == condition)
      return {takes_, take.activity, Subset::occluded, axes_};
  return {takes_, condition, subset, axes_};
}

}  // namespace trilat
