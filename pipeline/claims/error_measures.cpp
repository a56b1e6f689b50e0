// SPDX-License-Identifier: MIT
#include "pipeline/claims/error_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "datasets/paper/printed_tables.h"
#include "pipeline/claims/paper_claims.h"

namespace trilat {
namespace {

// Sums of some methods against one, on the samples that both answer.
struct PairOf {
  ClusterSums difference_m, second_m;
  double n = 0.0;
};

// By cluster, which of the methods does best on all the others, against `against`; empty without others.
std::vector<std::size_t> best_on_others(const ConditionErrors& errors, const std::vector<std::size_t>& groups,
                                        const std::vector<std::size_t>& methods, std::size_t against) {
  std::vector<std::size_t> best;
  const auto sum_without = [](const std::vector<double>& sums, std::size_t without) {
    double sum = 0.0;
    for (std::size_t c = 0; c < sums.size(); ++c) sum += c == without ? 0.0 : sums[c];
    return sum;
  };
  for (std::size_t c = 0; c < errors.cluster_count(); ++c) {
    double least = HUGE_VAL;
    std::size_t chosen = methods.front();
    for (const std::size_t m : methods) {
      double ratio = 0.0;  // on the same samples, so that few answers win nothing
      for (const std::size_t g : groups) {
        const PairSums& pair = errors.pair(g, m, against, 0);
        ratio += sum_without(pair.first_m.sum, c) / sum_without(pair.second_m.sum, c);
      }
      if (!(ratio < least)) continue;
      least = ratio;
      chosen = m;
    }
    if (!std::isfinite(least)) return {};
    best.push_back(chosen);
  }
  return best;
}

// `best`: by cluster the only method that counts there; empty: all do.
PairOf pair_of(const ConditionErrors& errors, std::size_t group, const std::vector<std::size_t>& methods,
               std::size_t against, const std::vector<std::size_t>& best) {
  PairOf sums;
  for (const std::size_t m : methods) {
    const PairSums& pair = errors.pair(group, m, against, 0);
    for (std::size_t c = 0; c < pair.difference_m.n.size(); ++c) {
      if (!best.empty() && best[c] != m) continue;
      sums.n += pair.difference_m.n[c];
      sums.difference_m.add(c, pair.difference_m.sum[c], pair.difference_m.n[c]);
      sums.second_m.add(c, pair.second_m.sum[c], pair.second_m.n[c]);
    }
  }
  return sums;
}

double asked_of(const ConditionErrors& errors, const std::vector<std::size_t>& groups,
                const std::vector<std::size_t>& methods) {
  double asked = 0.0;
  for (const std::size_t g : groups)
    for (const std::size_t m : methods) asked += static_cast<double>(errors.cell(g, m, 0).asked);
  return asked;
}

// A number that was found.
struct ClaimedError {
  Estimate estimate;
  double n = 0.0;          // samples behind it
  double compared = kNaN;  // share of the samples that both methods answer
};
using Claimed = std::optional<ClaimedError>;

// Numbers the clusters that the intervals of a condition are made of.
class ClusterNumbers {
 public:
  explicit ClusterNumbers(const ConditionErrors& errors) : kind_(errors.clusters()) {}
  std::size_t of(const TakeTable& take, std::uint32_t block) {
    const std::string name = kind_ == "participants" ? take.participant
                             : kind_ == "takes"      ? take.id
                                                     : std::to_string(block);
    return numbers_.try_emplace(name, numbers_.size()).first->second;
  }

 private:
  std::string kind_;
  std::map<std::string, std::size_t> numbers_;
};

// How the truth of a joint group moves, and the errors of nonlinear in either half of its samples.
struct GroupMovement {
  ClusterSums abrupt_m, calm_m;
  double speed_m_s = 0.0, speeds = 0.0;
  double mean_speed_m_s() const { return speeds > 0.0 ? speed_m_s / speeds : 0.0; }
};

class ClaimedErrors {
 public:
  explicit ClaimedErrors(const StudyErrors& errors) : errors_(errors) {}

