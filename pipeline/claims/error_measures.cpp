// SPDX-License-Identifier: MIT
#include "pipeline/claims/error_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

constexpr std::string_view kBestOf = "best of ";

// The joint groups of which the paper prints errors in a condition.
std::vector<std::string> printed_groups(const std::string& condition) {
  for (const PrintedTable2::Row& row : printed_table2().rows)
    if (condition == row.condition || condition == occluded_condition(row.condition)) return row.groups;
  std::vector<std::string> groups;
  for (const PrintedTable3::Row& row : printed_table3().rows)
    if (row.group != kAverageGroup) groups.push_back(row.group);
  return groups;
}

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

}  // namespace

const ConditionErrors& ErrorMeasures::in(const std::string& condition, Subset subset) const {
  auto& kept = conditions_[{condition, subset}];
  if (!kept) kept = std::make_unique<ConditionErrors>(errors_.in(condition, subset));
  return *kept;
}

std::vector<std::size_t> ErrorMeasures::methods_of(const std::string& name) const {
  if (name.starts_with(kBestOf)) return methods_of(name.substr(kBestOf.size()));
  const ResultsSummary& names = errors_.names();
  std::vector<std::size_t> methods;
  const auto add = [&](const std::string& method) {
    const auto found = std::ranges::find(names.methods, method);
    if (found != names.methods.end())
      methods.push_back(static_cast<std::size_t>(found - names.methods.begin()));
  };
  const auto family = std::ranges::find(names.families, name, &MethodFamily::name);
  if (family != names.families.end())
    std::ranges::for_each(family->methods, add);
  else
    add(name);
  return methods;
}

// Empty where one of the paper's groups is missing; of occluded samples, those that there are.
std::vector<std::size_t> ErrorMeasures::groups_of(const ErrorPlace& place) const {
  const ConditionErrors& errors = in(place.condition);
  const std::vector<std::string> wanted =
      place.group.empty() ? printed_groups(place.condition) : std::vector{place.group};
  std::vector<std::size_t> groups;
  for (const std::size_t g : errors.groups())
    if (std::ranges::find(wanted, errors_.axes().groups[g]) != wanted.end()) groups.push_back(g);
  const bool may_lack = place.condition.find(", occluded") != std::string::npos;
  return groups.size() == wanted.size() || may_lack ? groups : std::vector<std::size_t>{};
}

std::string ErrorMeasures::lacking_joints(const std::string& condition) const {
  return fmt::format("a study of {} with the joints of {}", condition,
                     fmt::join(printed_groups(condition), ", "));
}

std::string ErrorMeasures::silence_of(const std::string& name) const {
  return fmt::format("{} answers nothing on the rig of {}", name, errors_.names().campaign);
}

Measurement ErrorMeasures::difference(const std::string& of_name, const std::string& against_name,
                                      const ErrorPlace& place) const {
  const std::vector<std::size_t> of = methods_of(of_name), against = methods_of(against_name);
  const ConditionErrors& errors = in(place.condition);
  const auto answers = [&](const std::vector<std::size_t>& methods) {
    return std::ranges::any_of(errors.groups(), [&](std::size_t g) {
      return std::ranges::any_of(methods, [&](std::size_t m) { return errors.cell(g, m, 0).answered > 0; });
    });
  };
  if (of.empty()) return lacking(fmt::format("a study with {}", of_name));
  if (against.empty()) return lacking(fmt::format("a study with {}", against_name));
  if (!errors.groups().empty() && !answers(of)) return lacking(silence_of(of_name));
  if (!errors.groups().empty() && !answers(against)) return lacking(silence_of(against_name));
  const std::vector<std::size_t> groups = groups_of(place);
  if (groups.empty()) return lacking(lacking_joints(place.condition));
  const std::vector<std::size_t> via = against.size() == 1 ? against : methods_of(kVia);
  if (via.size() != 1) return lacking(fmt::format("the method {}", kVia));
  const bool is_best = of_name.starts_with(kBestOf);
  const std::vector<std::size_t> best =
      is_best ? best_on_others(errors, groups, of, via.front()) : std::vector<std::size_t>{};
  if (is_best && best.empty()) return lacking("more than one participant");
  const double weight = 1.0 / static_cast<double>(groups.size());
  const std::size_t clusters = errors.cluster_count();
  Contrast contrast;
  double n = 0.0;
  for (const std::size_t g : groups) {
    const PairOf pair = pair_of(errors, g, of, via.front(), best);
    if (pair.n == 0.0)
      return lacking(fmt::format("{} and {} never answer the same sample", of_name, against_name));
    n += pair.n;
    contrast.value.push_back(pair.difference_m.ratio(clusters, weight));
    contrast.base.push_back(pair.second_m.ratio(clusters, weight));
    if (against.size() == 1) continue;
    const PairOf other = pair_of(errors, g, against, via.front(), {});
    contrast.value.push_back(other.difference_m.ratio(clusters, -weight));
    contrast.base.push_back(other.difference_m.ratio(clusters, weight));
  }
  return {.what = fmt::format("{} against {}{}", of_name, against_name,
                              place.group.empty() ? "" : ", " + place.group),
          .unit = "%",
          .number = solve_contrast(contrast),
          .over = errors.clusters(),
          .compared = n / asked_of(errors, groups, of) * (is_best ? static_cast<double>(of.size()) : 1.0)};
}

