// SPDX-License-Identifier: MIT
#include "reports/render/render.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "datasets/base/text_output.h"
#include "datasets/base/words.h"

namespace trilat {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string one_line(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  return text;
}

std::vector<std::string> lines_of(const std::string& text, std::size_t width) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.empty() && width_of(lines.back()) + 1 + width_of(word) <= width)
      lines.back() += ' ' + word;
    else
      lines.push_back(word);
  }
  if (lines.empty()) lines.emplace_back();
  return lines;
}

namespace {

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string space(width - std::min(width, width_of(text)), ' ');
  return left ? text + space : space + text;
}

bool is_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) >= 0x80;
}

// Escapes what Markdown would take for markup or HTML. '_' and '&' mean something at the edge of a
// word only.
std::string markdown_cell(const std::string& text) {
  const std::string line = one_line(text);
  std::string result;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    const bool inside = i > 0 && i + 1 < line.size() && is_word(line[i - 1]) && is_word(line[i + 1]);
    const bool entity = c == '&' && i + 1 < line.size() && (is_word(line[i + 1]) || line[i + 1] == '#');
    if (std::string_view("|\\`*<[]").find(c) != std::string_view::npos || (c == '_' && !inside) || entity)
      result += '\\';
    result += c;
  }
  return result;
}

std::string printed(double number, int decimals) {
  if (!std::isfinite(number)) return "–";
  if (decimals < 0) return fmt::format("{:g}", number);
  constexpr int kMaxDecimals = 17;  // a file may say any number
  const std::string text = fmt::format("{:.{}f}", number, std::min(decimals, kMaxDecimals));
  // what rounds to nothing has no sign
  return text[0] == '-' && text.find_first_of("123456789") == std::string::npos ? text.substr(1) : text;
}

}  // namespace

std::string printed(const TableValue& value) {
  return value.number ? printed(*value.number, value.decimals) : value.text;
}

std::vector<std::size_t> shown_order(const Table& table) {
  std::vector<std::size_t> order(table.columns.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto names = std::ranges::find_if(order, [&](std::size_t c) { return !table.columns[c].is_text; });
  std::stable_partition(names, order.end(),
                        [&](std::size_t c) { return table.columns[c].key.starts_with("average_"); });
  return order;
}

std::string printed_interval(const TableValue& value) {
  if (!std::isfinite(value.low) || !std::isfinite(value.high)) return {};
  return printed(value.low, value.decimals) + " to " + printed(value.high, value.decimals);
}

namespace {

std::string markdown_of(const TableValue& value) {
  std::string text = markdown_cell(printed(value));
  if (value.mark == TableValue::Mark::best) text = "**" + text + "**";
  if (value.mark == TableValue::Mark::not_distinguished) text += " ≈";
  if (const std::string interval = printed_interval(value); !interval.empty()) text += " (" + interval + ")";
  return value.beside.empty() ? text : text + "; " + markdown_cell(value.beside);
}

}  // namespace

std::string markdown_of(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = std::max<std::size_t>(3, width_of(header_of(table.columns[c])));
    for (const auto& row : table.rows) width = std::max(width, width_of(markdown_of(row[c])));
    widths.push_back(width);
  }
  std::string text = "**" + one_line(table.whole_title()) + "**\n\n|", rule = "|";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const bool left = table.columns[c].is_text;
    text += ' ' + padded(header_of(table.columns[c]), widths[c], left) + " |";
    rule += ' ' + std::string(widths[c] - 1, '-') + (left ? "-" : ":") + " |";
  }
  text += '\n' + rule + '\n';
  for (const auto& row : table.rows) {
    text += '|';
    for (std::size_t c = 0; c < row.size(); ++c)
      text += ' ' + padded(markdown_of(row[c]), widths[c], table.columns[c].is_text) + " |";
    text += '\n';
  }
  for (const std::string& note : table.notes) text += "\n- " + one_line(note);
  return text + (table.notes.empty() ? "" : "\n");
}

namespace {

constexpr std::size_t kEnds = 2;  // the last columns sum a table up, and stay on a narrow terminal

std::string terminal_cell(const TableValue& value) {
  std::string text = printed(value);
  if (value.mark == TableValue::Mark::best) text += " *";
  if (value.mark == TableValue::Mark::not_distinguished) text += " ≈";
  if (const std::string interval = printed_interval(value); !interval.empty()) text += " (" + interval + ")";
  return one_line(value.beside.empty() ? text : text + "; " + value.beside);
}

}  // namespace

std::string terminal_text(const Table& table, std::size_t width) {
  const std::size_t rows =
      table.first_rows > 0 ? std::min(table.first_rows, table.rows.size()) : table.rows.size();
  std::vector<std::vector<std::string>> columns;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::vector<std::string> cells{header_of(table.columns[c])};
    for (std::size_t r = 0; r < rows; ++r) cells.push_back(terminal_cell(table.rows[r][c]));
    std::size_t widest = 0;
    for (const std::string& cell : cells) widest = std::max(widest, width_of(cell));
    for (std::string& cell : cells) cell = padded(cell, widest, table.columns[c].is_text);
    columns.push_back(std::move(cells));
  }
  const auto width_of_all = [&] {
    std::size_t used = 0;
    for (const auto& cells : columns) used += width_of(cells[0]) + 2;
    return used - 2;
  };
  while (columns.size() > kEnds + 2 && width_of_all() > width) columns.erase(columns.end() - kEnds - 1);
  std::vector<std::string> lines(rows + 1);
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (std::size_t r = 0; r <= rows; ++r) lines[r] += (c == 0 ? "" : "  ") + columns[c][r];
  std::string text;
  for (const std::string& line : lines_of(one_line(table.whole_title()), width)) text += line + '\n';
  for (const std::string& line : lines) text += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  const auto is_marked = [](const TableValue& value) {
    return value.mark != TableValue::Mark::none && !value.is_verdict();
  };
  if (std::ranges::any_of(table.rows, [&](const auto& row) { return std::ranges::any_of(row, is_marked); }))
    text += "*: the least error; ≈: cannot be distinguished from it on the samples that both answer\n";
  if (const std::size_t left = table.rows.size() - rows; left > 0)
    text += "the report has " + counted(left, "more row") + "\n";
  if (const std::size_t left = table.columns.size() - columns.size(); left > 0)
    text += "the report has " + counted(left, "more column") + "\n";
  return text;
}

}  // namespace trilat
