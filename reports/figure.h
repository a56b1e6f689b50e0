// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace trilat {

struct FigurePoint {
  double x = 0.0, y = 0.0;  // NaN, or not above zero on a log axis: not drawn; it ends a line
};

struct FigureSeries {
  enum class Style { dots, line };
  std::string name;  // of the numbers
  Style style = Style::dots;
  std::vector<FigurePoint> points;
  std::string group;  // series of one group share a colour and a legend entry; empty: its own name
};

// A part of the x axis, shaded; those of one name share a legend entry.
struct FigureBand {
  double from = 0.0, to = 0.0;
  std::string name;
};

// A dashed horizontal line.
struct FigureLine {
  double y = 0.0;
  std::string label;
};

// A figure of points over x as data; renderings are made from it and never compute.
struct Figure {
  std::string id;     // usable_id(): a file name
  std::string title;  // says "simulated" where it is
  std::string caption;
  std::string x_label, y_label;  // with units
  bool log_y = false;
  std::vector<FigureSeries> series;
  std::vector<FigureBand> bands;
  std::vector<FigureLine> lines;
};

// A picture that needs nothing else. Axes span the series and lines; a band beyond them is cut. Equal figures
// give equal bytes.
std::string svg_of(const Figure& figure);

// series,x,y with full precision (RFC 4180); what is not a number is an empty field.
std::string csv_of(const Figure& figure);

}  // namespace trilat
