// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/results/changes.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {

Table changes_table(const ErrorChanges& changes) {
  Table table;
  table.id = "changes";
  table.title = fmt::format("What changed from {} to {}: mean error in cm ({} participants, {})",
                            changes.before, changes.after, changes.participants,
                            changes.paired ? "the same in both" : "others in each");
  table.columns = {{"condition", "condition", true},
                   {"method", "method", true},
                   {"before (cm)", "before_mae_cm"},
                   {"after (cm)", "after_mae_cm"},
                   interval_column("after - before (cm)", "difference_cm"),
                   {"differs", "differs", true}};
  std::vector<const ErrorChange*> rows;
  for (const ErrorChange& change : changes.rows) rows.push_back(&change);
  std::ranges::stable_sort(rows, [](const ErrorChange* a, const ErrorChange* b) {
    if (a->is_real() != b->is_real()) return a->is_real();
    return std::abs(a->difference_m) > std::abs(b->difference_m);
  });
  for (const ErrorChange* c : rows)
    table.rows.push_back({TableValue::of(c->condition), TableValue::of(c->method), cm_cell(c->before_m),
                          cm_cell(c->after_m), cm_cell(c->difference_m, c->low_m, c->high_m),
                          TableValue::of(!c->is_real()           ? "no"
                                         : c->difference_m < 0.0 ? "better"
                                                                 : "worse")});
  table.notes = notes("changes");
  return table;
}

std::vector<std::string> changes_sentences(const ErrorChanges& changes) {
  constexpr std::size_t kMost = 3;
  const Table table = changes_table(changes);
  const auto real = std::ranges::count_if(changes.rows, &ErrorChange::is_real);
  std::vector<std::string> sentences{fmt::format(
      "From `{}` to `{}` the mean error of **{} of {}** methods and conditions changed beyond its interval.",
      changes.before, changes.after, real, changes.rows.size())};
  for (std::size_t r = 0; r < std::min<std::size_t>(kMost, static_cast<std::size_t>(real)); ++r) {
    const auto& row = table.rows[r];
    sentences.push_back(fmt::format("`{}`, {}: {:+.2f} cm ({:+.2f} to {:+.2f}), from {:.2f} to {:.2f}.",
                                    row[1].text, row[0].text, *row[4].number, row[4].low, row[4].high,
                                    *row[2].number, *row[3].number));
  }
  return sentences;
}

}  // namespace trilat
