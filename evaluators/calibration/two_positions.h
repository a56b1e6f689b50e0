// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

// Which axis of the sensor, named as in eq. 4 (x right, y down, z depth), is the paper's y': the one whose
// angle to the wand's trajectory eq. 6 measures. As printed it is y, and the turn is about the depth. By the
// text ("z-axises ... are parallel", sensors perpendicular to the ground) both are horizontal and the turn is
// about the vertical: then it is x or z.
enum class TrajectoryAxis : std::uint8_t { x, y, z };
inline const std::vector<std::string> kTrajectoryAxes{"x", "y", "z"};

// The paper's calibration from two wand positions (eq. 6 and 7), with a switch for each thing that cannot be
// so. As it stands here: exactly as printed, with the axes of eq. 4.
struct TwoPositionOptions {
  TrajectoryAxis trajectory_axis = TrajectoryAxis::y;
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
