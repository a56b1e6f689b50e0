// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/statistics/error_changes.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "datasets/results/results_file.h"
#include "pipeline/accuracy/statistics/participant_errors.h"

namespace trilat {
namespace {

std::vector<std::string> participants_of(const ResultsSummary& s) {
  std::vector<std::string> names;
  for (const TakeJointRow& row : s.by_take)
    if (std::ranges::find(names, row.participant) == names.end()) names.push_back(row.participant);
  return names;
}

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

std::optional<ErrorChanges> changes_between(const std::vector<std::filesystem::path>& results) {
  if (results.size() != 2) return std::nullopt;
  for (const auto& path : results)
    if (results_kind(path) != StudyKind::accuracy) return std::nullopt;
  const ResultsSummary before = read_summary(results[0]), after = read_summary(results[1]);
  if (before.alignments.front() != after.alignments.front() || before.truth != after.truth)
    return std::nullopt;
  const std::vector<std::string> then = participants_of(before), now = participants_of(after);
  ErrorChanges changes{
      results[0].string(), results[1].string(), then == now, std::min(then.size(), now.size()), {}};
  const ParticipantErrors errors_before(before), errors_after(after);
  for (const std::string& condition : after.conditions) {
    const std::vector<std::string> groups = errors_after.groups_of(condition);
    if (groups.empty() || errors_before.groups_of(condition) != groups) continue;
    for (const std::string& method : after.methods) {
      if (!errors_before.knows(method)) continue;
      std::vector<WeightedRatio> value = mean_error(errors_after, method, condition, groups, 1.0),
                                 minus = mean_error(errors_before, method, condition, groups, -1.0);
      const double after_m = solve_contrast({value, {}}).value, before_m = -solve_contrast({minus, {}}).value;
      if (!changes.paired) {
        pad(value, 0, then.size());
        pad(minus, now.size(), 0);
      }
      value.insert(value.end(), minus.begin(), minus.end());
      const ContrastEstimate difference = solve_contrast({std::move(value), {}});
      changes.rows.push_back({condition, groups.size() > 1 ? kAverageGroup : groups.front(), method, before_m,
                              after_m, difference.value, difference.low(), difference.high()});
    }
  }
  if (changes.rows.empty()) return std::nullopt;
  return changes;
}

}  // namespace trilat
