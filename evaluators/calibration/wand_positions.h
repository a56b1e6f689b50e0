// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/time.h"
#include "datasets/rig/rigid_transform.h"
#include "evaluators/wand/wand_sighting.h"

namespace trilat {

// One frame in which a sensor found the ball.
struct TimedSighting {
  HostTime time;
  WandSighting sighting;
};

struct WandPositionOptions {
  double still_radius_m = 0.010;  // all sightings of a rest are within this of the mean of the first
  Duration shortest_rest{500'000'000};
  Duration longest_gap{200'000'000};    // between two sightings of one rest
  Duration settling{100'000'000};       // taken off both ends of a rest
  Duration least_overlap{200'000'000};  // of two sensors' rests that are the same position
  double deviation =
      3.5;  // frames farther from the median than so many robust standard deviations are left out
};

// The ball at rest as one sensor saw it: the mean of several frames, the deviating ones left out.
struct StaticSighting {
  std::size_t sensor = 0;
  HostTime first, last;
  Eigen::Vector3d centre_in_sensor_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  // of the mean, from noise alone
  std::size_t frames_used = 0;
  std::size_t frames_left_out = 0;
};

// A place where the wand was held, as all sensors that saw it there.
struct WandPosition {
  HostTime first, last;
  std::vector<StaticSighting> seen;  // at most one a sensor
};

// The mean of sightings of a ball at rest, at least one; frames that deviate are left out, as in the paper.
[[nodiscard]] StaticSighting mean_of_rest(std::span<const TimedSighting> rest, std::size_t sensor,
                                          double deviation);

// The rests of one sensor's ball, in the order of time; sightings must rise in time.
[[nodiscard]] std::vector<StaticSighting> find_static_intervals(std::span<const TimedSighting> sightings,
                                                                std::size_t sensor,
                                                                const WandPositionOptions& options);

// Brings together what several sensors saw at the same time; in the order of time.
[[nodiscard]] std::vector<WandPosition> find_wand_positions(std::vector<StaticSighting> rests,
                                                            const WandPositionOptions& options);

// The frame that three places of the wand define (frames.h): origin at the first, x towards the second, the
// third on y's side of the x axis, z across. Nothing when the places coincide (1 cm) or lie nearly on a line
// (the third within 1 % of the first two's distance of their line).
inline std::optional<RigidTransform> wand_from_places(const Eigen::Vector3d& first_m,
                                                      const Eigen::Vector3d& second_m,
                                                      const Eigen::Vector3d& third_m) {
  const Eigen::Vector3d x = second_m - first_m;
  const Eigen::Vector3d z = x.cross(third_m - first_m);
  if (!(x.norm() > 0.01) || !(z.norm() > 0.01 * x.squaredNorm())) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.row(0) = x.normalized();
  axes.row(2) = z.normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(axes).normalized();
  return RigidTransform{rotation, -(rotation * first_m)};
}

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

// `baseline_m` is how far the wand moved, as measured in the server's frame (eq. 6 needs it).
[[nodiscard]] TwoPositionPose solve_two_positions(const Eigen::Vector3d& first_in_sensor_m,
                                                  const Eigen::Vector3d& second_in_sensor_m,
                                                  double baseline_m, const TwoPositionOptions& options);

}  // namespace trilat
