// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/errors/participant_errors.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include "datasets/results/results_file.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

// In the order of their names: the same people may come in another order of takes.
std::vector<std::string> participants_of(const ResultsSummary& s) {
  std::set<std::string> names;
  for (const TakeJointRow& row : s.by_take) names.insert(row.participant);
  return {names.begin(), names.end()};
}

constexpr std::string_view kBestOf = "best of ";

// A mean over nothing is NaN and adds nothing.
void add(double& sum, std::uint64_t n, double mean) {
  if (n > 0) sum += static_cast<double>(n) * mean;
}

template <class Of>
WeightedRatio ratio_of(const auto& participants, double weight, const Of& numerator_and_denominator) {
  WeightedRatio ratio;
  ratio.weight = weight;
  for (const auto& sums : participants) {
    const auto [numerator, denominator] = numerator_and_denominator(sums);
    ratio.numerator.push_back(numerator);
    ratio.denominator.push_back(denominator);
  }
  return ratio;
}

}  // namespace

void ParticipantErrors::Sums::Paired::add(const PairedErrors& paired) {
  n += static_cast<double>(paired.n);
  trilat::add(method_m, paired.n, paired.mae_m);
  trilat::add(reference_m, paired.n, paired.reference_mae_m);
}

ParticipantErrors::ParticipantErrors(const ResultsSummary& summary) : summary_(summary) {
  participants_ = participants_of(summary);
  for (const TakeJointRow& row : summary.by_take) {
    ByParticipant& of = sums_[row.condition][row.group][row.method];
    of.resize(participants_.size());
    Sums& sums = of[static_cast<std::size_t>(std::ranges::find(participants_, row.participant) -
                                             participants_.begin())];
    sums.answered += static_cast<double>(row.answered);
    add(sums.error_m, row.answered, row.mae_m);
    const SpeedErrors& speed = row.by_speed;
    sums.slow += static_cast<double>(speed.slow);
    sums.fast += static_cast<double>(speed.fast);
    add(sums.slow_m, speed.slow, speed.slow_mae_m);
    add(sums.fast_m, speed.fast, speed.fast_mae_m);
    sums.both.add(row.both);
    sums.complete.add(row.complete);
  }
}

std::vector<std::string> ParticipantErrors::groups_of(const std::string& condition) const {
  std::vector<std::string> groups;
  const auto found = sums_.find(condition);
  for (const std::string& group : summary_.groups)
    if (found != sums_.end() && found->second.contains(group)) groups.push_back(group);
  return groups;
}

std::vector<std::string> ParticipantErrors::methods_of(const std::string& name) const {
  if (name.starts_with(kBestOf)) return methods_of(name.substr(kBestOf.size()));
  for (const MethodFamily& family : summary_.families)
    if (family.name == name) return family.methods;
  const bool known = std::ranges::find(summary_.methods, name) != summary_.methods.end();
  return known ? std::vector{name} : std::vector<std::string>{};
}

std::vector<std::string> ParticipantErrors::best_on_others(const std::vector<std::string>& methods,
                                                           const std::string& condition) const {
  std::vector<std::string> best;
  const std::vector<std::string> groups = groups_of(condition);
  for (std::size_t p = 0; participants_.size() > 1 && p < participants_.size(); ++p) {
    double least = kNaN;
    for (const std::string& method : methods) {
      double ratio = 0.0;  // to the reference on the same samples, so that few answers win nothing
      for (const std::string& group : groups) {
        double method_m = 0.0, reference_m = 0.0;
        const ByParticipant all = sums_of(method, condition, group);
        for (std::size_t other = 0; other < all.size(); ++other) {
          if (other == p) continue;
          method_m += all[other].both.method_m;
          reference_m += all[other].both.reference_m;
        }
        ratio += method_m / reference_m;
      }
      if (ratio >= least || std::isnan(ratio)) continue;
      if (best.size() <= p) best.emplace_back();
      best.back() = method;
      least = ratio;
    }
    if (best.size() <= p) return {};
  }
  return best;
}

ParticipantErrors::ByParticipant ParticipantErrors::sums_of(const std::string& name,
                                                            const std::string& condition,
                                                            const std::string& group) const {
  ByParticipant sums(participants_.size());
  const std::vector<std::string> methods = methods_of(name);
  const bool is_best = name.starts_with(kBestOf);
  const std::vector<std::string> best =
      is_best ? best_on_others(methods, condition) : std::vector<std::string>{};
  if (is_best && best.empty()) return sums;
  for (const std::string& method : methods) {
    const auto in_condition = sums_.find(condition);
    if (in_condition == sums_.end()) break;
    const auto in_group = in_condition->second.find(group);
    if (in_group == in_condition->second.end()) break;
    const auto of = in_group->second.find(method);
    if (of == in_group->second.end()) continue;
    for (std::size_t p = 0; p < sums.size(); ++p) {
      if (is_best && best[p] != method) continue;
      const Sums& more = of->second[p];
      sums[p].answered += more.answered;
      sums[p].error_m += more.error_m;
      sums[p].slow += more.slow;
      sums[p].slow_m += more.slow_m;
      sums[p].fast += more.fast;
      sums[p].fast_m += more.fast_m;
      for (auto [to, from] :
           {std::pair{&sums[p].both, &more.both}, std::pair{&sums[p].complete, &more.complete}}) {
        to->n += from->n;
        to->method_m += from->method_m;
        to->reference_m += from->reference_m;
      }
    }
  }
  return sums;
}

WeightedRatio ParticipantErrors::error_m(const std::string& name, const std::string& condition,
                                         const std::string& group) const {
  return ratio_of(sums_of(name, condition, group), 1.0, [](const Sums& s) {
    return std::pair{s.error_m, s.answered};
  });
}

