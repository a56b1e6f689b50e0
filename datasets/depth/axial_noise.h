// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

namespace trilat {

// How much a Kinect v2's depth scatters along z, one standard deviation (Fankhauser et al., "Kinect v2 for
// mobile robot navigation: evaluation and modeling", ICAR 2015): for the depth z in metres and the angle
// theta between ray and surface normal, sigma in millimetres =
// level_mm + slope_mm z + square_mm z^2 + angle_mm z^(3/2) theta^2 / (pi/2 - theta)^2.
struct AxialNoise {
  double level_mm = 1.5;
  double slope_mm = -0.5;
  double square_mm = 0.3;
  double angle_mm = 0.1;

  double sigma_m(double depth_m, double angle_rad) const {
    const double share = angle_rad / (std::numbers::pi / 2.0 - angle_rad);
    return 1e-3 * (level_mm + slope_mm * depth_m + square_mm * depth_m * depth_m +
                   angle_mm * depth_m * std::sqrt(depth_m) * share * share);
  }
};

}  // namespace trilat
