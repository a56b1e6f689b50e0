// SPDX-License-Identifier: MIT
#include "reports/coverage_table.h"

#include "reports/accuracy_words.h"
#include "reports/statuses_text.h"
#include "reports/table_cells.h"

namespace trilat {
namespace {

struct Answers {
  std::uint64_t asked = 0, answered = 0;
  std::map<std::string, std::uint64_t> statuses;
};

Answers answers_of(const ResultsSummary& s, const std::string& condition, const std::string& method) {
  Answers sum;
  for (const SummaryCell& c : s.cells) {
    if (c.condition != condition || c.method != method || c.alignment != s.alignments.front() ||
        c.group == kAverageGroup)
      continue;
    sum.asked += c.asked;
    sum.answered += c.answered;
    for (const auto& [status, n] : c.statuses) sum.statuses[status] += n;
  }
  return sum;
}

}  // namespace

Table coverage_table(const ResultsSummary& s) {
  Table table;
  table.id = usable_id("coverage-" + s.study);
  table.title = "Coverage and statuses by method, all joint groups together (" + about(s, "", "") + ")";
  table.columns = {{"condition", "condition", true},
                   {"method", "method", true},
                   {"asked", "asked", false},
                   {"n answered", "answered", false},
                   {"coverage (%)", "coverage_percent", false},
                   {"statuses", "statuses", true}};
  if (s.alignments.empty()) return table;
  for (const std::string& condition : s.conditions)
    for (const std::string& method : s.methods) {
      const Answers sum = answers_of(s, condition, method);
      if (sum.asked == 0) continue;
      table.rows.push_back({TableValue::of(condition), TableValue::of(method), count_cell(sum.asked),
                            count_cell(sum.answered), percent_cell(share_of(sum.answered, sum.asked)),
                            TableValue::of(statuses_text(sum.statuses, sum.asked))});
    }
  table.notes = {"Asked: instants and joints with ground truth. Answered: those with a usable estimate."};
  return table;
}

}  // namespace trilat
