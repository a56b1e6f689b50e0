// SPDX-License-Identifier: MIT
#include "reports/render/latex_text.h"

#include <array>
#include <cstdint>
#include <sstream>

#include <fmt/format.h>

#include "reports/render/text_lines.h"

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

std::string latex_breakable(const std::string& text) {
  constexpr std::size_t kLongWord = 12;
  std::istringstream words(one_line(text));
  std::string result;
  for (std::string word; words >> word;) {
    if (!result.empty()) result += ' ';
    if (width_of(word) <= kLongWord) {
      result += latex_text(word);
      continue;
    }
    std::string part;
    for (const char c : word) {
      part += c;
      if (std::string_view("/_-,;:=.").find(c) == std::string_view::npos) continue;
      result += latex_text(part) + "\\allowbreak{}";
      part.clear();
    }
    result += latex_text(part);
  }
  return result;
}

}  // namespace trilat
