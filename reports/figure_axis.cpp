// SPDX-License-Identifier: MIT
#include "reports/figure_axis.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace trilat {
namespace {

constexpr double kMostSteps = 6.0;
constexpr double kRounding = 1e-9;  // of a step: what counts as being on a tick
constexpr double kMargin = 0.02;
constexpr int kMostDecadesInFull = 4;  // with labels at 2 and 5 too
constexpr std::array<int, 3> kLabelled{1, 2, 5};

struct Range {
  double low, high;
};

Range range_of(const std::vector<double>& values, bool positive_only) {
  Range range{INFINITY, -INFINITY};
  for (double v : values) {
    if (!std::isfinite(v) || (positive_only && v <= 0.0)) continue;
    range.low = std::min(range.low, v);
    range.high = std::max(range.high, v);
  }
  return range;
}

// One value is given some room, so that it has a place.
Range linear_range(const std::vector<double>& values) {
  const Range range = range_of(values, false);
  if (!(range.low <= range.high)) return {0.0, 1.0};
  if (range.low < range.high) return range;
  const double room = range.low == 0.0 ? 0.5 : 0.5 * std::abs(range.low);
  return {range.low - room, range.high + room};
}

double nice_step(double span) {
  const double power = std::pow(10.0, std::floor(std::log10(span / kMostSteps)));
  for (double step : {1.0, 2.0, 5.0})
    if (span / (step * power) <= kMostSteps * (1.0 + kRounding)) return step * power;
  return 10.0 * power;
}

void add_linear_ticks(FigureAxis& axis, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - kRounding)), 0, 12);
  const double first = std::ceil(axis.low / step - kRounding),
               last = std::floor(axis.high / step + kRounding);
  for (double k = first; k <= last; k += 1.0) {
    const double value = k * step + 0.0;  // no negative zero
    axis.ticks.push_back({value, fmt::format("{:.{}f}", value, decimals)});
  }
}

double on_decade(int decade, int digit) { return digit * std::pow(10.0, decade); }

}  // namespace

double FigureAxis::at(double value) const {
  if (is_log) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

FigureAxis linear_axis(const std::vector<double>& values) {
  const Range range = linear_range(values);
  const double step = nice_step(range.high - range.low);
  FigureAxis axis;
  axis.low = std::floor(range.low / step + kRounding) * step;
  axis.high = std::ceil(range.high / step - kRounding) * step;
  add_linear_ticks(axis, step);
  return axis;
}

FigureAxis linear_axis_tight(const std::vector<double>& values) {
  const Range range = linear_range(values);
  const double margin = kMargin * (range.high - range.low);
  FigureAxis axis;
  axis.low = range.low - margin;
  axis.high = range.high + margin;
  add_linear_ticks(axis, nice_step(range.high - range.low));
  return axis;
}

FigureAxis log_axis(const std::vector<double>& values) {
  Range range = range_of(values, true);
  if (!(range.low <= range.high)) range = {1.0, 10.0};
  const int from = static_cast<int>(std::floor(std::log10(range.low)));
  const int to = static_cast<int>(std::ceil(std::log10(range.high)));
  FigureAxis axis;
  axis.is_log = true;
  axis.low = on_decade(from, 1);
  axis.high = on_decade(to, 1);
  for (int digit : {2, 5})
    if (on_decade(from, digit) <= range.low * (1.0 + kRounding)) axis.low = on_decade(from, digit);
  for (int digit : {5, 2})
    if (on_decade(to - 1, digit) >= range.high * (1.0 - kRounding)) axis.high = on_decade(to - 1, digit);
  if (axis.low >= axis.high) axis.high = axis.low * 10.0;
  for (int decade = from; decade <= to + 1; ++decade)
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = on_decade(decade, digit);
      if (value < axis.low * (1.0 - kRounding) || value > axis.high * (1.0 + kRounding)) continue;
      const bool labelled =
          digit == 1 || (to - from <= kMostDecadesInFull &&
                         std::find(kLabelled.begin(), kLabelled.end(), digit) != kLabelled.end());
      axis.ticks.push_back({value, labelled ? fmt::format("{:.12g}", value) : std::string()});
    }
  return axis;
}

}  // namespace trilat
