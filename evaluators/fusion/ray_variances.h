// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evaluators/fusion/range_bearing.h"

namespace trilat {

// Views of inferred joints from which their own sigma is known.
inline constexpr std::size_t kMinInferred = 100;

// A joint at one instant as one sensor sees it.
struct RayView {
  std::size_t sensor = 0;
  bool inferred = false;
  Eigen::Vector3d point_m;
  // The point as it would be if rays were parallel: as far along the ray to the joint's place as the point is
  // from its sensor, and as far across.
  Eigen::Vector3d linearised_point_m;
  Eigen::Matrix3d weight;  // its inverse covariance in 1/m^2
};

// One joint at one instant as two sensors or more see it, and its place: the mean weighted by the views'
// inverse covariances, with its own.
struct RayViews {
  std::uint32_t cluster = 0;
  std::vector<RayView> views;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

// All rows of a take that two sensors see.
struct RayRows {
  std::vector<RayViews> rows;
  bool with_inferred = false;  // else inferred joints are left out: they are too few to know their sigma
};

// `observations`: rows times `sensors`; `cluster`: of each row. Places are the means of the points.
RayRows ray_rows(std::span<const JointObservation> observations, std::size_t sensors,
                 std::span<const std::uint32_t> cluster);

// Finds weights at the row's place, and the place that they give. Repeated it converges, as the place moves
// rays by second-order terms only. `rig`: the sensors' poses.
void place(RayViews& row, std::span<const RigidTransform> rig, const RaySigma& sigma);

// Scales each variance by its squared residuals over their degrees of freedom until both agree to `tolerance`
// (restricted maximum likelihood, see estimate_ray_sigma()), and places the rows. False when they do not in
// so many rounds.
bool converge(RayRows& rows, std::span<const RigidTransform> rig, double tolerance, int most_rounds,
              RaySigma& sigma);

struct RayInterval {
  double low = kNaN, high = kNaN;  // 95 %
};

// How well sensors place a joint along and across their rays, from their disagreement alone.
struct RaySigmaEstimate {
  RaySigma sigma{kNaN, kNaN};
  RayInterval range_m, bearing_m, ratio;
  std::size_t instants = 0, clusters = 0;  // that were used
  std::string problem;                     // why there is none; empty when there is

  double ratio_of() const { return sigma.range_m / sigma.bearing_m; }
};

// Restricted maximum likelihood of both variances, each instant's place being unknown: squared residuals
// along rays sum to their degrees of freedom, and so do those across (Patterson and Thompson 1971; in
// adjustment theory Foerstner's variance components, 1979). Intervals are of the sandwich estimator over
// clusters and Student's t, so that errors may be correlated within a cluster. `observations`: instants times
// sensors of the rig; `cluster`: of each instant, such as its block of time. Instants seen by fewer than two
// sensors say nothing and are left out. Inferred joints have one factor on both sigmas, which is estimated
// with them where there are 100 views or more; otherwise they are left out, and the factor is the usual one.
// Errors that all sensors share (a bias of the body model, say) make no disagreement: the sigmas leave them
// out, and nothing can tell them without truth. Constant offsets between sensors are in the sigmas.
[[nodiscard]] RaySigmaEstimate estimate_ray_sigma(std::span<const JointObservation> observations,
                                                  std::span<const RigidTransform> world_from_sensor,
                                                  std::span<const std::uint32_t> cluster);

}  // namespace trilat