WeightedRatio ParticipantErrors::speed_error_m(const std::string& name, const std::string& condition,
                                               const std::string& group, bool fast) const {
  return ratio_of(sums_of(name, condition, group), 1.0, [fast](const Sums& s) {
    return fast ? std::pair{s.fast_m, s.fast} : std::pair{s.slow_m, s.slow};
  });
}

WeightedRatio ParticipantErrors::complete_error_m(const std::string& name, const std::string& condition,
                                                  const std::string& group) const {
  return ratio_of(sums_of(name, condition, group), 1.0, [](const Sums& s) {
    return std::pair{s.complete.method_m, s.complete.n};
  });
}

Contrast ParticipantErrors::difference(const std::string& of, const std::string& against,
                                       const std::string& condition, const std::vector<std::string>& groups,
                                       ComparedSamples samples) const {
  const auto pick = [&](const Sums& s) { return samples == ComparedSamples::both ? s.both : s.complete; };
  const double weight = 1.0 / static_cast<double>(groups.size());
  const bool of_is_reference = of == summary_.reference, against_is_reference = against == summary_.reference;
  Contrast contrast;
  for (const std::string& group : groups) {
    if (of_is_reference || against_is_reference) {
      const ByParticipant sums = sums_of(of_is_reference ? against : of, condition, group);
      const double sign = of_is_reference ? -1.0 : 1.0;
      contrast.value.push_back(ratio_of(sums, sign * weight, [&](const Sums& s) {
        return std::pair{pick(s).method_m - pick(s).reference_m, pick(s).n};
      }));
      contrast.base.push_back(ratio_of(sums, weight, [&](const Sums& s) {
        return std::pair{of_is_reference ? pick(s).method_m : pick(s).reference_m, pick(s).n};
      }));
    } else if (samples == ComparedSamples::complete) {
      contrast.value.push_back(complete_error_m(of, condition, group));
      contrast.value.back().weight = weight;
      contrast.value.push_back(complete_error_m(against, condition, group));
      contrast.base.push_back(contrast.value.back());
      contrast.value.back().weight = -weight;
      contrast.base.back().weight = weight;
    }
  }
  return contrast;
}

namespace {

// The plain mean over the groups.
std::vector<WeightedRatio> mean_error(const ParticipantErrors& errors, const std::string& method,
                                      const std::string& condition, const std::vector<std::string>& groups,
                                      double sign) {
  std::vector<WeightedRatio> ratios;
  for (const std::string& group : groups) {
    ratios.push_back(errors.error_m(method, condition, group));
    ratios.back().weight = sign / static_cast<double>(groups.size());
  }
  return ratios;
}

// Of different participants: each side by itself, the other's clusters without samples.
void pad(std::vector<WeightedRatio>& ratios, std::size_t before, std::size_t behind) {
  for (WeightedRatio& ratio : ratios)
    for (auto* values : {&ratio.numerator, &ratio.denominator}) {
      values->insert(values->begin(), before, 0.0);
      values->insert(values->end(), behind, 0.0);
    }
}

}  // namespace

std::optional<ErrorChanges> changes_between(const ResultsSummary& before, const ResultsSummary& after) {
  if (before.alignments.front() != after.alignments.front() || before.truth != after.truth)
    return std::nullopt;
  const std::vector<std::string> then = participants_of(before), now = participants_of(after);
  ErrorChanges changes{"", "", then == now, std::min(then.size(), now.size()), {}};
  const ParticipantErrors errors_before(before), errors_after(after);
  const auto add = [&](const std::string& condition, const std::string& method,
                       const std::vector<std::string>& groups) {
    std::vector<WeightedRatio> value = mean_error(errors_after, method, condition, groups, 1.0),
                               minus = mean_error(errors_before, method, condition, groups, -1.0);
    ErrorChange row{condition, groups.size() > 1 ? kAverageGroup : groups.front(), method};
    row.after_m = solve_contrast({value, {}}).value;
    row.before_m = -solve_contrast({minus, {}}).value;
    if (!changes.paired) {
      pad(value, 0, then.size());
      pad(minus, now.size(), 0);
    }
    value.insert(value.end(), minus.begin(), minus.end());
    const ContrastEstimate difference = solve_contrast({std::move(value), {}});
    row.difference_m = difference.value;
    row.low_m = difference.low();
    row.high_m = difference.high();
    row.standard_error_m = difference.standard_error;
    row.clusters = difference.clusters;
    if (difference.clusters >= 2)
      row.chance = student_two_sided(difference.value / difference.standard_error, difference.clusters - 1);
    changes.rows.push_back(std::move(row));
  };
  for (const std::string& condition : after.conditions) {
    const std::vector<std::string> groups = errors_after.groups_of(condition);
    if (groups.empty() || errors_before.groups_of(condition) != groups) continue;
    for (const std::string& method : after.methods) {
      if (!errors_before.knows(method)) continue;
      if (groups.size() > 1) add(condition, method, groups);
      for (const std::string& group : groups) add(condition, method, {group});
    }
  }
  if (changes.rows.empty()) return std::nullopt;
  return changes;
}

std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results) {
  if (results.size() != 2) return std::nullopt;
  for (const auto& path : results)
    if (results_kind(path) != StudyKind::accuracy) return std::nullopt;
  const ResultsSummary after = read_summary(results[1]);
  std::optional<ErrorChanges> changes = changes_between(read_summary(results[0]), after);
  if (!changes) return changes;
  changes->before = results[0].string();
  changes->after = results[1].string();
  if (after.groups.size() > 1)  // one row a method is shown
    std::erase_if(changes->rows, [](const ErrorChange& row) { return row.group != kAverageGroup; });
  return changes;
}

}  // namespace trilat
