// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include <Eigen/Core>

namespace trilat {

// How a search for the wand's ball in one depth image ended. Only `found` has a position that may be used;
// `not_ended` has one to show what the printed method would have said.
enum class WandStatus : std::uint8_t {
  not_looked,
  found,
  no_wand,             // nothing round of the ball's size
  several_candidates,  // more than one (a second ball, a reflection, a head): none is taken
  out_of_range,        // a ball, but nearer or farther than depth is reliable
  cut_by_edge,         // a ball, but the image ends inside it
  not_ended,           // printed method: no pixel was left before its stop rule held
};
std::string name_of(WandStatus status);

// The ball in one depth image.
struct WandSighting {
  WandStatus status = WandStatus::not_looked;
  Eigen::Vector3d centre_in_sensor_m = Eigen::Vector3d::Constant(NAN);
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Constant(NAN);  // of the centre, from noise alone
  double rms_m = NAN;  // of the depth residuals of the pixels used
  int pixels = 0;      // used in the fit
};

}  // namespace trilat
