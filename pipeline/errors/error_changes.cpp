// SPDX-License-Identifier: MIT
#include "pipeline/errors/error_changes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "datasets/results/results_file.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

// The errors of joints by participant.
class ErrorsByParticipant {
 public:
  explicit ErrorsByParticipant(const ErrorsByJoint& errors)
      : all_(errors), participants_(participants_of(errors)) {
    for (const TakeJointRow& row : errors.rows) {
      WeightedRatio& sums = sums_[{row.condition, row.group, row.method}];
      sums.numerator.resize(participants_.size());
      sums.denominator.resize(participants_.size());
      if (row.answered == 0) continue;
      const auto p =
          static_cast<std::size_t>(std::ranges::find(participants_, row.participant) - participants_.begin());
      sums.numerator[p] += static_cast<double>(row.answered) * row.mae_m;
      sums.denominator[p] += static_cast<double>(row.answered);
    }
  }
  const std::vector<std::string>& participants() const { return participants_; }
  // Joint groups of the condition, in the study's order.
  std::vector<std::string> groups_of(const std::string& condition) const {
    std::vector<std::string> groups;
    for (const std::string& group : all_.groups)
      if (std::ranges::any_of(sums_, [&](const auto& entry) {
            return std::get<0>(entry.first) == condition && std::get<1>(entry.first) == group;
          }))
        groups.push_back(group);
    return groups;
  }
  // The plain mean over the groups, times `sign`.
  std::vector<WeightedRatio> mean_error(const std::string& condition, const std::vector<std::string>& groups,
                                        const std::string& method, double sign) const {
    std::vector<WeightedRatio> ratios;
    for (const std::string& group : groups) {
      const auto found = sums_.find({condition, group, method});
      ratios.push_back(found == sums_.end() ? WeightedRatio{std::vector<double>(participants_.size()),
                                                            std::vector<double>(participants_.size())}
                                            : found->second);
      ratios.back().weight = sign / static_cast<double>(groups.size());
    }
    return ratios;
  }

 private:
  const ErrorsByJoint& all_;
  std::vector<std::string> participants_;
  std::map<std::tuple<std::string, std::string, std::string>, WeightedRatio> sums_;
};

// Difference of the same participants, or of two groups of different ones (Welch 1947).
void add_interval(const std::vector<WeightedRatio>& now, const std::vector<WeightedRatio>& before_negative,
                  bool paired, ErrorChange& row) {
  if (paired) {
    std::vector<WeightedRatio> both = now;
    both.insert(both.end(), before_negative.begin(), before_negative.end());
    const Estimate difference = solve_contrast({std::move(both), {}});
    row.difference_m = difference.value;
    row.standard_error_m = difference.standard_error;
    row.clusters = difference.clusters;
    row.degrees = difference.clusters >= 2 ? difference.clusters - 1 : 0;
  } else {
    const Estimate after = solve_contrast({now, {}}), before = solve_contrast({before_negative, {}});
    row.difference_m = after.value + before.value;
    row.clusters = after.clusters + before.clusters;
    if (after.clusters < 2 || before.clusters < 2) return;
    const double a = after.standard_error * after.standard_error,
                 b = before.standard_error * before.standard_error;
    row.standard_error_m = std::sqrt(a + b);
    const double degrees =
        (a + b) * (a + b) /
        (a * a / static_cast<double>(after.clusters - 1) + b * b / static_cast<double>(before.clusters - 1));
    row.degrees = degrees >= 1.0 ? static_cast<std::size_t>(degrees) : 1;
  }
  if (row.degrees == 0 || !std::isfinite(row.standard_error_m)) return;
  const double half_m = student_quantile(row.degrees) * row.standard_error_m;
  row.low_m = row.difference_m - half_m;
  row.high_m = row.difference_m + half_m;
  row.p_value = student_two_sided(row.difference_m / row.standard_error_m, row.degrees);
}

}  // namespace

ErrorsByJoint errors_by_joint(const ResultsSummary& summary) {
  return {summary.conditions, summary.methods, summary.groups, rows_by_take(summary)};
}

bool are_comparable(const ResultsSummary& before, const ResultsSummary& after) {
  return before.alignments.front() == after.alignments.front() && before.truth == after.truth;
}

std::vector<std::string> participants_of(const ErrorsByJoint& errors) {
  std::set<std::string> names;
  for (const TakeJointRow& row : errors.rows) names.insert(row.participant);
  return {names.begin(), names.end()};
}

std::optional<ErrorChanges> changes_between(const ErrorsByJoint& before, const ErrorsByJoint& after) {
  const ErrorsByParticipant errors_before(before), errors_after(after);
  const std::vector<std::string>&then = errors_before.participants(), &now = errors_after.participants();
  ErrorChanges changes{"", "", then == now, std::min(then.size(), now.size()), {}};
  const auto error_of = [](const ErrorsByParticipant& errors, const std::string& condition,
                           const std::vector<std::string>& groups, const std::string& method) {
    return solve_contrast({errors.mean_error(condition, groups, method, 1.0), {}}).value;
  };
  const auto add = [&](const std::string& condition, const std::string& method,
                       std::vector<std::string> groups) {
    const bool is_average = groups.size() > 1;
    std::vector<std::string> silent;  // on one of both sides: the average is that of the others
    if (is_average)
      std::erase_if(groups, [&](const std::string& group) {
        const bool answers = std::isfinite(error_of(errors_after, condition, {group}, method)) &&
                             std::isfinite(error_of(errors_before, condition, {group}, method));
        if (!answers) silent.push_back(group);
        return !answers;
      });
    if (groups.empty()) return;
    const std::vector<WeightedRatio> value = errors_after.mean_error(condition, groups, method, 1.0),
                                     minus = errors_before.mean_error(condition, groups, method, -1.0);
    ErrorChange row{condition, is_average ? kAverageGroup : groups.front(), method};
    row.without = std::move(silent);
    row.after_m = solve_contrast({value, {}}).value;
    row.before_m = -solve_contrast({minus, {}}).value;
    add_interval(value, minus, changes.paired, row);
    changes.rows.push_back(std::move(row));
  };
  for (const std::string& condition : after.conditions) {
    const std::vector<std::string> groups = errors_after.groups_of(condition);
    if (groups.empty() || errors_before.groups_of(condition) != groups) continue;
    for (const std::string& method : after.methods) {
      if (std::ranges::find(before.methods, method) == before.methods.end()) continue;
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
  const ResultsSummary before = read_results<ResultsSummary>(results[0]),
                       after = read_results<ResultsSummary>(results[1]);
  if (!are_comparable(before, after)) return std::nullopt;
  std::optional<ErrorChanges> changes = changes_between(errors_by_joint(before), errors_by_joint(after));
  if (!changes) return changes;
  changes->before = results[0].string();
  changes->after = results[1].string();
  if (after.groups.size() > 1)  // one row a method is shown
    std::erase_if(changes->rows, [](const ErrorChange& row) { return row.group != kAverageGroup; });
  return changes;
}

}  // namespace trilat
