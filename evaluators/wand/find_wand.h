// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/rig/depth_rays.h"
#include "evaluators/wand/wand_sighting.h"

namespace trilat {

struct FindWandOptions {
  double ball_radius_m = 0.075;
  // Out of range is a ball some of whose surface is nearer in depth, or whose middle is farther.
  double nearest_m = 0.5;
  double farthest_m = 4.5;
  AxialNoise noise = {};            // weights and covariance, with
  double lateral_sigma_m = 0.0016;  // how far a ray jitters sideways at the surface
};

// The centre of a ball of known radius: segments the image at depth steps, keeps what has the ball's size and
// outline, fits a sphere in 3-D by least squares along the rays with weights from the noise model, and
// refuses what is not round. `near_in_sensor_m`, when given, is where the ball was a moment ago: only the
// surroundings are searched, and a ball elsewhere is not noticed.
[[nodiscard]] WandSighting find_wand(const DepthImageView& image, const DepthRays& rays,
                                     const FindWandOptions& options,
                                     const std::optional<Eigen::Vector3d>& near_in_sensor_m = std::nullopt);

// Finds the ball in one frame after the other: first near where the ball was in the frame before, then in the
// whole image.
[[nodiscard]] WandSighting follow_wand(const DepthImageView& image, const DepthRays& rays,
                                       const FindWandOptions& options,
                                       std::optional<Eigen::Vector3d>& before_in_sensor_m);

}  // namespace trilat
