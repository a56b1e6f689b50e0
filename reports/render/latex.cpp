// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "reports/render/render.h"

namespace trilat {
namespace {

struct Sign {
  std::uint32_t code;
  const char* latex;
};
constexpr std::array kSigns{Sign{0x26, "\\&"},
                            Sign{0x25, "\\%"},
                            Sign{0x24, "\\$"},
                            Sign{0x23, "\\#"},
                            Sign{0x5f, "\\_"},
                            Sign{0x7b, "\\{"},
                            Sign{0x7d, "\\}"},
                            Sign{0x7e, "\\textasciitilde{}"},
                            Sign{0x5e, "\\textasciicircum{}"},
                            Sign{0x5c, "\\textbackslash{}"},
                            Sign{0x3c, "\\textless{}"},
                            Sign{0x3e, "\\textgreater{}"},
                            Sign{0xa0, "~"},
                            Sign{0xb0, "\\ensuremath{^\\circ}"},
                            Sign{0xb1, "\\ensuremath{\\pm}"},
                            Sign{0xb2, "\\textsuperscript{2}"},
                            Sign{0xb3, "\\textsuperscript{3}"},
                            Sign{0xb5, "\\ensuremath{\\mu}"},
                            Sign{0xb7, "\\ensuremath{\\cdot}"},
                            Sign{0xd7, "\\ensuremath{\\times}"},
                            Sign{0xf7, "\\ensuremath{\\div}"},
                            Sign{0x394, "\\ensuremath{\\Delta}"},
                            Sign{0x3bc, "\\ensuremath{\\mu}"},
                            Sign{0x3c0, "\\ensuremath{\\pi}"},
                            Sign{0x3c3, "\\ensuremath{\\sigma}"},
                            Sign{0x2013, "--"},
                            Sign{0x2014, "---"},
                            Sign{0x2018, "`"},
                            Sign{0x2019, "'"},
                            Sign{0x201c, "``"},
                            Sign{0x201d, "''"},
                            Sign{0x2026, "\\ldots{}"},
                            Sign{0x2192, "\\ensuremath{\\to}"},
                            Sign{0x2212, "\\ensuremath{-}"},
                            Sign{0x221a, "\\ensuremath{\\surd}"},
                            Sign{0x221e, "\\ensuremath{\\infty}"},
                            Sign{0x2248, "\\ensuremath{\\approx}"},
                            Sign{0x2264, "\\ensuremath{\\leq}"},
                            Sign{0x2265, "\\ensuremath{\\geq}"}};

// The character that begins at `place`, which moves behind it; U+FFFD for bytes that are none.
std::uint32_t next_character(const std::string& utf8, std::size_t& place) {
  const auto byte = [&](std::size_t at) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(utf8[at]));
  };
  const std::uint32_t first = byte(place++);
  if (first < 0x80) return first;
  const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : first >= 0xc0 ? 1 : 0;
  std::uint32_t code = first & (0x3fU >> more);
  for (int k = 0; k < more; ++k, ++place) {
    if (place >= utf8.size() || (byte(place) & 0xc0U) != 0x80U) return 0xfffd;
    code = code << 6U | (byte(place) & 0x3fU);
  }
  return more == 0 ? 0xfffd : code;
}

bool is_in_t1(std::uint32_t code) { return code < 0x7f || (code >= 0xc0 && code <= 0x17e); }

}  // namespace

std::string latex_text(const std::string& text) {
  const std::string line = one_line(text);
  std::string result;
  for (std::size_t place = 0; place < line.size();) {
    const std::size_t start = place;
    const std::uint32_t code = next_character(line, place);
    const Sign* known = nullptr;
    for (const Sign& sign : kSigns)
      if (sign.code == code) known = &sign;
    if (known)
      result += known->latex;
    else if (is_in_t1(code))
      result += code < 0x20 ? " " : line.substr(start, place - start);
    else
      result += fmt::format("[U+{:04X}]", code);
  }
  return result;
}

