// SPDX-License-Identifier: MIT
#include "reports/tables.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/document.h"
#include "reports/embedded_recorded.h"

namespace trilat {

Table changes_table(const ErrorChanges& changes) {
  using R = ErrorChange;
  std::vector<R> rows = changes.rows;
  std::ranges::stable_sort(rows, [](const R& a, const R& b) {
    if (a.is_real() != b.is_real()) return a.is_real();
    return std::abs(a.difference_m) > std::abs(b.difference_m);
  });
  Table table = table_of<R>(
      "changes",
      fmt::format("What changed from {} to {}: mean error in cm ({} participants, {})", changes.before,
                  changes.after, changes.participants,
                  changes.paired ? "the same in both" : "others in each"),
      rows,
      {{"condition", "condition", as_text(&R::condition)},
       {"method", "method", as_text(&R::method)},
       {"before (cm)", "before_mae_cm", in_cm(&R::before_m)},
       {"after (cm)", "after_mae_cm", in_cm(&R::after_m)},
       {"after - before (cm)", "difference_cm", in_cm(&R::difference_m, &R::low_m, &R::high_m)},
       {"differs", "differs",
        CellOf{[](const R& r) {
                 if (!r.is_real()) return TableValue::of("no");
                 return r.difference_m < 0.0 ? TableValue::marked("better", TableValue::Mark::good)
                                             : TableValue::marked("worse", TableValue::Mark::bad);
               },
               true}}});
  add_notes(table, "changes");
  return table;
}

std::vector<std::string> changes_sentences(const ErrorChanges& changes) {
  constexpr std::size_t kMaxCount = 3;
  const Table table = changes_table(changes);
  const auto real = std::ranges::count_if(changes.rows, &ErrorChange::is_real);
  std::vector<std::string> sentences{fmt::format(
      "From `{}` to `{}` the mean error of **{} of {}** methods and conditions changed beyond its interval.",
      changes.before, changes.after, real, changes.rows.size())};
  for (std::size_t r = 0; r < std::min<std::size_t>(kMaxCount, static_cast<std::size_t>(real)); ++r) {
    const auto& row = table.rows[r];
    sentences.push_back(fmt::format("`{}`, {}: {:+.2f} cm ({:+.2f} to {:+.2f}), from {:.2f} to {:.2f}.",
                                    row[1].text, row[0].text, *row[4].number, row[4].low, row[4].high,
                                    *row[2].number, *row[3].number));
  }
  return sentences;
}

Table recorded_table() { return read_as<Table>(Json::parse(embedded::recorded_json), {"recorded.json"}); }

}  // namespace trilat
