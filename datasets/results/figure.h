// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/units.h"

namespace trilat {

// NaN: the point is not drawn and ends a line: a point without x or y is not drawn and ends a line.
struct FigurePoint {
  double x = 0.0, y = 0.0;
  double low = kNaN, high = kNaN;  // an interval about y

  static void fields(auto& self, auto&& f) {
    f("x", self.x, "y", self.y, "low", self.low, "high", self.high);
  }
};

struct FigureSeries {
  // Intervals are drawn where points have them. A band is a line with its intervals shaded.
  enum class Style : std::uint8_t { dots, line, line_and_dots, band };
  std::string name;  // of the numbers
  Style style = Style::dots;
  std::vector<FigurePoint> points;
  std::string group{};      // series of one group share a look and a legend entry; empty: its own name
  std::string method{};     // whose colour it has, the same in every figure; empty: as the group comes
  std::uint64_t panel = 0;  // of the figure's panels
  bool hollow = false;      // marks without filling: what the paper prints

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "style", self.style, "points", self.points, "group", self.group, "method",
      self.method, "panel", self.panel, "hollow", self.hollow);
  }
};

template <>
inline constexpr std::array words<FigureSeries::Style>{"dots", "line", "line_and_dots", "band"};

// A part of the x axis, shaded; those of one name share a legend entry.
struct FigureBand {
  double from = 0.0, to = 0.0;
  std::string name;

  static void fields(auto& self, auto&& f) { f("from", self.from, "to", self.to, "name", self.name); }
};

// A dashed horizontal line.
struct FigureLine {
  double y = 0.0;
  std::string label;

  static void fields(auto& self, auto&& f) { f("y", self.y, "label", self.label); }
};

// Width of a printed figure: one column 85 mm, a page 178 mm, with letters of 8 pt.
enum class FigureWidth : std::uint8_t { column, page };
template <>
inline constexpr std::array words<FigureWidth>{"column", "page"};

// A figure as data, defined once; pictures are drawn from it and never compute. The title is for what stands
// around the picture: it is not drawn.
struct Figure {
  std::string id;                // file_name_from(): a file name
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
  bool is_first = false;     // of those that answer the study's question
  std::string printed = {};  // "table3": which numbers of the paper belong beside

  static void fields(auto& self, auto&& f) {
    f("id", self.id, "title", self.title, "caption", self.caption, "x_label", self.x_label, "y_label",
      self.y_label, "log_x", self.log_x, "log_y", self.log_y, "width", self.width, "x_names", self.x_names,
      "y_names", self.y_names, "panels", self.panels, "series", self.series, "bands", self.bands, "lines",
      self.lines, "is_first", self.is_first, "printed", self.printed);
  }
};

// figures.json, beside a study's summary.json.
struct StoredFigures {
  static constexpr const char* kFile = "figures.json";
  std::vector<Figure> figures;  // those that answer the study's question first

  static void fields(auto& self, auto&& f) {
    f.format("trilat.figures");
    f("figures", self.figures);
  }
};

// Legend entry of a series.
const std::string& group_of(const FigureSeries& series);

// The series, x and y under the labels of their axes and, where any point has one, the ends of its interval.
// Full precision (RFC 4180); what is not a number is an empty field, and x is the name that
// stands there where there are names.
std::string csv_of(const Figure& figure);

}  // namespace trilat
