// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace trilat {

// How far a joint is bent, in radians from 0 (straight) to pi: the angle between the two segments that meet
// in `joint`, with their outer ends, taken from pi. NaN where a point is missing or two coincide.
double flexion_rad(const Eigen::Vector3d& upper_end, const Eigen::Vector3d& joint,
                   const Eigen::Vector3d& lower_end);

// How far the line from `below` to `above` leans from y, in radians from 0 (upright) to pi.
double inclination_rad(const Eigen::Vector3d& below, const Eigen::Vector3d& above);

}  // namespace trilat
