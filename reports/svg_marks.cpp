// SPDX-License-Identifier: MIT
#include "reports/svg_marks.h"

#include <array>

#include <fmt/format.h>

namespace trilat {
namespace {

// Okabe and Ito: told apart by colour-blind readers.
constexpr std::array<const char*, 6> kColours{"#0072b2", "#d55e00", "#009e73",
                                              "#cc79a7", "#e69f00", "#56b4e9"};

}  // namespace

std::string fill_of(std::size_t colour) {
  return fmt::format("fill=\"{}\" fill-opacity=\"0.65\"", kColours[colour % kColours.size()]);
}
std::string stroke_of(std::size_t colour, double width_px) {
  return fmt::format(
      "fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"",
      kColours[colour % kColours.size()], width_px);
}
std::string marker(std::size_t colour, double x_px, double y_px, double radius_px) {
  const double r = radius_px;
  switch (colour % 3) {
    case 0:
      return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:g}\"/>\n", x_px, y_px, r);
    case 1:
      return fmt::format("<path d=\"M{:.2f} {:.2f}l{:g} {:g}h{:g}z\"/>\n", x_px, y_px - 1.4 * r, 1.25 * r,
                         2.2 * r, -2.5 * r);
    default:
      return fmt::format("<path d=\"M{:.2f} {:.2f}h{:g}v{:g}h{:g}z\"/>\n", x_px - 0.9 * r, y_px - 0.9 * r,
                         1.8 * r, 1.8 * r, -1.8 * r);
  }
}

std::string xml_text(const std::string& text) {
  std::string result;
  for (char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

std::string text_at(double x_px, double y_px, const std::string& text, const std::string& attributes) {
  return fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\"{}{}>{}</text>\n", x_px, y_px,
                     attributes.empty() ? "" : " ", attributes, xml_text(text));
}

}  // namespace trilat
