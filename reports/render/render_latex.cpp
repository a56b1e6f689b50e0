// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include <fmt/format.h>

#include "reports/render/latex_text.h"
#include "reports/render/render.h"
#include "reports/render/text_lines.h"

namespace trilat {
namespace {

constexpr double kLine_pt = 750.0;   // of the landscape page below
constexpr std::size_t kLong = 24;    // characters of a text that is broken into lines
constexpr std::size_t kFewest = 12;  // that such a column has room for

constexpr std::size_t kShortHead = 12;  // characters that are not broken

struct Size {
  const char* name;
  double character_pt;  // on average
  double gap_pt;        // on either side of a column
};
constexpr std::array kSizes{Size{"footnotesize", 4.4, 6.0}, Size{"scriptsize", 3.9, 2.5},
                            Size{"tiny", 3.1, 1.2}};

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) longest = std::max(longest, width_of(word));
  return longest;
}

// One column as it is to be set.
struct Column {
  std::vector<std::string> head;  // lines
  std::size_t width = 0;          // characters, when it is not broken
  bool is_text = false, broken = false;
  double share = 0.0;  // of the line, when it is
};

Column column_of(const Table& table, std::size_t c) {
  Column column;
  column.is_text = table.columns[c].is_text;
  for (const auto& row : table.rows) column.width = std::max(column.width, width_of(printed(row[c])));
  const std::string head = header_of(table.columns[c]);
  column.broken = column.is_text && column.width > kLong;
  column.head = lines_of(head, std::max({column.width, longest_word(head), kShortHead}));
  for (const std::string& line : column.head) column.width = std::max(column.width, width_of(line));
  return column;
}

// The points that are left for columns that are broken into lines.
double left_for_broken(const std::vector<Column>& columns, const Size& size) {
  double left = kLine_pt - 2.0 * size.gap_pt * static_cast<double>(columns.size());
  for (const Column& c : columns)
    if (!c.broken) left -= size.character_pt * static_cast<double>(c.width);
  return left;
}

// The largest letters that the table fits on the line with.
const Size& size_of(const std::vector<Column>& columns) {
  const auto broken = static_cast<double>(
      std::count_if(columns.begin(), columns.end(), [](const Column& c) { return c.broken; }));
  for (const Size& size : kSizes)
    if (left_for_broken(columns, size) >= broken * static_cast<double>(kFewest) * size.character_pt)
      return size;
  return kSizes.back();
}

// Long texts share what is left, the longer ones more of it, none more than it needs.
void share_line(std::vector<Column>& columns, const Size& size) {
  double sum = 0.0;
  for (const Column& c : columns)
    if (c.broken) sum += std::sqrt(static_cast<double>(c.width));
  const double left = std::max(0.1 * kLine_pt, left_for_broken(columns, size));
  for (Column& c : columns) {
    if (!c.broken) continue;
    const double width = static_cast<double>(c.width);
    c.share = std::min(left * std::sqrt(width) / sum, width * size.character_pt * 1.1) / kLine_pt;
  }
}

std::string head_of(const Column& column) {
  if (column.broken || column.head.size() == 1) {
    std::string text;
    for (const std::string& line : column.head) text += (text.empty() ? "" : " ") + latex_text(line);
    return text;
  }
  std::string lines;
  for (const std::string& line : column.head) lines += (lines.empty() ? "" : "\\\\") + latex_text(line);
  return std::string("\\begin{tabular}[b]{@{}") + (column.is_text ? "l" : "r") + "@{}}" + lines +
         "\\end{tabular}";
}

std::string cell_of(const TableValue& value, const Column& column) {
  if (value.number && !std::isfinite(*value.number)) return "--";
  return column.broken ? latex_breakable(printed(value)) : latex_text(printed(value));
}

}  // namespace

std::string latex_of(const Table& table) {
  std::vector<Column> columns;
  for (std::size_t c = 0; c < table.columns.size(); ++c) columns.push_back(column_of(table, c));
  const Size& size = size_of(columns);
  share_line(columns, size);
  std::string alignment, head;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    alignment += columns[c].broken    ? fmt::format("p{{{:.3f}\\linewidth}}", columns[c].share)
                 : columns[c].is_text ? "l"
                                      : "r";
    head += (c ? " & " : "") + head_of(columns[c]);
  }
  head = "\\toprule\n" + head + " \\\\\n\\midrule\n";
  std::string text =
      fmt::format("{{\\{}\\setlength{{\\tabcolsep}}{{{:g}pt}}\\sloppy\n", size.name, size.gap_pt);
  text += "\\begin{longtable}{" + alignment + "}\n\\caption{" + latex_breakable(table.title) +
          "}\\label{tab:" + table.id + "}\\\\\n" + head + "\\endfirsthead\n" + head +
          "\\endhead\n\\bottomrule\n\\endlastfoot\n";
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) text += (c ? " & " : "") + cell_of(row[c], columns[c]);
    text += " \\\\\n";
  }
  text += "\\end{longtable}\n";
  for (const std::string& note : table.notes) text += "\\noindent " + latex_breakable(note) + "\\par\n";
  return text + "}\n";
}

std::string latex_document(const std::vector<Table>& tables, const std::vector<std::string>& remarks) {
  std::string text = R"(\documentclass{article}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage{booktabs,longtable}
\usepackage[a4paper,landscape,margin=15mm]{geometry}
\begin{document}
)";
  for (const Table& table : tables) text += latex_of(table) + "\\clearpage\n";
  for (const std::string& remark : remarks) text += "\\noindent " + latex_breakable(remark) + "\\par\n";
  return text + "\\end{document}\n";
}

}  // namespace trilat
