// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/rig/rigid_transform.h"
#include "evaluators/calibration/rig_start.h"

namespace trilat {

// Depth error of a unit, estimated beside its pose: measured = true + offset + a wiggling. The
// wiggling is a sum of waves whose lengths are spread evenly over the span. Priors keep both at zero where
// the data say nothing; together the waves' have the root mean square of the wiggling.
struct DepthCorrectionOptions {
  double offset_sigma_m = 0.0139;   // 24 mm uniform in +-
  double wiggle_sigma_m = 0.00255;  // a wave whose amplitude is uniform within 2 to 5 mm
  double shortest_wave_m = 0.6, longest_wave_m = 2.0;
};

// A point whose place in the world is known, from OptiTrack or a laser meter.
struct ControlPoint {
  std::size_t point = 0;
  Eigen::Vector3d point_in_world_m = Eigen::Vector3d::Zero();
  double sigma_m = 0.001;  // an axis
};

// Gauge of the world. Distances between sensors do not: one of these has to.
struct GaugePoints {  // origin at the first, x towards the second, the third above the x axis (y > 0, z = 0)
  std::array<std::size_t, 3> points{};
  // From the first to the second, when somebody measured it. Depth errors that all sensors share look like
  // another scale, which nothing else can tell from the true one.
  std::optional<double> distance_m = std::nullopt;
  double distance_sigma_m = 0.001;
};
struct RigGauge {
  std::optional<GaugePoints> first_points;
  std::vector<ControlPoint> control_points;  // at least three, not on a line, when there are no first_points
  // Neither: the reference sensor of the start stays at this pose.
  RigidTransform world_from_reference;
};

struct RigRefinementOptions {
  std::optional<DepthCorrectionOptions> depth_correction;
  double robust_scale = 3.0;     // soft-L1 loss of the first round, in standard deviations
  double rejection_chi2 = 30.0;  // squared normalised distance beyond which an observation is left out
  int rejection_rounds = 5;      // 0: nothing is left out and the loss stays
  bool covariances = true;
};

enum class RigStatus : std::uint8_t {
  not_solved,
  converged,
  gauge_undetermined,   // the points that fix the world lie on a line, or fewer than three are left
  sensor_undetermined,  // rejection left a sensor with fewer than three observations
  iteration_limit,
  failed,
};
std::string name_of(RigStatus status);

struct RefinedSensor {
  RigidTransform world_from_sensor;
  // Covariance of (rotation vector in world axes, rad; position, m); NaN when it was not asked for.
  Eigen::Matrix<double, 6, 6> covariance;
  double depth_offset_m = 0.0;
  double depth_offset_sigma_m = 0.0;
  double depth_chi2 = 0.0;  // of the depth correction by its priors; some 25 where they hold
  double rms_m = 0.0;       // of the observations used, an axis
  std::size_t used = 0;
  std::size_t rejected = 0;
};

struct RigRefinement {
  RigStatus status = RigStatus::not_solved;
  std::vector<RefinedSensor> sensors;
  std::vector<Eigen::Vector3d> point_in_world_m;  // NaN when no observation of it is used
  std::vector<bool> used;                         // one an observation
  std::vector<double> chi2;                       // one an observation: squared normalised distance
  double reduced_chi2 = 0.0;  // 1 when the covariances were right; covariances grow with it
  int iterations = 0;
};

// All poses and points at once by Ceres: minimises the squared distances between each point, turned into the
// sensor's frame, and its observation, each weighted by its covariance. First with a soft-L1 loss (convex: no
// start is lost); then observations that are too far off are left out, worst of each point first, until none
// is, and the rest is solved without loss. `reference_from_sensor` starts it (initial_poses()).
[[nodiscard]] RigRefinement bundle_adjust(const RigProblem& problem,
                                          const std::vector<RigidTransform>& reference_from_sensor,
                                          std::size_t reference, const RigGauge& gauge,
                                          const RigRefinementOptions& options);

}  // namespace trilat
