// SPDX-License-Identifier: MIT
#include "reports/render/latex.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

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

}  // namespace trilat
