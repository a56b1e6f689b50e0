// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/shown/accuracy_shown.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/words.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {

std::vector<std::string> paper_comparison(const ResultsSummary& s) {
  constexpr const char* kCondition = "walking";
  if (s.left_out()) return {};
  // relative to the mean, as the paper has it
  const bool relative = std::ranges::find(s.alignments, "mean") != s.alignments.end();
  const std::string alignment = relative ? "mean" : s.alignments.front();
  const std::string group = average_group(s);
  const auto error = [&](const std::string& method) {
    return find_error(s, method, kCondition, group, alignment);
  };
  if (!error("nonlinear")) return {};
  std::vector<std::string> answers;
  if (error("mean") && s.reference == "nonlinear")
    if (const std::string against = difference_text(s, kCondition, alignment, "mean"); !against.empty()) {
      const Number* d = find_difference(s, "mean", kCondition, group, alignment);
      answers.push_back(!is_significant(*d)
                            ? "**Undecided**: the plain mean of the same sensors is " + against + "."
                            : fmt::format("**{}**: the plain mean of the same sensors errs {}.",
                                          d->value < 0.0 ? "No" : "Yes", against));
    }
  const PrintedTable3 paper = printed_table3();
  const std::vector<std::string> groups = groups_in(s, kCondition);
  std::string ours, printed;
  for (const char* method : {"nonlinear", "linear", "geometric"})
    if (const Number* e = error(method)) {
      ours += fmt::format("{}`{}` {}", ours.empty() ? "" : ", ", method, error_text(*e));
      if (const double cm = printed_cm(paper, groups, group, method); std::isfinite(cm))
        printed += fmt::format("{}{:.1f}", printed.empty() ? "" : ", ", cm);
    }
  answers.push_back(
      fmt::format("Errors of trilateration: {}.{}", ours,
                  relative && !printed.empty() ? " The paper prints " + printed + " cm." : std::string()));
  std::string better;
  std::vector<std::string> methods = by_error(s, kCondition, leading_methods(s, kCondition));
  for (const std::string& method : methods) {
    const Number* d = find_difference(s, method, kCondition, group, alignment);
    if (!d || !is_significant(*d) || d->value > 0.0 || method.starts_with("single")) continue;
    better += fmt::format("{}`{}` {}", better.empty() ? "" : ", ", method, error_text(*error(method)));
  }
  if (!better.empty()) answers.push_back("Methods that err less: " + better + ".");
  answers.push_back(
      fmt::format("Data: {}, average of {}, each method's mean offset taken away.",
                  counted(s.participants, s.simulated ? "**simulated** walker" : "recorded walker"),
                  counted(s.groups.size(), "joint group")));
  if (!relative) answers.back() = answers.back().substr(0, answers.back().rfind(", each")) + ".";
  return answers;
}

namespace {

void add_cross_checks(const ResultsSummary& s, Table& table) {
  for (const CrossCheck& check : s.cross_checks)
    table.notes.push_back(
        fmt::format("Cross-check of {} with Ceres, {}: {} problems, largest distance {:.3g} m (limit {:g} "
                    "m), {} answered "
                    "by one only, {} objectives lost.",
                    check.method, check.passed() ? "agrees" : "DISAGREES", check.samples, check.worst_m,
                    check.limit_m, check.disagreements, check.lost));
}

}  // namespace

StoredTables accuracy_shown(const ResultsSummary& whole, const std::optional<TrackingSummary>& tracking) {
  const ResultsSummary s = shown_summary(whole);
  StoredTables shown;
  shown.title = s.study == s.campaign ? s.study : s.study + " on " + s.campaign;
  shown.asked = "How far from the truth is each method?";
  shown.about = fmt::format("{} of {}, {}, {}.", s.takes - s.takes_failed, counted(s.takes, "take"),
                            counted(s.participants, "participant"),
                            s.simulated ? "**simulated** sensors" : "recorded sensors");
  shown.findings = accuracy_findings(s);
  shown.on_the_paper = paper_comparison(s);
  shown.warnings = accuracy_warnings(s);
  shown.legend = method_legend(s);
  if (s.left_out()) shown.sentences.push_back(truth_note(s));
  const auto add = [&](std::vector<Table> tables, Table::Placement where) {
    for (Table& table : tables) {
      table.shown = where;
      shown.tables.push_back(std::move(table));
    }
  };
  std::vector<Table> articles = article_tables(s);
  for (Table& table : articles) add_cross_checks(s, table);
  add(std::move(articles), Table::Placement::first);
  add(takes_tables(s), Table::Placement::first);
  add(table2(s), Table::Placement::detail);
  add(accuracy_tables(s), Table::Placement::detail);
  add(joint_tables_by_take(s), Table::Placement::file);
  if (tracking) {
    add(prediction_tables(s), s.left_out() ? Table::Placement::first : Table::Placement::detail);
    add(bound_tables(s, *tracking), Table::Placement::detail);
    add(tracking_tables(*tracking), Table::Placement::detail);
  }
  if (tracking && !tracking->checks.empty()) add({checks_table(*tracking)}, Table::Placement::file);
  return shown;
}

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
