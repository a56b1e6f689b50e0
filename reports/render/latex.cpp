// SPDX-License-Identifier: MIT
#include "reports/render/latex.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>

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

constexpr std::array kDigits{"Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine"};
constexpr std::array kAgain{"Second", "Third", "Fourth", "Fifth", "Sixth", "Seventh", "Eighth", "Ninth"};

bool is_command_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string name_of_row(const std::vector<TableValue>& row, std::size_t cells) {
  std::string name;
  for (std::size_t c = 0; c < cells; ++c) {
    const TableValue& value = row[c];
    name += macro_words(value.number && *value.number < 0.0 ? "minus " + printed(value) : printed(value));
  }
  return name;
}

// Texts and chosen numbers at the front name a row; what was measured never does: it changes from run to run,
// and the names with it.
std::size_t naming_columns(const Table& table) {
  const auto names = [](const TableColumn& c) { return c.is_text || c.is_key; };
  return static_cast<std::size_t>(std::ranges::find_if_not(table.columns, names) - table.columns.begin());
}

// Names of all rows, which differ.
std::vector<std::string> row_names(const Table& table) {
  for (std::size_t cells = 1; cells <= naming_columns(table); ++cells) {
    std::vector<std::string> names;
    for (const auto& row : table.rows) names.push_back(name_of_row(row, cells));
    const std::set<std::string> distinct(names.begin(), names.end());
    if (distinct.size() == names.size() && !distinct.contains("")) return names;
  }
  std::vector<std::string> names;
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    names.push_back(macro_words("row " + std::to_string(r + 1)));
  return names;
}

class Numbers {
 public:
  void add(std::string name, const std::string& value) {
    const std::size_t before = seen_[name]++;
    if (before > 0)
      name +=
          before <= kAgain.size() ? kAgain[before - 1] : macro_words("copy " + std::to_string(before + 1));
    if (before > 0 && seen_[name]++ > 0) return add(name + "Again", value);
    all_.push_back({"trilat" + name, value});
  }
  std::vector<ArticleNumber> take() { return std::move(all_); }

 private:
  std::map<std::string, std::size_t> seen_;
  std::vector<ArticleNumber> all_;
};

std::string value_of(const TableValue& value) {
  return value.number && std::isfinite(*value.number) ? printed(value) : "--";
}

void add_row(Numbers& numbers, const Table& table, const std::vector<TableValue>& row,
             const std::string& name) {
  for (std::size_t c = 0; c < row.size(); ++c) {
    const std::string& key = table.columns[c].key;
    if (table.columns[c].is_text || !row[c].number) continue;
    numbers.add(name + macro_words(key), value_of(row[c]));
    if (!table.columns[c].has_interval) continue;
    const std::string interval = printed_interval(row[c]);
    numbers.add(name + macro_words(key) + "Interval", interval.empty() ? "--" : interval);
  }
}

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

std::string latex_of(const TableValue& value) {
  if (value.number && !std::isfinite(*value.number)) return "--";
  std::string text = latex_text(printed(value));
  if (value.mark == TableValue::Mark::best) text = "\\textbf{" + text + "}";
  if (value.mark == TableValue::Mark::like_best) text += "\\ensuremath{{}^{\\approx}}";
  if (const std::string interval = printed_interval(value); !interval.empty())
    text += " (" + latex_text(interval) + ")";
  return value.beside.empty() ? text : text + "; " + latex_text(value.beside);
}

}  // namespace

std::string latex_of(const Table& table) {
  constexpr std::size_t kLong = 24;  // characters of a text that is broken into lines
  std::string alignment, head;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    std::size_t width = 0;
    for (const auto& row : table.rows) width = std::max(width, width_of(printed(row[c])));
    const bool is_text = table.columns[c].is_text;
    alignment += is_text && width > kLong ? "p{45mm}" : is_text ? "l" : "r";
    head += (c ? " & " : "") + latex_text(header_of(table.columns[c]));
  }
  head = "\\toprule\n" + head + " \\\\\n\\midrule\n";
  std::string text = "{\\sloppy\n\\begin{longtable}{" + alignment + "}\n\\caption{" +
                     latex_text(table.title) + "}\\label{tab:" + table.id + "}\\\\\n" + head +
                     "\\endfirsthead\n" + head + "\\endhead\n\\bottomrule\n\\endlastfoot\n";
  for (const auto& row : table.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) text += (c ? " & " : "") + latex_of(row[c]);
    text += " \\\\\n";
  }
  text += "\\end{longtable}\n";
  for (const std::string& note : table.notes) text += "\\noindent " + latex_text(note) + "\\par\n";
  return text + "}\n";
}

std::string macro_words(const std::string& text) {
  std::string name;
  bool starts = true;
  for (char c : text) {
    if (c >= '0' && c <= '9') {
      name += kDigits[static_cast<std::size_t>(c - '0')];
      starts = true;
    } else if (is_command_letter(c)) {
      name += starts ? upper(c) : c;
      starts = false;
    } else {
      starts = true;
    }
  }
  return name;
}

std::vector<ArticleNumber> article_numbers(const std::vector<Table>& tables) {
  Numbers numbers;
  for (const Table& table : tables) {
    const std::vector<std::string> names = row_names(table);
    for (std::size_t r = 0; r < table.rows.size(); ++r)
      add_row(numbers, table, table.rows[r], macro_words(table.id) + names[r]);
  }
  return numbers.take();
}

std::string latex_of(const std::vector<ArticleNumber>& numbers) {
  std::string text =
      "% The numbers of the report's main tables as macros, so that prose never goes stale: \\input{numbers} "
      "before it is used.\n"
      "% \\trilat + table + row + column, digits written out; ...Interval is the 95 % interval of the number "
      "before it.\n"
      "% A macro is followed by {} where a space is to stay.\n";
  for (const ArticleNumber& number : numbers)
    text += "\\newcommand{\\" + number.name + "}{" + number.value + "}\n";
  return text;
}

}  // namespace trilat
