// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

namespace trilat {

// How far joints move about each instant, in the world: instants times joints, NaN where they are not known.
struct Movements {
  std::vector<Eigen::Vector3d> moved_m;
  std::size_t joints = 0;
};

// Lag of one stream of movements behind another, and its standard deviation by a jackknife over eight blocks
// of time; above zero: the stream comes later.
struct MovementLag {
  double lag_s, sigma_s;
};

// `others`: of the same instants and joints, zero where they are not known. Both are NaN for less than six
// seconds, and where the streams correlate at no lag within a second, nearly as well without one, or as well
// when one stream is turned, with any of the blocks left out. A lag that is needed is looked for within
// three.
MovementLag lag_of(const Movements& own, const Movements& others, double rate_hz);

}  // namespace trilat