Measurement ErrorMeasures::places(const std::string& method, const ErrorPlace& place,
                                  const ErrorPlace& other) const {
  const std::vector<std::size_t> methods = methods_of(method);
  if (methods.size() != 1) return lacking(fmt::format("a study with {}", method));
  Contrast contrast;
  std::array<const ConditionErrors*, 2> errors{};
  for (const std::size_t side : {0u, 1u}) {
    const ErrorPlace& where = side == 0 ? place : other;
    errors[side] = &in(where.condition);
    const std::vector<std::size_t> groups = groups_of(where);
    if (groups.empty()) return lacking(lacking_joints(where.condition));
    const double weight = 1.0 / static_cast<double>(groups.size());
    for (const std::size_t g : groups) {
      const ClusterSums& sums = errors[side]->cell(g, methods.front(), 0).distance.sum;
      contrast.value.push_back(sums.ratio(errors[side]->cluster_count(), side == 0 ? weight : -weight));
      if (side == 1) contrast.base.push_back(sums.ratio(errors[side]->cluster_count(), weight));
    }
  }
  if (errors[0]->cluster_count() != errors[1]->cluster_count()) return lacking("more than one take");
  const auto name = [&](const ErrorPlace& p) { return p.group.empty() ? p.condition : p.group; };
  const Estimate estimate = solve_contrast(contrast);
  if (!std::isfinite(estimate.value)) return lacking(silence_of(method));
  return {.what = fmt::format("{}: {} against {}", method, name(place), name(other)),
          .unit = "%",
          .number = estimate,
          .over = errors[0]->clusters()};
}

namespace {

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

}  // namespace

std::vector<ErrorMeasures::Movement> ErrorMeasures::movement(const std::vector<std::size_t>& groups) const {
  const ConditionErrors& errors = in("walking");
  std::vector<Movement> all(groups.size());
  ClusterNumbers clusters(errors);
  for (const TakeTable* take : errors.takes())
    for (const MovementRow& row : take->movement) {
      const auto g = std::ranges::find(groups, errors_.axes().group_of(row)) - groups.begin();
      if (g == std::ssize(groups)) continue;
      Movement& sums = all[static_cast<std::size_t>(g)];
      const std::size_t cluster = clusters.of(*take, row.block);
      sums.abrupt_m.add(cluster, row.abrupt_m, row.abrupt);
      sums.calm_m.add(cluster, row.calm_m, row.calm);
      sums.speed_m_s += row.speed_m_s;
      sums.speeds += row.speeds;
    }
  return all;
}

Measurement ErrorMeasures::abrupt() const {
  const std::vector<std::size_t> groups = groups_of({});
  if (groups.empty()) return lacking(lacking_joints("walking"));
  const std::size_t clusters = in("walking").cluster_count();
  const double weight = 1.0 / static_cast<double>(groups.size());
  Contrast contrast;
  for (const Movement& one : movement(groups)) {
    contrast.base.push_back(one.calm_m.ratio(clusters, weight));
    contrast.value.push_back(one.abrupt_m.ratio(clusters, weight));
    contrast.value.push_back(one.calm_m.ratio(clusters, -weight));
  }
  const Estimate estimate = solve_contrast(contrast);
  if (!std::isfinite(estimate.value)) return lacking("a study with nonlinear");
  return {.what = "nonlinear: the half of each joint's samples with the larger acceleration",
          .unit = "%",
          .number = estimate,
          .over = in("walking").clusters()};
}

