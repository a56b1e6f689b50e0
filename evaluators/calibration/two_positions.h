// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include <Eigen/Core>

#include "datasets/geometry/rigid_transform.h"

namespace trilat {

enum class TwoPositionStatus : std::uint8_t {
  not_solved,
  solved,
  cosine_beyond_one,  // eq. 6: noise makes dy' / dy exceed 1, so there is no angle
  no_movement,        // the two positions coincide, or differ only vertically
};
std::string name_of(TwoPositionStatus status);

// The paper's calibration from two wand positions (eq. 6 and 7), with a switch for each thing that cannot be
// so. All off: exactly as printed, with the axes of eq. 4.
struct TwoPositionOptions {
  // Which of the client's axes are turned: those of eq. 4 (x right, y down, z depth) or, as the text has it
  // ("z-axises ... are parallel", sensors perpendicular to the ground), the horizontal ones (x right, y
  // depth, z up).
  bool horizontal_axes = false;
  bool signed_angle = false;  // E4: atan2 of the displacement instead of the arc cosine
  bool translation = false;   // E5: the origin is where the ball first was
  // The direction of gravity in the sensor's frame when known; the paper takes the sensor to stand upright.
  Eigen::Vector3d up_in_sensor = Eigen::Vector3d::UnitY();
};

struct TwoPositionPose {
  TwoPositionStatus status = TwoPositionStatus::not_solved;
  RigidTransform wand_from_sensor;  // the wand frame of frames.h: x along the movement, y up
};

// `movement_m` is how far the wand moved, as measured in the server's frame (eq. 6 needs it).
[[nodiscard]] TwoPositionPose solve_two_positions(const Eigen::Vector3d& first_in_sensor_m,
                                                  const Eigen::Vector3d& second_in_sensor_m,
                                                  double movement_m, const TwoPositionOptions& options);

}  // namespace trilat
