// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/results/figure.h"

namespace trilat {

// How a series looks. Told apart without colour too: by dash and by marker.
struct FigureLook {
  // #rrggbb that colour-blind readers tell apart and that stand out, 3:1 or more, from a white and from a
  // dark page: of Okabe and Ito's, and for its orange and sky blue, too pale on white, an olive and a violet.
  std::string colour;
  int dash = 1;    // 1 solid, then what gnuplot calls dash types
  int marker = 7;  // what gnuplot calls point types
};

// The look of a method is the same in every figure: its family has a colour (all of "nonlinear", "nonlinear
// as printed" and "nonlinear, 4 sensors" have one), its variant a dash. What the others are held against is
// black: the truth, or the paper's.
FigureLook look_of_method(const std::string& method);

// Looks of every series of a figure, those of one group alike. Series that are not methods get the colours
// that the figure's methods leave over, in order.
std::vector<FigureLook> looks_of(const Figure& figure);

}  // namespace trilat
