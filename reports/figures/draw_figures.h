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

// Draws all of them in one run of gnuplot. The same figures give the same bytes on one machine. InputError
// when gnuplot is not installed or refuses, with what it says.
std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures);

// A picture as gnuplot drew it, with one rule more: what belongs to an entry of the legend without being
// named in it (medians of boxes, intervals) goes when the entry is switched off.
std::string svg_with_rules(std::string svg);

}  // namespace trilat
