// SPDX-License-Identifier: MIT
#include "pipeline/cli/accuracy_outcome.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "reports/render/render.h"

namespace trilat {
namespace {

constexpr std::size_t kWidest = 100, kMostRows = 40;

using Row = std::vector<std::string>;

std::string short_error(const SummaryCell* cell) {
  if (!cell || std::isnan(cell->mae_m)) return "–";
  const double half_m = 0.5 * (cell->mae_high_m - cell->mae_low_m);
  return fmt::format("{:.1f}", cell->mae_m * kCentimetresPerMetre) +
         (std::isnan(half_m) ? "" : fmt::format("±{:.1f}", half_m * kCentimetresPerMetre));
}

// The difference of the mean errors where both answer, when it is real.
std::string short_difference(const ResultsSummary& s, const std::string& condition, const std::string& group,
                             const std::string& method) {
  if (method == s.reference) return "";
  for (const DifferenceCell& d : s.differences)
    if (d.condition == condition && d.group == group && d.method == method &&
        d.alignment == s.alignments.front() && !std::isnan(d.percent_low))
      return !d.significant() ? "≈"
                              : fmt::format("{:+.{}f} %", d.percent_of_reference,
                                            std::abs(d.percent_of_reference) < 1.0 ? 1 : 0);
  return "–";
}

bool is_whole(const SummaryCell& cell) { return !(cell.coverage() < kWhole); }

// The groups that have cells, the average first.
std::vector<std::string> columns_of(const ResultsSummary& s) {
  std::vector<std::string> groups = s.groups;
  groups.insert(groups.begin(), kAverageGroup);
  std::erase_if(groups, [&](const std::string& group) {
    return std::ranges::none_of(s.cells, [&](const SummaryCell& c) { return c.group == group; });
  });
  return groups;
}

std::string table_text(const ResultsSummary& s) {
  const std::vector<std::string> groups = columns_of(s);
  if (groups.empty()) return "no sample was answered\n";
  const bool several = s.conditions.size() > 1, compared = s.methods.size() > 1,
             silent = std::ranges::any_of(s.cells, [](const SummaryCell&c) { return !is_whole(c); });
  const auto cell = [&](const std::string& condition, const std::string& group, const std::string& method) {
    return find_cell(s, method, condition, group, s.alignments.front());
  };
  std::vector<Row> rows{{several ? "condition, method" : "method"}};
  if (compared) rows[0].push_back("difference");
  if (silent) rows[0].push_back("answered");
  rows[0].insert(rows[0].end(), groups.begin(), groups.end());
  for (const std::string& condition : s.conditions)
    for (const std::string& method : by_error(s, condition, s.methods)) {
      Row& row = rows.emplace_back();
      row.push_back((several ? condition + ", " : "") + method);
      if (compared) row.push_back(short_difference(s, condition, groups.front(), method));
      const SummaryCell* all = cell(condition, groups.front(), method);
      if (silent)
        row.push_back(!all || is_whole(*all) ? "" : fmt::format("{:.1f} %", 100.0 * all->coverage()));
      for (const std::string& group : groups) row.push_back(short_error(cell(condition, group, method)));
    }
  std::vector<std::size_t> widths;
  std::size_t total = 0;
  for (std::size_t c = 0; c < rows[0].size(); ++c) {
    std::size_t width = 0;
    for (const Row& row : rows) width = std::max(width, width_of(row[c]));
    if (c > 1 && total + width + 2 > kWidest) break;
    total += width + 2;
    widths.push_back(width);
  }
  std::string text;
  const std::size_t shown = std::min(rows.size(), kMostRows + 1);
  for (std::size_t r = 0; r < shown; ++r) {
    std::string line;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string blanks(widths[c] - width_of(rows[r][c]), ' ');
      line += c == 0 ? rows[r][c] + blanks : "  " + blanks + rows[r][c];
    }
    text += line + "\n";
  }
  const std::size_t rows_left = rows.size() - shown, groups_left = rows[0].size() - widths.size();
  if (rows_left > 0) text += fmt::format("{} rows more: --tables\n", rows_left);
  if (groups_left > 0) text += fmt::format("{} more of the joint groups: --tables\n", groups_left);
  std::string legend = "±: half of the 95 % interval; –: no answer";
  if (silent) legend += "; answered: of what is asked, blank where all is";
  if (compared)
    legend += fmt::format(
        "; difference: from {}, of the average, where both answer; ≈: cannot be distinguished", s.reference);
  text += "\n";
  for (const std::string& line : lines_of(legend, kWidest)) text += line + "\n";
  return text;
}

}  // namespace

std::string outcome_text(const ResultsSummary& s) {
  if (s.alignments.empty()) return "";
  std::string words;
  const auto add = [&](std::string sentence) {
    std::erase_if(sentence, [](char c) { return c == '*' || c == '`'; });
    for (const std::string& line : lines_of(sentence, kWidest)) words += line + "\n";
  };
  for (const std::string& finding : accuracy_findings(s)) add(finding);
  for (const std::string& warning : accuracy_warnings(s, false)) add("warning: " + warning);
  std::set<std::string> noted;
  for (const TakeNote& note : s.notes)
    if (!note.failed && !note.take.empty()) noted.insert(note.take);
  const std::string notes =
      noted.empty() ? "" : fmt::format("; {} take{} with notes", noted.size(), noted.size() == 1 ? "" : "s");
  return fmt::format("{}, {}: {} of {} takes, {} participant{}{}\nmean error in cm{} (alignment {})\n\n",
                     s.campaign, s.simulated ? "simulated" : "recorded", s.takes - s.takes_failed, s.takes,
                     s.participants, s.participants == 1 ? "" : "s", notes,
                     s.left_out() ? " against the sensor left out" : "", s.alignments.front()) +
         table_text(s) + "\n" + (s.left_out() ? truth_note(s) + "\n" : "") + words + "\n";
}

}  // namespace trilat
