// SPDX-License-Identifier: MIT
#include "datasets/import/fitted_intrinsics.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

constexpr double kFewestJoints = 200.0;
constexpr double kSmallestSpread = 0.03;  // standard deviation of X/Z and Y/Z
constexpr double kLargestRms_px = 1.0;

struct Line {
  double offset = 0.0, slope = 0.0, variance = 0.0, spread = 0.0;
};

Line line_of(const LineSums& sums) {
  const double mean_x = sums.x / sums.count, mean_y = sums.y / sums.count;
  const double var_x = sums.xx / sums.count - mean_x * mean_x;
  const double cov = sums.xy / sums.count - mean_x * mean_y;
  const double var_y = sums.yy / sums.count - mean_y * mean_y;
  const double slope = var_x > 0.0 ? cov / var_x : 0.0;
  return {mean_y - slope * mean_x, slope, std::max(0.0, var_y - slope * cov),
          std::sqrt(std::max(0.0, var_x))};
}

}  // namespace

void LineSums::add(double ratio, double pixel) {
  count += 1.0;
  x += ratio;
  y += pixel;
  xx += ratio * ratio;
  xy += ratio * pixel;
  yy += pixel * pixel;
}

void IntrinsicsFit::add(const Body& body, const JointPixels& depth_px) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& p = body.position_m[j];
    const auto [u, v] = depth_px[j];
    const bool inside = u >= 0.0 && u < kDepthWidth && v >= 0.0 && v < kDepthHeight;
    if (body.tracking_state[j] == 0 || p[2] < 0.3f || !inside) continue;
    column_.add(static_cast<double>(p[0]) / static_cast<double>(p[2]), u);
    row_.add(static_cast<double>(p[1]) / static_cast<double>(p[2]), v);
  }
}

std::optional<FittedIntrinsics> IntrinsicsFit::solve() const {
  if (column_.count < kFewestJoints) return {};
  const Line column = line_of(column_), row = line_of(row_);
  if (!(std::min(column.spread, row.spread) >= kSmallestSpread)) return {};
  FittedIntrinsics fitted;
  fitted.intrinsics = {.fx_px = column.slope,
                       .fy_px = -row.slope,
                       .cx_px = column.offset,
                       .cy_px = row.offset,
                       .k1 = 0.0,
                       .k2 = 0.0,
                       .k3 = 0.0};
  fitted.rms_px = std::sqrt(0.5 * (column.variance + row.variance));
  if (!(fitted.rms_px <= kLargestRms_px) || !implausibility_of(fitted.intrinsics).empty()) return {};
  return fitted;
}

}  // namespace trilat
