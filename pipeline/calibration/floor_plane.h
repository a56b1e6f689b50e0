// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "datasets/session/session_reader.h"

namespace trilat {

// The floor as the body tracker states it: its unit normal and how high the sensor hangs above it.
struct FloorPlane {
  Eigen::Vector3d up_in_sensor = Eigen::Vector3d::UnitY();
  double height_m = 0.0;
};

// From the first of some hundred body frames, spread over the session, that has one.
std::optional<FloorPlane> floor_seen_by(const SessionReader& session, std::size_t sensor);

}  // namespace trilat
