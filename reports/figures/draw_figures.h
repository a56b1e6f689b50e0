// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/figure.h"

namespace trilat {

// The pictures of one figure; without gnuplot there are none.
struct DrawnFigure {
  Figure figure;
  std::string svg, pdf;
  std::string narrow_svg{};  // for a narrow screen: its panels below each other
  bool in_headline = false;  // on the first screen of a report
  bool is_drawn() const { return !svg.empty(); }
};

// Draws all of them in one run of gnuplot; none where it is not installed. The same figures give the same
// bytes on one machine. InputError when gnuplot refuses, with what it says.
std::vector<DrawnFigure> draw_figures(std::vector<Figure> figures);

// Figure with its panels below each other.
Figure narrow_figure(Figure figure);

struct FigureSize {
  double width_mm = 0.0, height_mm = 0.0;
};
FigureSize size_of(const Figure& figure);

// The gnuplot commands that draw one figure with its numbers in them, onto whatever terminal is set.
std::string gnuplot_script(const Figure& figure);

}  // namespace trilat
