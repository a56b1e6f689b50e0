// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/figure.h"

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

}  // namespace trilat
