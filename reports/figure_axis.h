// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace trilat {

struct AxisTick {
  double value = 0.0;
  std::string label;  // empty: a short tick without one
};

// Where values lie along an axis, from 0 at its start to 1 at its end.
struct FigureAxis {
  double low = 0.0, high = 1.0;
  bool is_log = false;
  std::vector<AxisTick> ticks;  // ascending, within the axis

  double at(double value) const;
};

// Ticks 1, 2 or 5 times a power of ten apart, seven at most. Values that are not numbers do not count;
// without any the axis is 0 to 1.
FigureAxis linear_axis(const std::vector<double>& values);        // ends at ticks
FigureAxis linear_axis_tight(const std::vector<double>& values);  // ends a fiftieth beyond the values
// Ends at 1, 2 or 5 times a power of ten around the values above zero; 1 to 10 without any.
FigureAxis log_axis(const std::vector<double>& values);

}  // namespace trilat
