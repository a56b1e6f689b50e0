// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace trilat {

// Its numbers are NaN where there is nothing: a point without x or y is not drawn and ends a line.
struct FigurePoint {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double x = 0.0, y = 0.0;
  double low = kNone, high = kNone;  // an interval about y
};

struct FigureSeries {
  // Intervals are drawn where points have them. A band is a line with its intervals shaded.
  enum class Style { dots, line, line_and_dots, band };
  std::string name;  // of the numbers
  Style style = Style::dots;
  std::vector<FigurePoint> points;
  std::string group{};    // series of one group share a look and a legend entry; empty: its own name
  std::string method{};   // whose colour it has, the same in every figure; empty: as the group comes
  std::size_t panel = 0;  // of the figure's panels
  bool hollow = false;    // marks without filling: what the paper prints
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

// Values over a plane, drawn as colours: values[r * x.size() + c] at (x[c], y[r]).
struct FigureMap {
  std::vector<double> x, y, values;
  std::string label;               // of the colours, with unit
  double least = 0.0, most = 1.0;  // of the colours; what lies beyond has the colour of the end
};

// As articles print them: 85 and 178 mm, with letters of 8 pt.
enum class FigureWidth { column, page };

// A figure as data, defined once; pictures are drawn from it and never compute. The title is for what stands
// around the picture: it is not drawn.
struct Figure {
  std::string id;                // usable_id(): a file name
  std::string title;             // says "simulated" where it is
  std::string caption;           // how many of what, which interval, simulated or recorded
  std::string x_label, y_label;  // with units
  bool log_x = false, log_y = false;
  FigureWidth width = FigureWidth::page;
  std::vector<std::string> x_names{};  // what stands at x = 0, 1, …; empty: numbers
  std::vector<std::string> y_names{};  // the same of y, downwards; intervals are then about x
  std::vector<std::string> panels{};   // small multiples with the same axes, each with its name; empty: one
  std::vector<FigureSeries> series{};
  std::vector<FigureBand> bands{};
  std::vector<FigureLine> lines{};
  std::optional<FigureMap> map{};
};

// Under which name a series stands in the legend.
const std::string& group_of(const FigureSeries& series);

// The series, x and y under the labels of their axes and, where any point has them, low and high; of a map
// its value too. Full precision (RFC 4180); what is not a number is an empty field, and x is the name that
// stands there where there are names.
std::string csv_of(const Figure& figure);

}  // namespace trilat
