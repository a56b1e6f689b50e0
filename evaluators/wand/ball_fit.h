// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "datasets/base/units.h"
#include "datasets/rig/depth_rays.h"

namespace trilat {

// One pixel in the sensor's frame: its ray (x, y, 1) and the measured depth along z; 0 where nothing was
// seen.
struct RayDepth {
  double x = 0.0;
  double y = 0.0;
  double depth_m = 0.0;
};

struct BallFitOptions {
  double radius_m = 0.075;
  AxialNoise noise = {};
  double lateral_sigma_m = 0.0016;  // sideways jitter of a ray: on a slope it becomes depth
  // Only pixels that see the surface at less than this angle between ray and normal, and that lie at least
  // one pixel inside the outline: beyond, depth is noisy or mixed with the background.
  double max_angle_rad = 60.0 * kRadPerDegree;
  double pixel_rad = 1.0 / 365.0;  // angle between neighbouring rays
};

enum class BallFitStatus : std::uint8_t {
  not_fitted,
  fitted,
  see_through_pixels,  // at too many of its pixels something behind the ball is seen
  too_few_pixels,      // less than kMinBallPixels agree with a ball near the start
  rank_deficient,      // they do not determine a centre
  left_start,          // a step of more than a radius
  iteration_limit,     // the last step was longer than kBallStep_m
};
inline constexpr int kMinBallPixels = 25;
inline constexpr double kBallStep_m = 1e-9;

struct BallFit {
  BallFitStatus status = BallFitStatus::not_fitted;
  Eigen::Vector3d centre_in_sensor_m = Eigen::Vector3d::Constant(NAN);
  // Inverse normal matrix of the noise model, times max(1, reduced chi squared).
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Constant(NAN);
  double rms_m = NAN;           // of the used residuals
  double expected_rms_m = NAN;  // by the noise model, of the same pixels
  // Change of the known radius by one more Gauss-Newton step with a free radius, and its uncertainty.
  double radius_excess_m = NAN;
  double radius_sigma_m = NAN;
  int used = 0;
  // Pixels at least two pixels inside the outline (and within max_angle_rad): all, those that agree
  // with the ball, those that see through it, and those where nothing was seen. The others see something
  // before it.
  int inner = 0;
  int inner_agreeing = 0;
  int inner_behind = 0;
  int inner_invalid = 0;
};

// Least squares over the centre of a ball of known radius: residual = measured depth minus the depth at which
// the pixel's ray meets the ball, weighted by 1 / sigma^2 of the noise model at the ray's angle. Pixels are
// chosen anew in every step, by a gate that narrows to four sigma, until the choice is frozen for the last
// steps. The start should be within half a radius.
[[nodiscard]] BallFit fit_ball(std::span<const RayDepth> pixels, const Eigen::Vector3d& start_in_sensor_m,
                               const BallFitOptions& options);

// Sensitivity of the fitted centre to depth errors: an error e(z) of the depth z of all pixels moves it by
// by_error * e(depth_m) + by_slope * e'(depth_m), to first order. Off the optical axis the ball's surface is
// farther on one side than on the other, so that a slope moves the centre sideways.
struct DepthSensitivity {
  double depth_m = 0.0;                                // of the surface, the mean by weight
  Eigen::Vector3d by_error = Eigen::Vector3d::Zero();  // without unit
  Eigen::Vector3d by_slope_m = Eigen::Vector3d::Zero();
};

// Influence of depth on the fit of a ball that is seen whole.
[[nodiscard]] DepthSensitivity depth_influence(const Eigen::Vector3d& centre_in_sensor_m,
                                               const BallFitOptions& options);

}  // namespace trilat
