// SPDX-License-Identifier: MIT
// Methods that share a row of the tables, or have none.
#include <algorithm>
#include <set>

#include "pipeline/accuracy/shown/accuracy_shown.h"

namespace trilat {
namespace {

// Each single sensor is a row of the other tables.
bool is_of_sets(const SensorSetGroup& family) { return family.sensors > 1; }

// The paper's own rows stay apart, since its numbers stand beside them.
bool has_printed_row(const std::string& method) {
  return method == "linear" || method == "geometric" || method == "nonlinear";
}

bool answer_alike(const ResultsSummary& s, const std::string& a, const std::string& b) {
  bool any = false;
  for (const std::string& condition : s.conditions)
    for (const std::string& group : groups_in(s, condition))
      for (const std::string& alignment : s.alignments) {
        const Number *one = find_error(s, a, condition, group, alignment),
                     *other = find_error(s, b, condition, group, alignment);
        const Number *of_one = find_coverage(s, a, condition, group, alignment),
                     *of_other = find_coverage(s, b, condition, group, alignment);
        if (!one != !other || !of_one != !of_other || (of_one && of_one->n != of_other->n)) return false;
        if (one && (one->n != other->n || one->value != other->value)) return false;
        any |= one != nullptr;
      }
  return any;
}

void drop_method(ResultsSummary& s, const std::string& method) {
  std::erase(s.methods, method);
  std::erase_if(s.legend, [&](const MethodNote& note) { return note.method == method; });
  for (BestMethod& best : s.best) std::erase(best.not_distinguished, method);
}

// A method that answers as an earlier one does shares its row.
void join_alike(ResultsSummary& s) {
  for (std::size_t m = 0; m < s.methods.size(); ++m) {
    const std::string method = s.methods[m];
    const auto note = std::ranges::find(s.legend, method, &MethodNote::method);
    if (has_printed_row(method) || note == s.legend.end()) continue;
    MethodNote joined = *note;
    const std::vector<std::string> later(s.methods.begin() + static_cast<std::ptrdiff_t>(m) + 1,
                                         s.methods.end());
    for (const std::string& other : later) {
      if (has_printed_row(other) || other == s.reference || !answer_alike(s, method, other)) continue;
      for (BestMethod& best : s.best)
        if (best.method == other) {
          best.method = method;
          std::erase(best.not_distinguished, method);
        }
      for (const MethodNote& of_other : s.legend)
        if (of_other.method == other) joined.is_external |= of_other.is_external;
      drop_method(s, other);
      joined.alike.push_back(other);
    }
    *std::ranges::find(s.legend, method, &MethodNote::method) = joined;
  }
}

}  // namespace

std::string row_name(const ResultsSummary& s, const std::string& method) {
  const auto note = std::ranges::find(s.legend, method, &MethodNote::method);
  std::string name = method;
  if (note != s.legend.end())
    for (const std::string& other : note->alike) name += " = " + other;
  return name;
}

ResultsSummary shown_summary(ResultsSummary s) {
  std::set<std::string> members;
  for (const SensorSetGroup& family : s.families)
    if (is_of_sets(family) && family.methods.size() > 1)
      members.insert(family.methods.begin(), family.methods.end());
  members.erase(s.reference);
  std::erase_if(s.methods, [&](const std::string& name) { return members.contains(name); });
  join_alike(s);
  return s;
}

}  // namespace trilat
