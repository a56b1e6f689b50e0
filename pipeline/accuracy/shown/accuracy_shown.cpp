// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/shown/accuracy_shown.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/paper/printed_tables.h"
#include "pipeline/accuracy/shown/accuracy_words.h"

namespace trilat {

std::vector<std::string> answers_on_the_paper(const ResultsSummary& s) {
  constexpr const char* kCondition = "walking";
  if (s.left_out()) return {};
  // relative to the mean, as the paper has it
  const bool relative = std::ranges::find(s.alignments, "mean") != s.alignments.end();
  const std::string alignment = relative ? "mean" : s.alignments.front();
  const std::string group = average_group(s);
  const auto cell = [&](const std::string& method) {
    const SummaryCell* found = find_cell(s, method, kCondition, group, alignment);
    return found && std::isfinite(found->mae_m) ? found : nullptr;
  };
  const PrintedTable3 paper = printed_table3();
  const std::vector<std::string> groups = groups_in(s, kCondition);
  std::vector<std::string> answers;
  std::string ours, printed;
  for (const char* method : {"nonlinear", "linear", "geometric"})
    if (const SummaryCell* c = cell(method)) {
      ours += fmt::format("{}`{}` {}", ours.empty() ? "" : ", ", method, error_text(*c));
      if (const double cm = printed_cm(paper, groups, group, method); std::isfinite(cm))
        printed += fmt::format("{}{:.1f}", printed.empty() ? "" : ", ", cm);
    }
  if (ours.empty()) return answers;
  answers.push_back(fmt::format("**Trilateration** of {} walker{}, {}: mean error {}.{}", s.participants,
                                s.participants == 1 ? "" : "s", s.simulated ? "simulated" : "recorded", ours,
                                relative && !printed.empty() ? " The paper prints " + printed + " cm." : ""));
  if (const SummaryCell* mean = cell("mean")) {
    const std::string against = difference_text(s, kCondition, alignment, "mean");
    answers.push_back(fmt::format("**The plain mean** of the same sensors errs by {}{}{}.", error_text(*mean),
                                  against.empty() ? "" : ": ", against));
  }
  const BestMethod* best = find_best(s, kCondition, group);
  if (best && best->method != "mean" && alignment == s.alignments.front() && cell(best->method))
    answers.push_back(fmt::format(
        "**`{}`** errs least, by {}{}.", best->method, error_text(*cell(best->method)),
        best->like_best.empty()
            ? std::string()
            : fmt::format("; cannot be distinguished from it: `{}`", fmt::join(best->like_best, "`, `"))));
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
  const ResultsSummary s = without_sets(whole);
  StoredTables shown;
  shown.title = s.study + " on " + s.campaign;
  shown.asked = "How far from the truth is each method?";
  shown.about =
      fmt::format("{} of {} takes, {} participant{}, {}.", s.takes - s.takes_failed, s.takes, s.participants,
                  s.participants == 1 ? "" : "s", s.simulated ? "**simulated** sensors" : "recorded sensors");
  shown.findings = accuracy_findings(s);
  shown.on_the_paper = answers_on_the_paper(s);
  shown.warnings = accuracy_warnings(s);
  if (s.left_out()) shown.sentences.push_back(truth_note(s));
  const auto add = [&](std::vector<Table> tables, Table::Shown where) {
    for (Table& table : tables) {
      table.shown = where;
      shown.tables.push_back(std::move(table));
    }
  };
  std::vector<Table> articles = article_tables(s);
  for (Table& table : articles) add_cross_checks(s, table);
  add(std::move(articles), Table::Shown::first);
  add(takes_tables(s), Table::Shown::first);
  add(table2(s), Table::Shown::detail);
  add(accuracy_tables(s), Table::Shown::detail);
  add(apart_tables(s), Table::Shown::file);
  if (tracking) {
    add(prediction_tables(*tracking), s.left_out() ? Table::Shown::first : Table::Shown::detail);
    add(tracking_tables(*tracking), Table::Shown::detail);
  }
  if (tracking && !tracking->checks.empty()) add({checks_table(*tracking)}, Table::Shown::file);
  return shown;
}

}  // namespace trilat
