// SPDX-License-Identifier: MIT
#include "pipeline/errors/condition_errors.h"

#include <algorithm>
#include <optional>
#include <set>

#include "datasets/skeleton/skeleton.h"

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

void CellSums::add(const ErrorRow& row, std::size_t cluster) {
  asked += row.asked();
  answered += row.answered;
  iterations += row.iterations;
  for (std::size_t s = 0; s < kMostStatuses; ++s) statuses[s] += row.statuses[s];
  length_m2 += row.length_m2;
  largest_m = std::max(largest_m, row.largest_m);
  for (std::size_t axis = 0; axis < 3; ++axis) absolute_m[axis] += row.absolute_m[axis];
  length_m.add(cluster, row.length_m, row.answered);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    error_m[axis].add(cluster, row.error_m[axis], row.answered);
    error_m2[axis].add(cluster, row.error_m2[axis], row.answered);
  }
}

void CellSums::add(std::span<const BinRow> bins) {
  histogram.resize(kLastBin + 1);
  for (const BinRow& row : bins) histogram[row.bin] += row.n;
}

void CellSums::add_counts(const CellSums& more) {
  asked += more.asked;
  answered += more.answered;
  for (std::size_t s = 0; s < kMostStatuses; ++s) statuses[s] += more.statuses[s];
}

// The length that so many are shorter than.
double CellSums::length_at(std::uint64_t place) const {
  std::uint64_t before = 0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    if (place < before + histogram[bin]) {
      const auto of_bin = static_cast<std::uint32_t>(bin);
      const double low_m = bin_starts_at_m(of_bin);
      const double high_m = bin == kLastBin ? largest_m : bin_starts_at_m(of_bin + 1);
      const double share = (static_cast<double>(place - before) + 0.5) / static_cast<double>(histogram[bin]);
      return std::min(largest_m, low_m + (high_m - low_m) * share);
    }
    before += histogram[bin];
  }
  return largest_m;
}

double CellSums::quantile_m(double q) const {
  if (answered == 0) return kNoNumber;
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
      pairs_(cells_.size() * axes.methods),
      bodies_(2 * axes.methods) {
  for (const TakeTable& take : takes)
    if (take.activity == activity) takes_.push_back(&take);
  std::set<std::string> participants;
  for (const TakeTable* take : takes_) participants.insert(take->participant);
  const bool by_participant = participants.size() >= kFewestParticipants;
  const bool by_block = !by_participant && takes_.size() == 1;
  if (!by_participant) cluster_kind_ = by_block ? "blocks of time" : "takes";
  const std::vector<std::size_t> clusters = cluster_of(takes, by_participant);
  for (std::size_t t = 0; t < takes.size(); ++t) {
    if (!by_block) cluster_count_ = std::max(cluster_count_, clusters[t] + 1);
    if (takes[t].activity == activity) add(takes[t].errors, subset, clusters[t], by_block);
  }
  for (const CellSums& sums : cells_) cluster_count_ = std::max(cluster_count_, sums.length_m.n.size());
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
  return pairs_[place(group, first, second, alignment)];
}

void ConditionErrors::add(const ErrorTable& table, Subset subset, std::size_t cluster, bool by_block) {
  const auto cluster_of = [&](const auto& row) { return by_block ? row.block : cluster; };
  const auto cell_of = [&](const auto& row) -> CellSums& {
    return cells_[place(axes_.group_of(row), row.method, row.alignment)];
  };
  for (const ErrorRow& row : table.errors)
    if (is_of(row, subset)) cell_of(row).add(row, cluster_of(row));
  std::span<const BinRow> bins(table.bins);
  for (const HistogramRow& row : table.histograms) {
    if (is_of(row, subset)) cell_of(row).add(bins.first(row.bins));
    bins = bins.subspan(row.bins);
  }
  for (const PairRow& row : table.pairs)
    if (is_of(row, subset)) add_pair(row, cluster_of(row));
  for (const BodyRow& row : table.bodies) {
    if (row.method != row.with) continue;
    bodies_[2 * row.method].add(cluster_of(row), row.mpjpe_m, row.n);
    bodies_[2 * row.method + 1].add(cluster_of(row), row.pa_mpjpe_m, row.pa_n);
  }
}

void ConditionErrors::add_pair(const PairRow& row, std::size_t cluster) {
  const auto add = [&](std::size_t first, std::size_t second, double first_m, double second_m) {
    PairSums& sums = pairs_[place(axes_.group_of(row), first, second, row.alignment)];
    sums.n += row.n;
    sums.first_m.add(cluster, first_m, row.n);
    sums.difference_m.add(cluster, first_m - second_m, row.n);
    sums.second_m.add(cluster, second_m, row.n);
  };
  add(row.first, row.second, row.first_m, row.second_m);
  add(row.second, row.first, row.second_m, row.first_m);
}

ContrastEstimate ConditionErrors::mean_m(std::span<const std::size_t> groups, std::size_t method,
                                         std::size_t alignment) const {
  Contrast mean;
  for (const std::size_t g : groups)
    mean.value.push_back(cell(g, method, alignment).length_m.ratio(cluster_count_, weight_of(groups)));
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

ContrastEstimate ConditionErrors::mpjpe_m(std::size_t method) const {
  return solve_contrast({{bodies_[2 * method].ratio(cluster_count_)}, {}});
}
ContrastEstimate ConditionErrors::pa_mpjpe_m(std::size_t method) const {
  return solve_contrast({{bodies_[2 * method + 1].ratio(cluster_count_)}, {}});
}
std::uint64_t ConditionErrors::bodies(std::size_t method) const {
  double n = 0.0;
  for (const double more : bodies_[2 * method].n) n += more;
  return static_cast<std::uint64_t>(n);
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
