// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "reports/figures/figure.h"

namespace trilat {

struct FigureSize {
  double width_mm = 0.0, height_mm = 0.0;
};
FigureSize size_of(const Figure& figure);

// The gnuplot commands that draw one figure with its numbers in them, onto whatever terminal is set.
std::string gnuplot_script(const Figure& figure);

}  // namespace trilat
