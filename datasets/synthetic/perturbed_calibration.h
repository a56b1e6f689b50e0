// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "datasets/calibration/calibration.h"

namespace trilat {

// The calibration with every sensor moved and turned by normal errors of these sizes an axis (rotation
// vectors in world axes); the same for the same seed.
Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed);

}  // namespace trilat
