// SPDX-License-Identifier: MIT
#include "datasets/results/table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr std::pair<const char*, const char*> kUnits[] = {
    {"_percent", "%"}, {"_cm", "cm"},       {"_mm", "mm"},   {"_us", "us"},
    {"_ms", "ms"},     {"_deg", "degrees"}, {"_ppm", "ppm"}, {"_m_s3", "m/s³"}};

// Two bytes each.
constexpr std::pair<const char*, const char*> kLetters[] = {
    {"ä", "ae"}, {"ö", "oe"}, {"ü", "ue"}, {"Ä", "Ae"}, {"Ö", "Oe"}, {"Ü", "Ue"}, {"ß", "ss"}, {"à", "a"},
    {"á", "a"},  {"â", "a"},  {"ã", "a"},  {"å", "a"},  {"æ", "ae"}, {"ç", "c"},  {"è", "e"},  {"é", "e"},
    {"ê", "e"},  {"ë", "e"},  {"ì", "i"},  {"í", "i"},  {"î", "i"},  {"ï", "i"},  {"ñ", "n"},  {"ò", "o"},
    {"ó", "o"},  {"ô", "o"},  {"õ", "o"},  {"ø", "o"},  {"ù", "u"},  {"ú", "u"},  {"û", "u"},  {"É", "E"}};

}  // namespace

std::string header_of(const TableColumn& column) {
  if (column.is_text || column.name.find_first_of("(%") != std::string::npos) return column.name;
  for (const auto& [ending, unit] : kUnits)
    if (column.key.ends_with(ending)) return column.name + " (" + unit + ")";
  return column.name;
}

std::string TableColumn::key_of_end(const char* end) const {
  for (const auto& [ending, unit] : kUnits)
    if (key.ends_with(ending))
      return key.substr(0, key.size() - std::string(ending).size()) + "_" + end + ending;
  return key + "_" + end;
}

std::vector<TableValue> row_by_key(const Table& table,
                                   std::initializer_list<std::pair<const char*, TableValue>> cells) {
  std::vector<TableValue> row(table.columns.size(), no_cell());
  for (const auto& [key, cell] : cells)
    row.at(static_cast<std::size_t>(std::ranges::find(table.columns, key, &TableColumn::key) -
                                    table.columns.begin())) = cell;
  return row;
}

std::string statuses_text(const Numbers& numbers, const NumberKey& row, std::span<const std::string> names) {
  std::vector<std::pair<std::uint64_t, std::string>> found;
  for (const std::string& name : names)
    if (const std::uint64_t n = numbers.n(row.with({.measure = "status", .statistic = name})); n > 0)
      found.emplace_back(n, name);
  std::ranges::stable_sort(found, std::greater{}, [](const auto& one) { return one.first; });
  const std::uint64_t asked = numbers.n(row.with({.measure = "answered", .statistic = "share"}));
  std::string text;
  for (const auto& [n, name] : found) {
    const double percent = 100.0 * share_of(n, asked);
    const std::string number = percent < 0.05                 ? "<0.1"
                               : percent > 99.95 && n < asked ? ">99.9"
                                                              : fmt::format("{:.1f}", percent);
    text += (text.empty() ? "" : ", ") + name + " " + number + " %";
  }
  return text;
}

TableValue shown_number(const Numbers& numbers, const NumberKey& key, int decimals) {
  const Number* number = numbers.find(key);
  const std::string unit = unit_of(key);
  const double factor = unit == "m"     ? kCentimetresPerMetre
                        : unit == "1"   ? 100.0
                        : unit == "s"   ? 1e3
                        : unit == "rad" ? kDegreesPerRad
                                        : 1.0;
  if (!number) return number_cell(decimals, kNaN);
  return number_cell(decimals, factor * number->value, factor * number->low, factor * number->high);
}

void Table::check(const JsonPlace& place) const {
  for (const std::vector<TableValue>& row : rows)
    if (row.size() != columns.size()) place.at("rows").refuse("must have a cell for each column");
}

std::string csv_of(const Table& table) {
  std::string text;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const TableColumn& column = table.columns[c];
    text += (c ? "," : "") + csv_field(column.key);
    if (column.has_interval)
      for (const char* end : {"from", "to"}) text += "," + csv_field(column.key_of_end(end));
  }
  text += "\r\n";
  const auto number = [](double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : std::string();
  };
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c > 0) text += ',';
      text += row[c].number ? number(*row[c].number) : csv_field(row[c].text);
      if (table.columns[c].has_interval) text += "," + number(row[c].low) + "," + number(row[c].high);
    }
    text += "\r\n";
  }
  return text;
}

void store_tables(const std::filesystem::path& folder, StoredTables shown) {
  for (Table& table : shown.tables) {
    if (table.shown != Table::Placement::file) continue;
    table.rows_in = table.id + ".csv";
    write_file(folder / table.rows_in, csv_of(table));
    table.rows.clear();
  }
  write_json_file(folder, shown, -1);
}

std::string file_name_from(std::string text) {
  for (const auto& [letter, plain] : kLetters)
    for (std::size_t at = 0; (at = text.find(letter, at)) != std::string::npos;) text.replace(at, 2, plain);
  const auto is_kept = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  std::ranges::replace_if(
      text, [&](char c) { return !is_kept(c); }, '-');
  return text;
}

}  // namespace trilat
