// SPDX-License-Identifier: MIT
#include "reports/render.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trilat {
namespace {

// Characters of a text, not bytes: UTF-8 continuation bytes do not count.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string space(width - std::min(width, width_of(text)), ' ');
  return left ? text + space : space + text;
}

// Texts from outside may hold line breaks, which would end a row or a paragraph.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  return text;
}

std::string markdown_cell(const std::string& text) {
  std::string result;
  for (char c : one_line(text)) result += c == '|' ? "\\|" : std::string(1, c);
  return result;
}

std::string latex_text(const std::string& text) {
  std::string result;
  for (char c : one_line(text)) {
    switch (c) {
      case '&':
      case '%':
      case '$':
      case '#':
      case '_':
      case '{':
      case '}':
        result += std::string("\\") + c;
        break;
      case '~':
        result += "\\textasciitilde{}";
        break;
      case '^':
        result += "\\textasciicircum{}";
        break;
      case '\\':
        result += "\\textbackslash{}";
        break;
      case '<':
        result += "\\textless{}";
        break;
      case '>':
        result += "\\textgreater{}";
        break;
      default:
        result += c;
    }
  }
  return result;
}

}  // namespace

std::string printed(const TableValue& value) {
  if (!value.number) return value.text;
  if (!std::isfinite(*value.number)) return "–";
  if (value.decimals < 0) return fmt::format("{:g}", *value.number);
  const std::string text = fmt::format("{:.{}f}", *value.number, value.decimals);
  // what rounds to nothing has no sign
  return text[0] == '-' && text.find_first_of("123456789") == std::string::npos ? text.substr(1) : text;
}

std::string markdown_of(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = std::max<std::size_t>(3, width_of(header_of(table.columns[c])));
    for (const auto& row : table.rows) width = std::max(width, width_of(markdown_cell(printed(row[c]))));
    widths.push_back(width);
  }
  std::string text = "**" + one_line(table.title) + "**\n\n|", rule = "|";
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const bool left = table.columns[c].is_text;
    text += ' ' + padded(header_of(table.columns[c]), widths[c], left) + " |";
    rule += ' ' + std::string(widths[c] - 1, '-') + (left ? "-" : ":") + " |";
  }
  text += '\n' + rule + '\n';
  for (const auto& row : table.rows) {
    text += '|';
    for (std::size_t c = 0; c < row.size(); ++c)
      text += ' ' + padded(markdown_cell(printed(row[c])), widths[c], table.columns[c].is_text) + " |";
    text += '\n';
  }
  for (const std::string& note : table.notes) text += "\n- " + one_line(note);
  return text + (table.notes.empty() ? "" : "\n");
}

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

std::string csv_of(const Table& table) {
  std::string text;
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    text += (c ? "," : "") + csv_field(table.columns[c].key);
  text += "\r\n";
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (c > 0) text += ',';
      if (!row[c].number)
        text += csv_field(row[c].text);
      else if (std::isfinite(*row[c].number))
        text += fmt::format("{}", *row[c].number);
    }
    text += "\r\n";
  }
  return text;
}

namespace {

constexpr std::size_t kLong = 24;       // characters of a text that does not fit on one line beside others
constexpr double kOfCharacter = 0.007;  // of the line, for one of a column that is not broken

// How wide each text column is to be that is broken into lines, as a share of the line; 0 where it is not. Of
// a table of numbers that is the last column, of a table of texts every long one: they share the line, the
// longer ones more of it.
std::vector<double> wrapped_shares(const Table& table) {
  const std::size_t columns = table.columns.size();
  std::vector<double> share(columns, 0.0), weight(columns, 0.0);
  const auto texts = static_cast<std::size_t>(
      std::count_if(table.columns.begin(), table.columns.end(), [](const auto& c) { return c.is_text; }));
  if (2 * texts <= columns) {
    if (table.columns.back().is_text) share.back() = columns > 9 ? 0.15 : 0.25;
    return share;
  }
  double sum = 0.0, left = 0.92;
  for (std::size_t c = 0; c < columns; ++c) {
    std::size_t longest = width_of(header_of(table.columns[c]));
    for (const auto& row : table.rows) longest = std::max(longest, width_of(printed(row[c])));
    if (table.columns[c].is_text && longest > kLong)
      sum += weight[c] = std::sqrt(static_cast<double>(longest));
    else
      left -= kOfCharacter * static_cast<double>(longest);
  }
  for (std::size_t c = 0; c < columns; ++c)
    if (weight[c] > 0.0) share[c] = std::max(0.05, left * weight[c] / sum);
  return share;
}

}  // namespace

std::string latex_of(const Table& table) {
  const bool wide = table.columns.size() > 9;
  const std::vector<double> share = wrapped_shares(table);
  std::string alignment, head;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    alignment += share[c] > 0.0             ? fmt::format("p{{{:.3f}\\linewidth}}", share[c])
                 : table.columns[c].is_text ? "l"
                                            : "r";
    head += (c ? " & " : "") + latex_text(header_of(table.columns[c]));
  }
  head = "\\toprule\n" + head + " \\\\\n\\midrule\n";
  const bool widest = table.columns.size() > 16;
  std::string text = widest ? "{\\tiny\\setlength{\\tabcolsep}{1.5pt}\n"
                     : wide ? "{\\scriptsize\\setlength{\\tabcolsep}{2pt}\n"
                            : "{\\footnotesize\n";
  text += "\\begin{longtable}{" + alignment + "}\n\\caption{" + latex_text(table.title) +
          "}\\label{tab:" + table.id + "}\\\\\n" + head + "\\endfirsthead\n" + head +
          "\\endhead\n\\bottomrule\n\\endlastfoot\n";
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool dash = row[c].number && !std::isfinite(*row[c].number);
      text += (c ? " & " : "") + (dash ? std::string("--") : latex_text(printed(row[c])));
    }
    text += " \\\\\n";
  }
  text += "\\end{longtable}\n";
  for (const std::string& note : table.notes) text += "\\noindent " + latex_text(note) + "\\par\n";
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
  for (const std::string& remark : remarks) text += "\\noindent " + latex_text(remark) + "\\par\n";
  return text + "\\end{document}\n";
}

}  // namespace trilat
