// SPDX-License-Identifier: MIT
#include "pipeline/errors/error_changes.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "datasets/results/results_file.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

// The errors of a summary by participant.
class ErrorsByParticipant {
 public:
  explicit ErrorsByParticipant(const ResultsSummary& summary)
      : summary_(summary), participants_(participants_of(summary)) {
    for (const TakeJointRow& row : summary.by_take) {
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
    for (const std::string& group : summary_.groups)
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
  const ResultsSummary& summary_;
  std::vector<std::string> participants_;
  std::map<std::tuple<std::string, std::string, std::string>, WeightedRatio> sums_;
};

// Makes room for different participants: each side by itself, the other's clusters without samples.
void pad(std::vector<WeightedRatio>& ratios, std::size_t before, std::size_t behind) {
  for (WeightedRatio& ratio : ratios)
    for (auto* values : {&ratio.numerator, &ratio.denominator}) {
      values->insert(values->begin(), before, 0.0);
      values->insert(values->end(), behind, 0.0);
    }
}

}  // namespace

std::vector<std::string> participants_of(const ResultsSummary& summary) {
  std::set<std::string> names;
  for (const TakeJointRow& row : summary.by_take) names.insert(row.participant);
  return {names.begin(), names.end()};
}

std::optional<ErrorChanges> changes_between(const ResultsSummary& before, const ResultsSummary& after) {
  if (before.alignments.front() != after.alignments.front() || before.truth != after.truth)
    return std::nullopt;
  const ErrorsByParticipant errors_before(before), errors_after(after);
  const std::vector<std::string>&then = errors_before.participants(), &now = errors_after.participants();
  ErrorChanges changes{"", "", then == now, std::min(then.size(), now.size()), {}};
  const auto add = [&](const std::string& condition, const std::string& method,
                       const std::vector<std::string>& groups) {
    std::vector<WeightedRatio> value = errors_after.mean_error(condition, groups, method, 1.0),
                               minus = errors_before.mean_error(condition, groups, method, -1.0);
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
