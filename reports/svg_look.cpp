// SPDX-License-Identifier: MIT
#include "reports/svg_look.h"

#include <array>

#include <fmt/format.h>

namespace trilat {
namespace {

struct Neutral {
  int grey;  // of 255, as gnuplot is told
  const char* dark;
};
constexpr std::array kNeutrals{Neutral{0, "#e4e6ea"}, Neutral{34, "#d4d7dd"}, Neutral{51, "#b9bec8"},
                               Neutral{208, "#363b44"}, Neutral{228, "#2a2f37"}};

// gnuplot writes one colour in several ways.
std::string dark_rules() {
  std::string rules = "svg:target{color-scheme:dark}";
  const auto rule = [&](const char* attribute, const std::string& value, const char* dark) {
    rules += fmt::format("svg:target [{0}=\"{1}\"]{{{0}:{2}}}", attribute, value, dark);
  };
  for (const char* attribute : {"stroke", "fill", "color"}) {
    for (const Neutral& n : kNeutrals) {
      rule(attribute, fmt::format("rgb({0:3}, {0:3}, {0:3})", n.grey), n.dark);
      rule(attribute, fmt::format("rgb({0},{0},{0})", n.grey), n.dark);
    }
    rule(attribute, "black", kNeutrals[0].dark);
  }
  rule("fill", "#ffffff", "#15171b");
  rule("fill", "white", "#15171b");
  rules += "svg:target #coord_text,svg:target #hypertext{fill:#e4e6ea}";
  rules += "svg:target>rect[fill=\"#ffffff\"]{stroke:#15171b}";
  return rules;
}

void mark_companions(std::string& svg) {
  constexpr std::string_view kPlot = "_plot_", kTitle = "\" ><title>", kEnd = "</title>";
  for (std::size_t at = svg.find(kTitle); at != std::string::npos; at = svg.find(kTitle, at + 1)) {
    const std::size_t quote = svg.rfind('"', at - 1), text = at + kTitle.size(), end = svg.find(kEnd, text);
    if (quote == std::string::npos || end == std::string::npos) return;
    const std::string id = svg.substr(quote + 1, at - quote - 1);
    if (id.find(kPlot) == std::string::npos || svg.substr(text, end - text) != id) continue;
    svg.replace(at, end + kEnd.size() - at, "\" class=\"companion\">");
  }
}

}  // namespace

std::string svg_with_rules(std::string svg) {
  mark_companions(svg);
  const std::size_t root = svg.find("<svg");
  const std::size_t open_end = root == std::string::npos ? root : svg.find("\n>", root);
  if (open_end == std::string::npos) return svg;
  const std::string style = "\n<style>g[visibility=\"hidden\"]+g.companion{visibility:hidden}@media screen{" +
                            dark_rules() + "}</style>";
  svg.insert(open_end + 2, style);
  svg.insert(root + 4, " id=\"dark\"");
  return svg;
}

}  // namespace trilat
