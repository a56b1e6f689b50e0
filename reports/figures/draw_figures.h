// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/figures/figure.h"

namespace trilat {

// The pictures of one figure.
struct DrawnFigure {
  Figure figure;
  std::string svg, pdf;
};

// Draws all of them in one run of gnuplot. The same figures give the same bytes on one machine. InputError
// when gnuplot is not installed or refuses, with what it says.
std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures);

}  // namespace trilat
