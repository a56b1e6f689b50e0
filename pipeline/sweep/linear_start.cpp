// SPDX-License-Identifier: MIT
#include "pipeline/sweep/linear_start.h"

#include <algorithm>

#include <Eigen/QR>

namespace trilat {

// Row i: 2 (s_i - s_0).(x - s_0) = |s_i - s_0|^2 - r_i^2 + r_0^2.
LinearStart linear_start(const RangeProblem& problem) {
  const int rows = problem.count - 1;
  Eigen::Matrix<double, Eigen::Dynamic, 3> a(rows, 3);
  Eigen::VectorXd square_m2(rows);
  for (int i = 0; i < rows; ++i) {
    const Eigen::Vector3d from_reference_m = problem.sensor_m[i + 1] - problem.sensor_m[0];
    a.row(i) = 2.0 * from_reference_m.transpose();
    square_m2[i] = from_reference_m.squaredNorm();
  }
  const Eigen::MatrixXd inverse = a.colPivHouseholderQr().solve(Eigen::MatrixXd::Identity(rows, rows));
  const Eigen::Vector3d offset_m = problem.sensor_m[0] + inverse * square_m2;
  LinearStart start;
  for (int axis = 0; axis < 3; ++axis) {
    start.offset_m[axis] = offset_m[axis];
    start.factor_per_m[axis][0] = inverse.row(axis).sum();
    for (int i = 0; i < rows; ++i) start.factor_per_m[axis][i + 1] = -inverse(axis, i);
  }
  return start;
}

void LinearStart::positions(int sensors, std::size_t count, std::size_t stride, const double* range_m,
                            double* position_m) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double* to = position_m + axis * stride;
    std::fill_n(to, count, offset_m[axis]);
    for (std::size_t s = 0; s < static_cast<std::size_t>(sensors); ++s) {
      const double factor = factor_per_m[axis][s];
      const double* r = range_m + s * stride;
      for (std::size_t i = 0; i < count; ++i) to[i] += factor * (r[i] * r[i]);
    }
  }
}

}  // namespace trilat
