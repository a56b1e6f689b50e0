// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "datasets/results/gdop_map.h"
#include "pipeline/accuracy/take/plan.h"

namespace trilat {

// What a Kinect v2 sees: 70.6 x 60 degrees from 0.5 to 4.5 m of depth (its stated field and range).
inline constexpr double kHalfWidth_rad = 35.3 * 3.14159265358979323846 / 180.0;
inline constexpr double kHalfHeight_rad = 30.0 * 3.14159265358979323846 / 180.0;
inline constexpr double kNearestView_m = 0.5, kFarthestView_m = 4.5;

// Whether a point is in the view of a sensor that stands there.
bool is_in_view(const RigidTransform& world_from_sensor, const Eigen::Vector3d& point_in_world_m);

// The rig of the first take that can be evaluated, at the height of a hip, over the sensors and half a metre
// around them; nothing when no take can be.
std::optional<GdopMap> rig_gdop(const Plan& plan);

// Methods that answer nothing on that rig even where every sensor sees a joint without any error, and why;
// none of those over time.
struct SilentMethod {
  std::size_t method = 0;
  SolveStatus status = SolveStatus::not_solved;
};
std::vector<SilentMethod> silent_methods(const Plan& plan);

}  // namespace trilat
