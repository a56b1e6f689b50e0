// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace trilat {

// What a figure is drawn with. Colours are numbered and tell colour-blind readers apart; beyond the last they
// begin again.
inline constexpr const char* kBandFill = "fill=\"#eaeaea\"";
inline constexpr const char* kReferenceStroke =
    "fill=\"none\" stroke=\"#222222\" stroke-width=\"1.4\" stroke-dasharray=\"7 4\"";
std::string fill_of(std::size_t colour);
std::string stroke_of(std::size_t colour, double width_px);

// A dot about (x, y), of another shape for every third colour, so that a print without colours can be read.
std::string marker(std::size_t colour, double x_px, double y_px, double radius_px);

// Escaped for XML; control characters become spaces.
std::string xml_text(const std::string& text);
std::string text_at(double x_px, double y_px, const std::string& text, const std::string& attributes = {});

}  // namespace trilat
