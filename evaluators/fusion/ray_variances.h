// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "evaluators/fusion/range_bearing.h"

namespace trilat {

// Views of inferred joints from which their own sigma is known.
inline constexpr std::size_t kFewestInferred = 100;

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

// Restricted maximum likelihood of both variances in the model of solve_range_bearing(), each instant's place
// being unknown: squared residuals along rays sum to their degrees of freedom, and so do those across
// (Patterson and Thompson 1971; in adjustment theory Foerstner's variance components, 1979). Intervals are of
// the sandwich estimator over clusters and Student's t, so that errors may be correlated within a cluster.
// `observations`: instants times sensors of the rig; `cluster`: of each instant, such as its block of time.
// Instants seen by fewer than two sensors say nothing and are left out. Inferred joints have one factor on
// both sigmas, which is estimated with them where there are 100 views or more; otherwise they are left out,
// and the factor is the usual one. What all sensors have in common (a bias of the body model, say) makes no
// disagreement: it is not in the sigmas, and nothing can tell it without truth. Constant offsets between
// sensors are in them.
[[nodiscard]] RaySigmaEstimate estimate_ray_sigma(std::span<const JointObservation> observations,
                                                  std::span<const RigidTransform> world_from_sensor,
                                                  std::span<const std::uint32_t> cluster);

}  // namespace trilat
