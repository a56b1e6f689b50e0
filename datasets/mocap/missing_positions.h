// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Sets positions that programs write for what they have not seen to NaN, and counts them by asset.
// `position_m`: by asset, then by frame, NaN where it is missing; an asset without any is not looked at.
//
// Held: at least 0.2 s and three frames equal to the bit, of which the first is a measurement, while at least
// a third of the other assets change. Where the file has noise in its last digits (fewer than 2 % of the
// others' steps are exactly zero), that is enough. Else what truly stands still repeats, too, such as a foot
// on the floor: then the next position must lie 1 cm, and five of the asset's median steps, away. A lone
// asset is judged by its own noise.
// Filled: three times the same to the bit, at least 3 m and four median distances from the median of all
// positions, of which fewer than half may be filled; and infinite positions, which readers give for a number
// beyond 100 m that repeats.
std::vector<MissingCounts> remove_missing(std::span<const MocapTime> time,
                                          std::vector<std::vector<Eigen::Vector3d>>& position_m);

}  // namespace trilat
