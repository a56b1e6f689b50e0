// SPDX-License-Identifier: MIT
#include "reports/tables.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/document.h"
#include "datasets/paper/printed_tables.h"
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

namespace {

int decimals_of(double value) {
  const double size = std::abs(value);
  return size < 10.0 ? 2 : size < 99.0 || size >= 100.0 ? (size < 100.0 ? 1 : 0) : 3;
}

std::string number_text(const ClaimNumber& number) {
  if (!std::isfinite(number.value)) return "no answer";
  const int decimals = decimals_of(number.value);
  std::string text = fmt::format("{:.{}f} {}", number.value, decimals, number.unit);
  if (std::isfinite(number.low))
    text += fmt::format(" ({:.{}f} to {:.{}f})", number.low, decimals, number.high, decimals);
  constexpr double kNearlyAll = 0.995;
  if (number.compared < kNearlyAll)
    text += fmt::format(", where both answer ({:.0f} % of the samples)", 100.0 * number.compared);
  return text;
}

// Without intervals; of several by their names.
std::string short_text(const JudgedClaim& claim) {
  std::string text;
  for (const ClaimNumber& number : claim.numbers) {
    text += text.empty() ? "" : "; ";
    if (claim.numbers.size() > 1) text += number.what + ": ";
    text += std::isfinite(number.value)
                ? fmt::format("{:.{}f} {}", number.value, decimals_of(number.value), number.unit)
                : "no answer";
  }
  return text.empty() ? "–" : text;
}

std::string rule_text(const JudgedClaim& claim) {
  if (claim.numbers.empty()) return claim.reason;
  std::string bounds;
  for (const ClaimNumber& number : claim.numbers)
    if (bounds.find(number.bound) == std::string::npos) bounds += (bounds.empty() ? "" : ", ") + number.bound;
  return fmt::format("{}: {}; over {}", bounds, claim.reason, claim.numbers.front().over);
}

std::string p_text(const JudgedClaim& claim) {
  constexpr double kMinValue = 1e-4;
  if (std::isnan(claim.p)) return "–";
  return claim.p < kMinValue ? "< 0.0001" : fmt::format("{:.4f}", claim.p);
}

std::string both(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

std::string effect_of(const std::string& erratum, const PaperFindings& findings) {
  const auto stored = findings.evidence.errata.find(erratum);
  const auto numbers = findings.errata.find(erratum);
  return both(stored == findings.evidence.errata.end() ? std::string() : stored->second,
              numbers == findings.errata.end() ? std::string() : numbers_text(numbers->second));
}

}  // namespace

std::string numbers_text(const std::vector<ClaimNumber>& numbers) {
  std::string text;
  for (const ClaimNumber& number : numbers)
    text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", number.what, number_text(number));
  return text.empty() ? "–" : text;
}

Table claims_table(const PaperFindings& findings) {
  using R = JudgedClaim;
  Table table = table_of<R>(
      "claims",
      fmt::format("The paper's claims and what becomes of them{}",
                  findings.evidence.any_simulated ? ", with simulated sensors" : ""),
      findings.claims,
      {{"claim", "claim", as_text(&R::claim)},
       {"verdict", "verdict",
        CellOf{[](const R& r) { return TableValue::marked(name_of(r.verdict), mark_of(r.verdict)); }, true}},
       {"paper", "paper", as_text(&R::printed)},
       {"ours", "found", as_text(short_text)},
       {"ours, with interval", "ours", as_text([](const R& r) { return numbers_text(r.numbers); })},
       {"margin and reason", "rule", as_text(rule_text)},
       {"p, corrected", "p", as_text(p_text)},
       {"where", "where", as_text(&R::where)}});
  table.first_columns = 4;
  add_notes(table, "paper_claims", {{"source", printed_errata().source}});
  if (findings.evidence.any_simulated) add_notes(table, "simulated_claims");
  return table;
}

Table errata_table(const PaperFindings& findings) {
  using R = PrintedErrata::Erratum;
  const auto effect = [&](const R& r) {
    const std::string text = effect_of(r.id, findings);
    if (!text.empty()) return text;
    return std::string(r.changes_results ? "its study is not among these results" : "none on a result");
  };
  Table table = table_of<R>("errata",
                            {"What is printed that cannot be so, and what the difference does",
                             findings.evidence.any_simulated ? "simulated" : ""},
                            printed_errata().errata,
                            {{"erratum", "erratum", as_text(&R::id)},
                             {"where", "where", as_text(&R::where)},
                             {"printed", "printed", as_text(&R::printed)},
                             {"why not", "problem", as_text(&R::problem)},
                             {"corrected", "corrected", as_text(&R::corrected)},
                             {"effect in these results", "effect", as_text(effect)}});
  add_notes(table, "errata");
  return table;
}

namespace {

constexpr const char* kTable3 = "table3";
constexpr std::string_view kError = "_mae_cm";  // ends the keys of the columns of groups

// Empty for a column of another kind.
std::string group_of_column(const TableColumn& column) {
  return column.key.ends_with(kError) ? column.key.substr(0, column.key.size() - kError.size())
                                      : std::string();
}

}  // namespace

void add_printed(Table& table, bool simulated) {
  if (table.printed != kTable3) return;
  const PrintedTable3 paper = printed_table3();
  std::vector<std::string> groups;
  for (const TableColumn& column : table.columns)
    if (const std::string group = group_of_column(column); !group.empty()) groups.push_back(group);
  for (std::vector<TableValue>& row : table.rows)
    for (std::size_t c = 0; c < row.size(); ++c) {
      const double cm = printed_cm(paper, groups, group_of_column(table.columns[c]), row.front().text);
      if (std::isfinite(cm)) row[c].beside = fmt::format("paper {:.1f}", cm);
    }
  table.title = "Table III: " + table.title;
  add_notes(table, "table3", {{"source", paper.source}});
  if (simulated) add_notes(table, "table3_simulated");
}

void add_printed(Figure& figure) {
  if (figure.printed != kTable3) return;
  const PrintedTable3 paper = printed_table3();
  for (std::size_t g = 0; g < figure.panels.size(); ++g) {
    FigureSeries series{"the paper", FigureSeries::Style::dots, {}, {}, "truth"};
    series.panel = g;
    series.hollow = true;
    for (std::size_t m = 0; m < figure.y_names.size(); ++m)
      if (const double cm = printed_cm(paper, figure.panels, figure.panels[g], figure.y_names[m]);
          std::isfinite(cm))
        series.points.push_back({cm, static_cast<double>(m)});
    if (!series.points.empty()) figure.series.push_back(std::move(series));
  }
  figure.title += ", the paper's beside ours";
  figure.caption += " Rings: what the paper prints.";
}

}  // namespace trilat
