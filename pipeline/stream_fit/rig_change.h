// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/rig/rigid_transform.h"
#include "pipeline/stream_fit/point_stream.h"

namespace trilat {

// Points of one person as one sensor sees them, in its frame, and its stated pose. All sensors of a rig have
// the same points at the same instants.
struct SensorStream {
  PointStream in_sensor;
  RigidTransform world_from_sensor;
};

// Two points of the body of which one is above the other in a person who stands: as indices.
struct UprightPoints {
  std::size_t high = 0, low = 0;
};

// Another convention in which the poses of a rig may be written.
struct PoseConvention {
  bool w_first = false;  // quaternions as w, x, y, z
  enum class Inverse : std::uint8_t {
    none,
    pose,
    rotation
  } inverse = Inverse::none;     // from the world to the sensor
  bool bodies_in_world = false;  // the bodies have been put there already

  bool is_ours() const { return !w_first && inverse == Inverse::none && !bodies_in_world; }
  // The pose that was meant by what was read as x, y, z, w from the sensor to the world.
  RigidTransform meant(const RigidTransform& read) const;
};

// One change that makes all sensors of a rig agree.
struct RigChange {
  std::vector<std::size_t> pose_of;                    // sensor s stands where pose_of[s] is stated to
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // of every sensor's frame, exchanged or turned round
  double distances = 1.0;  // positions of the sensors are stated so many times too far apart
  PoseConvention convention = {};
};

inline constexpr double kSensorsAgree_m = 0.2;  // mean distance between two sensors' views
inline constexpr double kUpsideDown_m = -0.3;   // mean height of the high point above the low one

// 0, 1, ... count - 1.
std::vector<std::size_t> same_order(std::size_t count);

// All sensors of a rig at a hundred instants, spread over the take.
class RigLooks {
 public:
  RigLooks(const std::vector<SensorStream>& sensors, const std::optional<UprightPoints>& upright);

  bool sees_any(std::size_t sensor) const;
  // Median distance between two sensors, the mean over all pairs, where the rig is changed.
  double distance_m(const RigChange& change) const;
  // How far the high point is above the low one in the mean; NaN where nothing says so.
  double height_m(const RigChange& change) const;
  // The change that leaves the least distance, and at most half of it: other axes of every sensor, poses that
  // were exchanged or passed on, distances of another scale, poses of another convention. Of a person who is
  // upside down one that leaves them upright; where all sensors agree about that, one that leaves them as
  // near.
  std::optional<RigChange> change_of_all(bool all_agree) const;

 private:
  double best_distances() const;
  RigidTransform pose_of(std::size_t sensor, const RigChange& change) const;

  const std::vector<SensorStream>& sensors_;
  std::optional<UprightPoints> upright_;
  std::vector<std::vector<Eigen::Vector3d>> looks_;  // by sensor, in its frame: instants x points
};

}  // namespace trilat
