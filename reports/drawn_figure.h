// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>

#include "reports/figure.h"

namespace trilat {

// A figure and its picture: an SVG document that needs nothing else.
struct DrawnFigure {
  Figure figure;
  std::string svg;
};

inline DrawnFigure drawn(Figure figure) {
  std::string svg = svg_of(figure);
  return {std::move(figure), std::move(svg)};
}

}  // namespace trilat
