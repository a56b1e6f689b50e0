// SPDX-License-Identifier: MIT
#include "evaluators/calibration/two_positions.h"

#include <array>
#include <cmath>

namespace trilat {
namespace {

constexpr double kLeastMovement_m = 1e-3;

// Rows: the client's axes in the sensor's frame; the second is the one that eq. 6 compares, the third the
// turn's.
Eigen::Matrix3d client_from_sensor(const TwoPositionOptions& options) {
  Eigen::Matrix3d axes;
  if (options.trajectory_axis == TrajectoryAxis::y) {
    axes << -1, 0, 0, 0, -1, 0, 0, 0, 1;  // half a turn: no frame that is turned only may be left-handed
    return axes;
  }
  const Eigen::Vector3d up = options.up_in_sensor.normalized();
  const Eigen::Vector3d forward = (Eigen::Vector3d::UnitZ() - up.z() * up).normalized();
  const Eigen::Vector3d right = forward.cross(up);
  const bool along_x = options.trajectory_axis == TrajectoryAxis::x;
  axes.row(0) = (along_x ? -forward : right).transpose();
  axes.row(1) = (along_x ? right : forward).transpose();
  axes.row(2) = up.transpose();
  return axes;
}

// The server's frame has y along the movement and z up; the wand's has x along it and y up.
Eigen::Matrix3d wand_from_server() {
  Eigen::Matrix3d axes;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return axes;
}

}  // namespace

std::string name_of(TwoPositionStatus status) {
  constexpr std::array<const char*, 4> kNames{"not_solved", "solved", "cosine_beyond_one", "no_movement"};
  return kNames.at(static_cast<std::size_t>(status));
}

TwoPositionPose solve_two_positions(const Eigen::Vector3d& first_in_sensor_m,
                                    const Eigen::Vector3d& second_in_sensor_m, double movement_m,
                                    const TwoPositionOptions& options) {
  TwoPositionPose result;
  const Eigen::Matrix3d client = client_from_sensor(options);
  const Eigen::Vector3d first_m = client * first_in_sensor_m;
  const Eigen::Vector3d moved_m = client * second_in_sensor_m - first_m;
  result.status = TwoPositionStatus::no_movement;
  if (!(movement_m > kLeastMovement_m) || !(moved_m.head<2>().norm() > kLeastMovement_m)) return result;
  double angle_rad = 0.0;
  if (options.signed_angle) {
    angle_rad = std::atan2(moved_m.x(), moved_m.y());
  } else {
    const double cosine = moved_m.y() / movement_m;
    result.status = TwoPositionStatus::cosine_beyond_one;
    if (!(std::abs(cosine) <= 1.0)) return result;
    angle_rad = std::acos(cosine);
  }
  const Eigen::Matrix3d server_from_sensor =
      Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * client;
  const Eigen::Matrix3d rotation = wand_from_server() * server_from_sensor;
  result.wand_from_sensor.rotation = Eigen::Quaterniond(rotation).normalized();
  if (options.translation) result.wand_from_sensor.translation_m = -(rotation * first_in_sensor_m);
  result.status = TwoPositionStatus::solved;
  return result;
}

}  // namespace trilat
