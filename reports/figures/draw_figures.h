// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/figures/figure.h"

namespace trilat {

// The pictures of one figure.
struct DrawnFigure {
  Figure figure;
  std::string
      svg;  // with scripts of its own: legend entries toggle, coordinates follow the pointer, wheel zooms
  std::string pdf;
};

// Whether this machine can draw: gnuplot is there.
bool can_draw_figures();

// Draws all of them in one run of gnuplot. The same figures give the same bytes on one machine. InputError
// when gnuplot is not installed or refuses, with what it says.
std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures);

// What a page shows a dark picture by: the picture's address with this behind it.
inline constexpr const char* kDarkFragment = "#dark";

// A picture as gnuplot drew it, with two rules more: under kDarkFragment paper, ink and lines are those of a
// dark page while the colours of methods stay; and what belongs to an entry of the legend without being named
// in it (medians of boxes, intervals) goes when the entry is switched off.
std::string svg_with_rules(std::string svg);

}  // namespace trilat
