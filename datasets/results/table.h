// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/units.h"
#include "datasets/results/summary.h"

namespace trilat {

// One cell: a number with the decimals it is printed with (negative: as many as it needs, up to six digits),
// or a text. CSV gets the number unrounded.
struct TableValue {
  // How it stands in its row or column, where a table says so: among methods, or as a verdict.
  enum class Mark : std::uint8_t {
    none,
    best,
    not_distinguished,
    good,
    bad,
    contradiction,
    unsure,
    untested
  };
  std::optional<double> number;
  int decimals = 1;
  std::string text;
  double low = kNaN, high = kNaN;  // of a number in a column with intervals
  Mark mark = Mark::none;
  std::string beside = {};  // what stands behind a number: "paper 8.7"

  // Leaves out what most cells do not have.
  static void fields(auto& self, auto&& f) {
    f("number", self.number, "decimals", self.decimals);
    if (f.has("text", !self.text.empty())) f("text", self.text);
    if (f.has("low", !std::isnan(self.low) || !std::isnan(self.high))) f("low", self.low, "high", self.high);
    if (f.has("mark", self.mark != Mark::none)) f("mark", self.mark);
    if (f.has("beside", !self.beside.empty())) f("beside", self.beside);
  }

  bool is_verdict() const { return mark >= Mark::good; }
  static TableValue marked(std::string text, Mark mark) {
    TableValue value = of(std::move(text));
    value.mark = mark;
    return value;
  }
  static TableValue of(double value, int decimals) { return {value, decimals, {}}; }
  static TableValue of(std::string text) { return {std::nullopt, 0, std::move(text)}; }
};

inline TableValue::Mark mark_of(ClaimVerdict verdict) {
  using Mark = TableValue::Mark;
  constexpr std::array kMarks{Mark::good, Mark::bad, Mark::unsure, Mark::contradiction, Mark::untested};
  return kMarks.at(static_cast<std::size_t>(verdict));
}

struct TableColumn {
  std::string name;  // with its unit, as in "MAE (cm)"
  std::string key;   // lower_snake with unit, for CSV
  bool is_text = false;
  bool has_interval = false;
  // Key of an end of the interval: "mae_from_cm" of "mae_cm".
  std::string key_of_end(const char* end) const;

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "key", self.key, "is_text", self.is_text, "has_interval", self.has_interval);
    if (!self.has_interval) return;
    f.written("from_key", self.key_of_end("from"));
    f.written("to_key", self.key_of_end("to"));
  }
};
inline TableColumn interval_column(std::string name, std::string key) {
  return {std::move(name), std::move(key), false, true};
}

// The name with its unit: that of the key where the name has none.
std::string header_of(const TableColumn& column);

// Letters, digits, '.', '_' and '-' stay, umlauts and accents are transliterated, anything else becomes '-'.
std::string file_name_from(std::string text);

// A table as data; renderings are made from it and never compute.
struct Table {
  // Placement in the report: with what answers the study's question, among the details, or as a file alone.
  enum class Placement : std::uint8_t { first, detail, file };
  std::string id;     // file_name_from(): a file name and a LaTeX label
  std::string title;  // what was measured
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableValue>> rows;
  std::vector<std::string> notes;   // one sentence each
  std::uint64_t first_rows = 0;     // what a reader sees before asking for more; 0: all
  std::uint64_t first_columns = 0;  // the same of columns
  Placement shown = Placement::detail;
  std::string printed = {};  // "table3": which numbers of the paper belong beside or are there
  std::string rows_in = {};  // the CSV file beside tables.json that has them, where `rows` is empty
  std::string about =
      {};  // on what it was measured, with every setting that changes a number; says "simulated"

