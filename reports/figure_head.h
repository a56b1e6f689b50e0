// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "reports/figure.h"

namespace trilat {

inline constexpr double kFigureWidth_px = 760.0;
inline constexpr double kFigureLeft_px = 72.0, kFigureRight_px = 24.0;  // of the data's rectangle

const std::string& group_of(const FigureSeries& series);
// Each group once, in the order of the series: a group's place is its colour.
std::vector<std::string> groups_of(const Figure& figure);

struct FigureHead {
  std::string svg;
  double height_px = 0.0;  // the data begin below
};
// The title and the legend, both wrapped to the figure's width.
FigureHead figure_head(const Figure& figure);

}  // namespace trilat