Measurement ErrorMeasures::clock_cost(const std::string& method, double clock_s) const {
  const std::vector<std::size_t> methods = methods_of(method), groups = groups_of({});
  if (methods.size() != 1) return lacking(fmt::format("a study with {}", method));
  if (groups.empty()) return lacking(lacking_joints("walking"));
  const std::vector<Movement> all = movement(groups);
  const auto fastest = std::ranges::max_element(all, {}, &Movement::mean_speed_m_s);
  const double most_m_s = fastest->mean_speed_m_s();
  const std::size_t group = groups[static_cast<std::size_t>(fastest - all.begin())];
  const ConditionErrors& errors = in("walking");
  const WeightedRatio error =
      errors.cell(group, methods.front(), 0).distance.sum.ratio(errors.cluster_count());
  WeightedRatio way = error;
  for (std::size_t c = 0; c < way.numerator.size(); ++c)
    way.numerator[c] = clock_s * most_m_s * way.denominator[c];
  return {.what = fmt::format("{:g} ms at {:.2f} m/s against the error of {}, {}", 1e3 * clock_s, most_m_s,
                              method, errors_.axes().groups[group]),
          .unit = "%",
          .number = solve_contrast({{way}, {error}}),
          .over = errors.clusters()};
}

ErrorMeasures::WristHeight ErrorMeasures::wrist_height_of(const std::string& method) const {
  const std::vector<std::size_t> methods = methods_of(method);
  const auto joint = std::ranges::find(errors_.joints(), "wrist_right") - errors_.joints().begin();
  if (methods.size() != 1) return {.missing = fmt::format("a study with {}", method)};
  if (joint == std::ssize(errors_.joints())) return {.missing = "a study of walking with the right wrist"};
  const auto is_of = [&](const auto& row) {
    return errors_.axes().joint_of(row) == static_cast<std::size_t>(joint) && row.method == methods.front() &&
           row.alignment == 0 && row.subset == static_cast<std::uint32_t>(Subset::all) && row.is(Measure::y);
  };
  const ConditionErrors& errors = in("walking");
  const bool by_participant = errors.clusters() == std::string("participants");
  std::vector<std::string> names;
  WristHeight sums;
  for (const TakeTable* take : errors.takes()) {
    const std::string& name = by_participant ? take->participant : take->id;
    auto found = std::ranges::find(names, name);
    if (found == names.end()) found = names.insert(names.end(), name);
    const auto c = static_cast<std::size_t>(found - names.begin());
    double largest_m = 0.0, sum_m = 0.0, answered = 0.0;
    for (const ErrorSums& row : take->errors.sums) {
      if (!is_of(row)) continue;
      largest_m = std::max(largest_m, row.largest);
      sum_m += row.sum_abs;
      answered += row.n;
    }
    if (answered == 0.0) continue;
    sums.largest_m.add(c, largest_m, 1.0);
    sums.height_m.add(c, sum_m, answered);
  }
  sums.clusters = names.size();
  if (sums.largest_m.n.empty()) sums.missing = silence_of(method);
  return sums;
}

Measurement ErrorMeasures::of_wrist(const std::string& method, const char* what, const WristHeight& errors,
                                    const ClusterSums& sums) const {
  if (!errors.missing.empty()) return lacking(errors.missing);
  const bool by_participant = in("walking").clusters() == std::string("participants");
  return {.what = fmt::format("{}: {} of the right wrist's height", method, what),
          .unit = "cm",
          .number = solve_contrast({{sums.ratio(errors.clusters)}, {}}),
          .over = by_participant ? "participants" : "takes"};
}

Measurement ErrorMeasures::largest_wrist_height(const std::string& method) const {
  const WristHeight errors = wrist_height_of(method);
  return of_wrist(method, "largest error in a take", errors, errors.largest_m);
}

Measurement ErrorMeasures::wrist_height(const std::string& method) const {
  const WristHeight errors = wrist_height_of(method);
  return of_wrist(method, "mean error", errors, errors.height_m);
}

}  // namespace trilat
