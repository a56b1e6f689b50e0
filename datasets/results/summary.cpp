// SPDX-License-Identifier: MIT
#include "datasets/results/summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace trilat {
namespace {

constexpr std::size_t kMaxLeading = 8;
constexpr std::array kLeading{"linear", "geometric", "nonlinear", "mean", "range_bearing"};

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

NumberKey key_of(const std::string& method, const std::string& condition, const std::string& group,
                 const std::string& alignment) {
  return {.condition = condition, .group = group, .method = method, .alignment = alignment};
}

double average_m(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  const Number* error = find_error(s, method, condition, average_group(s), s.alignments.front());
  return error ? error->value : std::numeric_limits<double>::infinity();
}

}  // namespace

void ResultsSummary::check(const JsonPlace& place) const {
  if (alignments.empty()) place.at("alignments").refuse("must name at least one alignment");
}

const Number* find_error(const ResultsSummary& summary, const std::string& method,
                         const std::string& condition, const std::string& group,
                         const std::string& alignment) {
  return summary.numbers.find(
      key_of(method, condition, group, alignment).with({.measure = "distance", .statistic = "mean"}));
}

const Number* find_coverage(const ResultsSummary& summary, const std::string& method,
                            const std::string& condition, const std::string& group,
                            const std::string& alignment) {
  return summary.numbers.find(
      key_of(method, condition, group, alignment).with({.measure = "answered", .statistic = "share"}));
}

double coverage_of(const ResultsSummary& summary, const std::string& method, const std::string& condition,
                   const std::string& group, const std::string& alignment) {
  const Number* coverage = find_coverage(summary, method, condition, group, alignment);
  return coverage ? coverage->value : kNaN;
}

const Number* find_difference(const ResultsSummary& summary, const std::string& method,
                              const std::string& condition, const std::string& group,
                              const std::string& alignment, const char* statistic) {
  return summary.numbers.find(
      key_of(method, condition, group, alignment)
          .with({.against = summary.reference, .measure = "distance", .statistic = statistic}));
}

std::vector<TakeJointRow> rows_by_take(const ResultsSummary& summary) {
  std::vector<TakeJointRow> rows;
  for (const Number& asked : summary.numbers.all()) {
    if (asked.take.empty() || asked.measure != "answered") continue;
    const auto group = summary.group_of_joint.find(asked.group);
    const auto participant = summary.participant_of_take.find(asked.take);
    TakeJointRow& row = rows.emplace_back();
    row.take = asked.take;
    row.participant = participant == summary.participant_of_take.end() ? "" : participant->second;
    row.condition = asked.condition;
    row.group = group == summary.group_of_joint.end() ? asked.group : group->second;
    row.joint = asked.group;
    row.method = asked.method;
    row.asked = asked.n;
    const NumberKey error = asked.with({.measure = "distance", .statistic = "mean"});
    row.answered = summary.numbers.n(error);
    row.mae_m = summary.numbers.value(error);
  }
  return rows;
}

void add_row(const TakeJointRow& row, ResultsSummary& summary) {
  summary.group_of_joint[row.joint] = row.group;
  summary.participant_of_take[row.take] = row.participant;
  const NumberKey key{.condition = row.condition,
                      .group = row.joint,
                      .method = row.method,
                      .alignment = summary.alignments.front(),
                      .take = row.take};
  summary.numbers.add({key.with({.measure = "answered", .statistic = "share"}),
                       static_cast<double>(row.answered) / static_cast<double>(row.asked), kNaN, kNaN,
                       row.asked});
  summary.numbers.add(
      {key.with({.measure = "distance", .statistic = "mean"}), row.mae_m, kNaN, kNaN, row.answered});
}

const BestMethod* find_best(const ResultsSummary& summary, const std::string& condition,
                            const std::string& group) {
  for (const BestMethod& best : summary.best)
    if (best.condition == condition && best.group == group) return &best;
  return nullptr;
}

std::string average_group(const ResultsSummary& s) {
  return s.groups.size() > 1 ? kAverageGroup : s.groups.empty() ? std::string() : s.groups.front();
}

std::vector<std::string> groups_in(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> groups;
  for (const std::string& group : s.groups)
    if (std::ranges::any_of(s.methods, [&](const std::string& method) {
          return find_coverage(s, method, condition, group, s.alignments.front());
        }))
      groups.push_back(group);
  if (groups.size() > 1) groups.emplace_back(kAverageGroup);
  return groups;
}

std::vector<std::string> by_error(const ResultsSummary& s, const std::string& condition,
                                  std::vector<std::string> methods) {
  std::ranges::stable_sort(methods, {}, [&](const std::string& m) { return average_m(s, condition, m); });
  return methods;
}

std::vector<std::string> leading_methods(const ResultsSummary& s, const std::string& condition) {
  std::vector<std::string> leading, sorted = by_error(s, condition, s.methods);
  const auto add = [&](const std::string& name) {
    if (has(s.methods, name) && !has(leading, name) && leading.size() < kMaxLeading) leading.push_back(name);
  };
  for (const MethodNote& note : s.legend)
    if (note.is_external && has(s.methods, note.method)) leading.push_back(note.method);
  for (const char* name : kLeading) add(name);
  const auto is_single = [](const std::string& name) {
    return name == "single" || name.starts_with("single ");
  };
  if (const auto single = std::ranges::find_if(sorted, is_single); single != sorted.end()) add(*single);
  add(s.reference);
  if (const BestMethod* best = find_best(s, condition, average_group(s))) add(best->method);
  if (leading.size() < 4 || s.methods.size() <= kMaxLeading)
    for (const std::string& name : sorted) add(name);
  return by_error(s, condition, std::move(leading));
}

}  // namespace trilat
