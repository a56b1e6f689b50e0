// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

enum class LinearReference : std::uint8_t {
  one_sensor,  // subtract one sensor's sphere from every other
  all_pairs,   // subtract every two spheres: no sensor is special
};

struct LinearOptions {
  LinearReference reference = LinearReference::one_sensor;
  // For one_sensor: the rig's number of the reference. When it does not see the joint, the next higher number
  // that does, then the lowest.
  int reference_sensor = 0;
  // rank_deficient with fewer than four ranges, or when the smallest pivot of the QR factors is <= rank_ratio
  // times the largest: sensors within about rank_ratio of their spread of a common plane. Then ranges differ
  // in two directions only, whatever the joint, and the position is NaN.
  // Rounding errors of a position stay below about 1e-16 / rank_ratio of the distances.
  double rank_ratio = 1e-6;
  // Standard deviation of a range. The equations tell the distance from the sensors' plane with a standard
  // error of about range_sigma_m * range / thickness, the thickness being the root of the sum of the sensors'
  // squared distances from that plane. Sensors thinner than 10 range_sigma_m are nearly in one plane; 0: none
  // are.
  double range_sigma_m = kUsualRangeSigma_m;
};

// Linear least squares on differences of spheres, 2 (s_i - s_j).x = r_j^2 - r_i^2 + |s_i|^2 -
// |s_j|^2. Needs four sensors that are not in one plane. The answer depends on the
// reference whenever the ranges do not agree. When the sensors are nearly in one plane, choose_mirror()
// decides between the answer and its mirror image. Ends with closed_form, mirror_ambiguous or rank_deficient.
[[nodiscard]] PointEstimate solve_linear(const RangeProblem& problem, const LinearOptions& options);

// Only the position, of a problem that validate() does not refuse; nothing when rank deficient.
std::optional<Eigen::Vector3d> linear_position_m(const RangeProblem& problem, const LinearOptions& options);

}  // namespace trilat