namespace {

constexpr std::size_t kMaxNotes = 3;    // the page has all
constexpr std::size_t kMaxRows = 45;    // of a page
constexpr double kOneColumn_mm = 69.0;  // of article in two columns; IEEE has 88
constexpr std::array kRooms_mm{kOneColumn_mm, 121.0, 143.0,
                               178.0};  // also article's text, and a page of two columns
constexpr double kBetween_mm = 1.4;     // columns, with \tabcolsep of 2 pt

// A size of letters, and how wide a character of it is on average.
struct LetterSize {
  const char* name;
  double letter_mm;
};
constexpr std::array kSizes{LetterSize{"footnotesize", 1.45}, LetterSize{"scriptsize", 1.38}};

// One cell as it is set, and how many characters wide it looks.
struct LatexCell {
  std::string text;
  std::size_t width = 0;
};

// "9.6 ± 0.4"; an interval that is not about the value keeps both ends.
LatexCell number_cell(const TableValue& value, bool has_interval) {
  if (value.number && !std::isfinite(*value.number)) return {"--", 1};
  const std::string number = printed(value);
  std::string text = latex_text(number);
  std::size_t width = width_of(number);
  if (value.mark == TableValue::Mark::best) text = "\\textbf{" + text + "}";
  if (value.mark == TableValue::Mark::not_distinguished) text += "\\ensuremath{{}^{\\approx}}";
  width += value.mark == TableValue::Mark::not_distinguished ? 1 : 0;
  if (!has_interval || !value.number || !std::isfinite(value.low) || !std::isfinite(value.high))
    return {text, width};
  const double half = 0.5 * (value.high - value.low), off = 0.5 * (value.high + value.low) - *value.number;
  const bool is_about = std::abs(off) <= 0.05 * half + 0.01 * std::pow(10.0, -value.decimals);
  const std::string interval =
      is_about ? printed(TableValue::of(half, value.decimals)) : printed_interval(value);
  return {text + (is_about ? "\\,\\ensuremath{\\pm}\\," + interval : " (" + interval + ")"),
          width + (is_about ? 2 : 3) + width_of(interval)};
}

// The first word of all that stands beside numbers in a row, as "paper"; empty where they have none in
// common.
std::string beside_name(const std::vector<TableValue>& row) {
  std::string name;
  for (const TableValue& value : row) {
    if (value.beside.empty()) continue;
    const std::string word = value.beside.substr(0, value.beside.find(' '));
    if (!name.empty() && word != name) return {};
    name = word;
  }
  return name;
}

// The rows of a table, the first so many columns with intervals; what stands beside numbers has a row of its
// own below.
std::vector<std::vector<LatexCell>> latex_rows(const Table& table, const std::vector<std::size_t>& order,
                                               std::size_t with_intervals) {
  const std::size_t count =
      table.first_rows > 0 ? std::min(table.first_rows, table.rows.size()) : table.rows.size();
  std::vector<std::vector<LatexCell>> rows(1);
  for (const std::size_t c : order) {
    const std::string header = header_of(table.columns[c]);
    rows[0].push_back({latex_text(header), width_of(header)});
  }
  for (std::size_t r = 0; r < count; ++r) {
    const std::string beside = beside_name(table.rows[r]);
    std::vector<LatexCell> row, below;
    for (const std::size_t c : order) {
      const TableValue& value = table.rows[r][c];
      row.push_back(number_cell(value, row.size() < with_intervals));
      const std::string text = beside.empty()
                                   ? value.beside
                                   : value.beside.substr(std::min(value.beside.size(), beside.size() + 1));
      below.push_back(c == order.front() ? LatexCell{"\\quad " + latex_text(beside), 2 + width_of(beside)}
                                         : LatexCell{latex_text(text), width_of(text)});
      if (beside.empty() && !value.beside.empty()) {
        row.back().text += "; " + latex_text(value.beside);
        row.back().width += 2 + width_of(value.beside);
      }
    }
    rows.push_back(std::move(row));
    if (!beside.empty()) rows.push_back(std::move(below));
  }
  return rows;
}

// The table in these rows; nothing where it is too wide for a page.
std::optional<std::string> tabular_of(const Table& table, const std::vector<std::size_t>& order,
                                      const std::vector<std::vector<LatexCell>>& rows) {
  std::size_t letters = 0;
  std::string alignment, body;
  for (std::size_t c = 0; c < order.size(); ++c) {
    std::size_t widest = 0;
    for (const auto& row : rows) widest = std::max(widest, row[c].width);
    letters += widest;
    alignment += table.columns[order[c]].is_text ? "l" : "r";
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < rows[r].size(); ++c) body += (c ? " & " : "") + rows[r][c].text;
    body += r == 0 ? " \\\\\n\\midrule\n" : " \\\\\n";
  }
  std::string notes;
  for (const std::string& note : std::span(table.notes).first(std::min(table.notes.size(), kMaxNotes)))
    notes += "\\par\\smallskip\\raggedright\\scriptsize " + latex_text(note) + "\n";
  for (const double room_mm : kRooms_mm)
    for (const LetterSize& size : kSizes) {
      const double width_mm =
          size.letter_mm * static_cast<double>(letters) + kBetween_mm * static_cast<double>(order.size());
      if (width_mm > room_mm) continue;
      const std::string kind = room_mm == kOneColumn_mm ? "table" : "table*";
      return fmt::format(
          "\\begin{{{0}}}\n\\centering\\{1}\\setlength{{\\tabcolsep}}{{2pt}}\n\\caption{{{2}}}\\label{{tab:{"
          "3}}}\n"
          "\\begin{{tabular}}{{{4}}}\n\\toprule\n{5}\\bottomrule\n\\end{{tabular}}\n{6}\\end{{{0}}}\n",
          kind, size.name, latex_text(table.whole_title()), table.id, alignment, body, notes);
    }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> latex_of(const Table& table) {
  if (table.first_rows == 0 && table.rows.size() > kMaxRows) return std::nullopt;
  const std::vector<std::size_t> order = shown_order(table);
  for (const std::size_t with_intervals : {order.size(), std::size_t{2}, std::size_t{0}})
    if (auto text = tabular_of(table, order, latex_rows(table, order, with_intervals))) return text;
  return std::nullopt;
}

}  // namespace trilat