  // "What (on what)".
  std::string whole_title() const { return about.empty() ? title : title + " (" + about + ")"; }
  static void fields(auto& self, auto&& f) {
    f("id", self.id, "title", self.title);
    if (f.has("about", !self.about.empty())) f("about", self.about);
    f("columns", self.columns, "rows", self.rows, "notes", self.notes, "first_rows", self.first_rows,
      "first_columns", self.first_columns, "shown", self.shown, "printed", self.printed, "rows_in",
      self.rows_in);
  }
  void check(const JsonPlace& place) const;
};

template <>
inline constexpr std::array words<TableValue::Mark>{
    "none", "best", "not_distinguished", "good", "bad", "contradiction", "unsure", "untested"};
template <>
inline constexpr std::array words<Table::Placement>{"first", "detail", "file"};

// RFC 4180 with full precision; NaN is an empty field.
std::string csv_of(const Table& table);

// Adds the sentences of a section of notes.md, where {name} stands for what `names` has.
void add_notes(Table& table, const std::string& section,
               const std::map<std::string, std::string>& names = {});

// Cells of tables: SI values in, printed units out. NaN stays NaN, which prints as a dash.
inline TableValue number_cell(int decimals, double value, double low = kNaN, double high = kNaN) {
  if (std::isnan(value)) low = high = value;
  return {value, decimals, {}, low, high};
}
inline TableValue cm_cell(double metres) { return TableValue::of(metres * kCentimetresPerMetre, 2); }
inline TableValue cm_cell(double metres, double low_m, double high_m) {
  return number_cell(2, metres * kCentimetresPerMetre, low_m * kCentimetresPerMetre,
                     high_m * kCentimetresPerMetre);
}
inline TableValue percent_cell(double share) { return TableValue::of(100.0 * share, 1); }
inline TableValue percent_cell(double share, double low, double high) {
  return number_cell(1, 100.0 * share, 100.0 * low, 100.0 * high);
}
inline TableValue count_cell(std::uint64_t n) { return TableValue::of(static_cast<double>(n), 0); }
inline TableValue no_cell() { return TableValue::of(kNaN, 0); }

inline double share_of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? kNaN : static_cast<double>(part) / static_cast<double>(whole);
}

// Content of a column: a member of the row or what a function gives for it; of three, value and interval.
template <class Show>
struct CellOf {
  Show show;
  bool is_text = false, has_interval = false;
};
template <class Show>
CellOf(Show, bool = false, bool = false) -> CellOf<Show>;  // clang 14 does not deduce aggregates
template <class Of>
auto as_text(Of of) {
  return CellOf{[=](const auto& row) { return TableValue::of(std::string(std::invoke(of, row))); }, true};
}
// `factor`: from SI to the unit that is printed.
template <class... Of>
auto as_number(int decimals, double factor, Of... of) {
  return CellOf{[=](const auto& row) {
                  return number_cell(decimals, factor * static_cast<double>(std::invoke(of, row))...);
                },
                false, sizeof...(of) == 3};
}
auto as_number(int decimals, auto... of) { return as_number(decimals, 1.0, of...); }
auto as_count(auto of) { return as_number(0, of); }
auto in_cm(auto... of) { return as_number(2, kCentimetresPerMetre, of...); }
auto in_mm(auto... of) { return as_number(2, 1.0 / kMetresPerMillimetre, of...); }
auto in_percent(auto... of) { return as_number(1, 100.0, of...); }
// Shows a part of the row as `cell` shows it.
template <class Part, class Show>
auto of(Part part, CellOf<Show> cell) {
  return CellOf{[=](const auto& row) { return cell.show(std::invoke(part, row)); }, cell.is_text,
                cell.has_interval};
}

// Columns of a table whose rows are the keys that their numbers share: a cell shows the number that has the
// row's keys and these, in the unit that tables print: cm, degrees, %, ms, m/s3 or steps.
TableValue shown_number(const Numbers& numbers, const NumberKey& key,
                        int decimals);  // NaN where there is none
