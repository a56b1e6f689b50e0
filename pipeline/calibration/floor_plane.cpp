// SPDX-License-Identifier: MIT
#include "pipeline/calibration/floor_plane.h"

#include <algorithm>
#include <cmath>

namespace trilat {

std::optional<FloorPlane> floor_seen_by(const SessionReader& session, std::size_t sensor) {
  const std::uint64_t frames = session.counts(sensor).body_frames;
  for (std::uint64_t row = 0; row < frames; row += std::max<std::uint64_t>(1, frames / 100)) {
    const auto floor = session.body_frames(sensor, row, 1)[0].floor_plane;
    const Eigen::Vector3d normal(floor[0], floor[1], floor[2]);
    if (std::abs(normal.norm() - 1.0) < 0.05 && std::isfinite(floor[3]))
      return FloorPlane{normal.normalized(), double{floor[3]}};
  }
  return std::nullopt;
}

}  // namespace trilat