  // Nothing where the study lacks methods, joints or samples for it.
  Claimed find(const NumberKey& key) const {
    using Measured = Claimed (ClaimedErrors::*)(const NumberKey&) const;
    constexpr std::array<std::pair<const char*, Measured>, 5> kMeasured{
        {{"distance", &ClaimedErrors::difference},
         {"place", &ClaimedErrors::places},
         {"abrupt", &ClaimedErrors::abrupt},
         {"clock_cost", &ClaimedErrors::clock_cost},
         {"y", &ClaimedErrors::wrist_height}}};
    for (const auto& [measure, find] : kMeasured)
      if (key.measure == measure) return (this->*find)(key);
    return std::nullopt;
  }

 private:
  Claimed difference(const NumberKey& key) const;
  Claimed places(const NumberKey& key) const;
  Claimed abrupt(const NumberKey& key) const;
  Claimed clock_cost(const NumberKey& key) const;
  Claimed wrist_height(const NumberKey& key) const;

  const ConditionErrors& in(const std::string& condition) const {
    auto& kept = conditions_[condition];
    if (!kept) kept = std::make_unique<ConditionErrors>(errors_.in(condition));
    return *kept;
  }
  std::vector<std::size_t> methods_of(const std::string& name) const;
  std::vector<std::size_t> groups_of(const std::string& condition, const std::string& group) const;
  std::vector<GroupMovement> movement(const NumberKey& key, const std::vector<std::size_t>& groups) const;

