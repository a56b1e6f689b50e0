// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "datasets/base/words.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {

// Standard deviations of a sensor's position of a joint: along its ray, and in each of the two directions
// across it. Positive and finite.
struct RaySigma {
  double range_m = kUsualRangeSigma_m;
  double bearing_m = kUsualRangeSigma_m;
  double inferred_factor = 3.0;  // on both, of an inferred joint
};

// Cost of a sensor's squared residual s in sigmas, all three directions together.
enum class Loss : std::uint8_t {
  squares,  // s
  cauchy,   // c^2 log(1 + s / c^2), c = loss_scale: beyond it a sensor counts less and less
};
template <>
inline constexpr std::array words<Loss>{"squares", "cauchy"};

struct RangeBearingOptions {
  SensorMask allowed = kAllSensors;
  RaySigma sigma = {};
  Loss loss = Loss::squares;
  double loss_scale = 3.0;
  double step_tolerance_m = 1e-10;
  int max_iterations = 100;  // of each descent
};

// A sentence that says which option is out of its range; empty when none is.
std::string contradiction_in(const RangeBearingOptions& options);

// The most likely place of a joint whose distance from each sensor and whose direction are both known, each
// as well as `sigma` says: the minimum of
//   F(x) = sum ((r - |x - s|) / range_m)^2 + (|(I - u u^T)(x - s)| / bearing_m)^2,
// s the sensor, r and u length and direction of its vector to the joint. The second term is the distance of x
// from the sensor's ray: the part of |x - s| (u - e) across u, and as long as that across e = (x - s)/|x -
// s|. As bearing_m grows it becomes the trilateration of eq. 10, as range_m grows triangulation; with equal
// sigmas it differs from the mean of the sensors' positions by second-order terms only. Bearings tell the
// two sides of the sensors' plane apart, so no mirror image has to be chosen. Ends with converged,
// iteration_limit, diverged, no_observation or non_finite_input. `covariance` is the Cramer-Rao bound at the
// position, in m^2: (sum (e e^T / range_m^2 + (I - e e^T) / bearing_m^2))^-1. InternalError when
// contradiction_in(options).
[[nodiscard]] PointEstimate solve_range_bearing(std::span<const JointObservation> observations,
                                                std::span<const RigidTransform> world_from_sensor,
                                                const RangeBearingOptions& options);

// F of the same joint at x, for comparing minima.
[[nodiscard]] double range_bearing_cost(std::span<const JointObservation> observations,
                                        std::span<const RigidTransform> world_from_sensor,
                                        const RangeBearingOptions& options, const Eigen::Vector3d& x_m);

}  // namespace trilat
