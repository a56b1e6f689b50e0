// SPDX-License-Identifier: MIT
#include "evaluators/solvers/precision.h"

#include <algorithm>
#include <array>

#include "datasets/base/error.h"

namespace trilat {

Precision precision_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                       std::span<const double> range_variance_m2) {
  TRILAT_CHECK(problem.count >= 0 && problem.count <= kMaxSensors, "a problem holds its sensors");
  TRILAT_CHECK(range_variance_m2.size() == static_cast<std::size_t>(problem.count),
               "every range has a variance");
  Symmetric3 directions, information;
  for (int i = 0; i < problem.count; ++i) {
    const double variance_m2 = range_variance_m2[static_cast<std::size_t>(i)];
    TRILAT_CHECK(variance_m2 > 0.0, "the variance of a range is positive");
    const Eigen::Vector3d from_sensor = x_m - problem.sensor_m[i];
    const Eigen::Vector3d u = from_sensor / std::max(from_sensor.norm(), kOnSensor_m);
    directions.add_outer(1.0, u);
    information.add_outer(1.0 / variance_m2, u);
  }
  return precision_of(directions, information);
}

Precision precision_at(const RangeProblem& problem, const Eigen::Vector3d& x_m,
                       std::span<const double> range_variance_m2,
                       std::span<const Eigen::Matrix3d> sensor_covariance_m2) {
  TRILAT_CHECK(problem.count >= 0 && problem.count <= kMaxSensors, "a problem holds its sensors");
  const auto count = static_cast<std::size_t>(problem.count);
  TRILAT_CHECK(range_variance_m2.size() == count && sensor_covariance_m2.size() == count,
               "every range has a variance and every sensor a covariance");
  std::array<double, kMaxSensors> effective_m2;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d u = (x_m - problem.sensor_m[i]).normalized();
    effective_m2[i] = range_variance_m2[i] + u.dot(sensor_covariance_m2[i] * u);
  }
  return precision_at(problem, x_m, std::span(effective_m2).first(count));
}

}  // namespace trilat