  const StudyErrors& errors_;
  mutable std::map<std::string, std::unique_ptr<ConditionErrors>> conditions_;
};

std::vector<std::size_t> ClaimedErrors::methods_of(const std::string& name) const {
  if (name.starts_with(kBestOf)) return methods_of(name.substr(kBestOf.size()));
  const ResultsSummary& names = errors_.names();
  std::vector<std::size_t> methods;
  const auto add = [&](const std::string& method) {
    const auto found = std::ranges::find(names.methods, method);
    if (found != names.methods.end())
      methods.push_back(static_cast<std::size_t>(found - names.methods.begin()));
  };
  const auto family = std::ranges::find(names.families, name, &SensorSetGroup::name);
  if (family != names.families.end())
    std::ranges::for_each(family->methods, add);
  else
    add(name);
  return methods;
}

// Empty where one of the paper's groups is missing; of occluded samples, those that there are.
std::vector<std::size_t> ClaimedErrors::groups_of(const std::string& condition,
                                                  const std::string& group) const {
  const std::vector<std::string> wanted =
      group == kPaperJoints ? printed_groups(condition) : std::vector{group};
  std::vector<std::size_t> groups;
  for (const std::size_t g : in(condition).groups())
    if (std::ranges::find(wanted, errors_.axes().groups[g]) != wanted.end()) groups.push_back(g);
  const bool may_lack = condition.find(", occluded") != std::string::npos;
  return groups.size() == wanted.size() || may_lack ? groups : std::vector<std::size_t>{};
}

Claimed ClaimedErrors::difference(const NumberKey& key) const {
  const ConditionErrors& errors = in(key.condition);
  const std::vector<std::size_t> of = methods_of(key.method), against = methods_of(key.against),
                                 groups = groups_of(key.condition, key.group);
  const std::vector<std::size_t> via = against.size() == 1 ? against : methods_of(kVia);
  if (of.empty() || against.empty() || groups.empty() || via.size() != 1) return std::nullopt;
  const bool is_best = key.method.starts_with(kBestOf);
  const std::vector<std::size_t> best =
      is_best ? best_on_others(errors, groups, of, via.front()) : std::vector<std::size_t>{};
  if (is_best && best.empty()) return std::nullopt;
  const double weight = 1.0 / static_cast<double>(groups.size());
  const std::size_t clusters = errors.cluster_count();
  Contrast contrast;
  double n = 0.0;
  for (const std::size_t g : groups) {
    const PairOf pair = pair_of(errors, g, of, via.front(), best);
    if (pair.n == 0.0) return std::nullopt;
    n += pair.n;
    contrast.value.push_back(pair.difference_m.ratio(clusters, weight));
    contrast.base.push_back(pair.second_m.ratio(clusters, weight));
    if (against.size() == 1) continue;
    const PairOf other = pair_of(errors, g, against, via.front(), {});
    contrast.value.push_back(other.difference_m.ratio(clusters, -weight));
    contrast.base.push_back(other.difference_m.ratio(clusters, weight));
  }
  const double methods = is_best ? static_cast<double>(of.size()) : 1.0;
  return ClaimedError{solve_contrast(contrast), n, n / asked_of(errors, groups, of) * methods};
}

Claimed ClaimedErrors::places(const NumberKey& key) const {
  const std::vector<std::size_t> methods = methods_of(key.method);
  if (methods.size() != 1) return std::nullopt;
  const bool are_groups = key.group != kPaperJoints;
  Contrast contrast;
  double n = 0.0;
  std::array<const ConditionErrors*, 2> errors{};
  for (const std::size_t side : {0u, 1u}) {
    const std::string& condition = side == 1 && !are_groups ? key.against : key.condition;
    errors[side] = &in(condition);
    const std::vector<std::size_t> groups =
        groups_of(condition, side == 1 && are_groups ? key.against : key.group);
    if (groups.empty()) return std::nullopt;
    const double weight = 1.0 / static_cast<double>(groups.size());
    for (const std::size_t g : groups) {
      const MeasureSums& distance = errors[side]->cell(g, methods.front(), 0).distance;
      if (side == 0) n += static_cast<double>(distance.n);
      contrast.value.push_back(
          distance.sum.ratio(errors[side]->cluster_count(), side == 0 ? weight : -weight));
      if (side == 1) contrast.base.push_back(distance.sum.ratio(errors[side]->cluster_count(), weight));
    }
  }
  if (errors[0]->cluster_count() != errors[1]->cluster_count()) return std::nullopt;
  return ClaimedError{solve_contrast(contrast), n};
}

std::vector<GroupMovement> ClaimedErrors::movement(const NumberKey& key,
                                                   const std::vector<std::size_t>& groups) const {
  const ConditionErrors& errors = in(key.condition);
  std::vector<GroupMovement> all(groups.size());
  ClusterNumbers clusters(errors);
  for (const TakeTable* take : errors.takes())
    for (const MovementRow& row : take->movement) {
      const auto g = std::ranges::find(groups, errors_.axes().group_of(row)) - groups.begin();
      if (g == std::ssize(groups)) continue;
      GroupMovement& sums = all[static_cast<std::size_t>(g)];
      const std::size_t cluster = clusters.of(*take, row.block);
      sums.abrupt_m.add(cluster, row.abrupt_m, row.abrupt);
      sums.calm_m.add(cluster, row.calm_m, row.calm);
      sums.speed_m_s += row.speed_m_s;
      sums.speeds += row.speeds;
    }
  return all;
}

Claimed ClaimedErrors::abrupt(const NumberKey& key) const {
  const std::vector<std::size_t> groups = groups_of(key.condition, key.group);
  if (groups.empty()) return std::nullopt;
  const std::size_t clusters = in(key.condition).cluster_count();
  const double weight = 1.0 / static_cast<double>(groups.size());
  Contrast contrast;
  double n = 0.0;
  for (const GroupMovement& one : movement(key, groups)) {
    contrast.base.push_back(one.calm_m.ratio(clusters, weight));
    contrast.value.push_back(one.abrupt_m.ratio(clusters, weight));
    contrast.value.push_back(one.calm_m.ratio(clusters, -weight));
    n = std::accumulate(one.abrupt_m.n.begin(), one.abrupt_m.n.end(), n);
  }
  return ClaimedError{solve_contrast(contrast), n};
}

Claimed ClaimedErrors::clock_cost(const NumberKey& key) const {
  constexpr double kClock_s = 0.005;
  const std::vector<std::size_t> methods = methods_of(key.method),
                                 groups = groups_of(key.condition, key.group);
  if (methods.size() != 1 || groups.empty()) return std::nullopt;
  const std::vector<GroupMovement> all = movement(key, groups);
  const auto fastest = std::ranges::max_element(all, {}, &GroupMovement::mean_speed_m_s);
  const ConditionErrors& errors = in(key.condition);
  const MeasureSums& distance =
      errors.cell(groups[static_cast<std::size_t>(fastest - all.begin())], methods.front(), 0).distance;
  const WeightedRatio error = distance.sum.ratio(errors.cluster_count());
  WeightedRatio way = error;
  for (std::size_t c = 0; c < way.numerator.size(); ++c)
    way.numerator[c] = kClock_s * fastest->mean_speed_m_s() * way.denominator[c];
  return ClaimedError{solve_contrast({{way}, {error}}), static_cast<double>(distance.n)};
}

Claimed ClaimedErrors::wrist_height(const NumberKey& key) const {
  const std::vector<std::size_t> methods = methods_of(key.method);
  const auto joint = std::ranges::find(errors_.joints(), key.group) - errors_.joints().begin();
  if (methods.size() != 1 || joint == std::ssize(errors_.joints())) return std::nullopt;
  const auto is_of = [&](const auto& row) {
    return errors_.axes().joint_of(row) == static_cast<std::size_t>(joint) && row.method == methods.front() &&
           row.alignment == 0 && row.subset == static_cast<std::uint32_t>(Subset::all) && row.is(Measure::y);
  };
  const ConditionErrors& errors = in(key.condition);
  const bool by_participant = errors.clusters() == std::string("participants");
  std::map<std::string, std::size_t> clusters;  // people, or takes where these are too few
  ClusterSums largest_m, height_m;
  double n = 0.0;
  for (const TakeTable* take : errors.takes()) {
    const std::size_t cluster =
        clusters.try_emplace(by_participant ? take->participant : take->id, clusters.size()).first->second;
    double most_m = 0.0, sum_m = 0.0, answered = 0.0;
    for (const ErrorSums& row : take->errors.sums) {
      if (!is_of(row)) continue;
      most_m = std::max(most_m, row.largest);
      sum_m += row.sum_abs;
      answered += row.n;
    }
    if (answered == 0.0) continue;
    n += answered;
    largest_m.add(cluster, most_m, 1.0);
    height_m.add(cluster, sum_m, answered);
  }
  if (n == 0.0) return std::nullopt;
  const ClusterSums& sums = key.statistic == "mean_largest" ? largest_m : height_m;
  return ClaimedError{solve_contrast({{sums.ratio(clusters.size())}, {}}), n};
}

}  // namespace

std::vector<std::string> printed_groups(const std::string& condition) {
  for (const PrintedTable2::Row& row : printed_table2().rows)
    if (condition == row.condition || condition == occluded_condition(row.condition)) return row.groups;
  std::vector<std::string> groups;
  for (const PrintedTable3::Row& row : printed_table3().rows)
    if (row.group != kAverageGroup) groups.push_back(row.group);
  return groups;
}

Numbers claimed_numbers(const StudyErrors& errors) {
  Numbers numbers;
  if (errors.names().left_out()) return numbers;  // differences from a sensor are no errors
  const ClaimedErrors claimed(errors);
  for (NumberKey key : claimed_keys(errors.names().paper)) {
    key.alignment = errors.names().alignments.front();
    if (numbers.find(key)) continue;
    const Claimed found = claimed.find(key);
    if (!found || !std::isfinite(found->estimate.value)) continue;
    const Estimate& e = found->estimate;
    const auto n = static_cast<std::uint64_t>(found->n);
    numbers.add({key, e.value, e.low(), e.high(), n, e.clusters, e.p_value()});
    if (std::isfinite(found->compared))
      numbers.add({key.with({.statistic = "share_compared"}), found->compared, kNaN, kNaN, n});
  }
  return numbers;
}

}  // namespace trilat
