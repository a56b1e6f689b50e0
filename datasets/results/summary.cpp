// SPDX-License-Identifier: MIT
#include "datasets/results/summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace trilat {
namespace {

constexpr std::size_t kMostLeading = 8;
constexpr std::array kLeading{"linear", "geometric", "nonlinear", "mean", "range_bearing"};

bool has(const std::vector<std::string>& list, const std::string& name) {
  return std::ranges::find(list, name) != list.end();
}

double average_m(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  const SummaryCell* cell = find_cell(s, method, condition, average_group(s), s.alignments.front());
  return cell && !std::isnan(cell->mae_m) ? cell->mae_m : std::numeric_limits<double>::infinity();
}

}  // namespace

void ResultsSummary::check(const JsonObject& object) const {
  if (alignments.empty()) object.refuse("alignments", "must name at least one alignment");
}

void write_summary(const std::filesystem::path& folder, const ResultsSummary& summary) {
  write_results(folder, summary);
}

ResultsSummary read_summary(const std::filesystem::path& folder) {
  return read_results<ResultsSummary>(folder);
}

const SummaryCell* find_cell(const ResultsSummary& summary, const std::string& method,
                             const std::string& condition, const std::string& group,
                             const std::string& alignment) {
  for (const SummaryCell& cell : summary.cells)
    if (cell.method == method && cell.condition == condition && cell.group == group &&
        cell.alignment == alignment)
      return &cell;
  return nullptr;
}

const DifferenceCell* find_difference(const ResultsSummary& summary, const std::string& method,
                                      const std::string& condition, const std::string& group,
                                      const std::string& alignment) {
  for (const DifferenceCell& d : summary.differences)
    if (d.method == method && d.condition == condition && d.group == group && d.alignment == alignment)
      return &d;
  return nullptr;
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
    if (std::ranges::any_of(
            s.cells, [&](const SummaryCell& c) { return c.condition == condition && c.group == group; }))
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
    if (has(s.methods, name) && !has(leading, name) && leading.size() < kMostLeading) leading.push_back(name);
  };
  for (const MethodNote& note : s.legend)
    if (note.is_brought && has(s.methods, note.method)) leading.push_back(note.method);
  for (const char* name : kLeading) add(name);
  const auto is_single = [](const std::string& name) {
    return name == "single" || name.starts_with("single ");
  };
  if (const auto single = std::ranges::find_if(sorted, is_single); single != sorted.end()) add(*single);
  add(s.reference);
  if (const BestMethod* best = find_best(s, condition, average_group(s))) add(best->method);
  if (leading.size() < 4 || s.methods.size() <= kMostLeading)
    for (const std::string& name : sorted) add(name);
  return by_error(s, condition, std::move(leading));
}

}  // namespace trilat