inline auto interval_of(const Numbers& numbers, NumberKey more, int decimals = 2) {
  return CellOf{[&numbers, more = std::move(more), decimals](const NumberKey& row) {
                  return shown_number(numbers, row.with(more), decimals);
                },
                false, true};
}
inline auto value_of(const Numbers& numbers, NumberKey more, int decimals = 2) {
  return CellOf{[&numbers, more = std::move(more), decimals](const NumberKey& row) {
                  return TableValue::of(*shown_number(numbers, row.with(more), decimals).number, decimals);
                },
                false, false};
}
inline auto count_of(const Numbers& numbers, NumberKey more) {
  return CellOf{[&numbers, more = std::move(more)](const NumberKey& row) {
                  return count_cell(numbers.n(row.with(more)));
                },
                false, false};
}
// "converged 98.1 %, diverged 1.9 %", the most first: how often what the row asks for ended so, by the
// numbers of measure "status" of which `names` are the statistics.
std::string statuses_text(const Numbers& numbers, const NumberKey& row, std::span<const std::string> names);

// One column of a table whose rows are values of one kind.
template <class Row>
struct RowColumn {
  TableColumn column;
  std::function<TableValue(const Row&)> show;
  template <class Show>
  RowColumn(std::string name, std::string key, CellOf<Show> cell)
      : column{std::move(name), std::move(key), cell.is_text, cell.has_interval},
        show(std::move(cell.show)) {}
};

// A table's title: what was measured, and on which data.
struct TableTitle {
  TableTitle(const char* what) : text(what) {}
  TableTitle(std::string what, std::string on = {}) : text(std::move(what)), about(std::move(on)) {}
  std::string text, about;
};

// A table of `rows`, those alone that `wanted` holds for.
template <class Row>
Table table_of(
    std::string id, TableTitle title, const std::vector<Row>& rows,
    const std::vector<RowColumn<Row>>& columns,
    const std::function<bool(const Row&)>& wanted = [](const Row&) { return true; }) {
  Table table{std::move(id), std::move(title.text), {}, {}, {}};
  table.about = std::move(title.about);
  for (const RowColumn<Row>& column : columns) table.columns.push_back(column.column);
  for (const Row& row : rows) {
    if (!wanted(row)) continue;
    std::vector<TableValue>& cells = table.rows.emplace_back();
    for (const RowColumn<Row>& column : columns) cells.push_back(column.show(row));
  }
  return table;
}

// A row of which some cells are known, by the keys of their columns.
std::vector<TableValue> row_by_key(const Table& table,
                                   std::initializer_list<std::pair<const char*, TableValue>> cells);

// tables.json, beside a study's summary.json: what the study shows, as it is rendered. Sentences are marked
// up as in Markdown, with **bold** and `code`.
struct StoredTables {
  static constexpr const char* kFile = "tables.json";
  std::string title;                      // "table3 on paper campaign"
  std::string asked;                      // the study's question
  std::string about;                      // one sentence: how much of what, simulated or recorded
  std::vector<std::string> findings;      // what it found, one or two sentences each, the first ones first
  std::vector<std::string> on_the_paper;  // what it found beside what the paper prints
  std::vector<std::string> warnings;      // what a reader must know before believing a number
  std::vector<std::string> legend;        // one line a method of the first table
  std::vector<std::string> sentences;     // what else it says
  std::map<std::string, std::string> errata;  // what an erratum of the paper does here, by its id
  std::vector<Table> tables;                  // those that answer the study's question first

  static void fields(auto& self, auto&& f) {
    f.format("trilat.tables");
    f("title", self.title, "asked", self.asked, "about", self.about, "findings", self.findings,
      "on_the_paper", self.on_the_paper, "warnings", self.warnings, "legend", self.legend, "sentences",
      self.sentences, "errata", self.errata, "tables", self.tables);
  }
};
// The rows of tables that are shown as files become CSV files beside it.
void store_tables(const std::filesystem::path& folder, StoredTables shown);

}  // namespace trilat
