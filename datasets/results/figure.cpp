// SPDX-License-Identifier: MIT
#include "datasets/results/figure.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/text_output.h"

namespace trilat {
namespace {

std::string number(double v) { return std::isfinite(v) ? fmt::format("{}", v) : std::string(); }

// " (cm)" of "error (cm)"; nothing where there is none.
std::string unit_of(const std::string& label) {
  const auto open = label.rfind(" (");
  return open == std::string::npos || label.back() != ')' ? "" : label.substr(open);
}

template <class Has>
bool any_point(const Figure& figure, const Has& has) {
  for (const FigureSeries& s : figure.series)
    if (std::ranges::any_of(s.points, has)) return true;
  return false;
}

}  // namespace

const std::string& group_of(const FigureSeries& series) {
  return series.group.empty() ? series.name : series.group;
}

std::string csv_of(const Figure& figure) {
  const bool intervals = any_point(figure, [](const FigurePoint& p) { return std::isfinite(p.low); });
  const auto add = [&](const std::string& name) { return ',' + csv_field(name); };
  const std::string unit = unit_of(figure.y_names.empty() ? figure.y_label : figure.x_label);
  std::string text = (figure.panels.empty() ? "series" : "panel,series") + add(figure.x_label) +
                     add(figure.y_label.empty() ? "row" : figure.y_label);
  if (intervals) text += add("from" + unit) + add("to" + unit);
  text += "\r\n";
  const auto named = [](const std::vector<std::string>& names, double place) {
    const auto k = static_cast<std::size_t>(std::lround(std::max(0.0, place)));
    return k < names.size() ? csv_field(names[k]) : number(place);
  };
  for (const FigureSeries& s : figure.series)
    for (const FigurePoint& p : s.points) {
      if (!figure.panels.empty()) text += csv_field(figure.panels.at(s.panel)) + ',';
      text += csv_field(s.name) + ',' + named(figure.x_names, p.x) + ',' + named(figure.y_names, p.y);
      if (intervals) text += ',' + number(p.low) + ',' + number(p.high);
      text += "\r\n";
    }
  return text;
}

}  // namespace trilat
