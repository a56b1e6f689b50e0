// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "datasets/results/stored_take.h"

namespace trilat {

// How the truth of a joint moves, and the errors of one method in the half of its samples with the larger
// acceleration and in the other half: numbers of samples and sums over a block of time.
struct MovementRow {
  std::uint32_t quantity = 0, block = 0, speeds = 0, abrupt = 0, calm = 0;
  double speed_m_s = 0.0, abrupt_m = 0.0, calm_m = 0.0;
};

// A row a joint and block, from the samples of the first track and how `table` lays the method's under the
// study's first alignment over the truth. Speeds are taken from the instants beside, accelerations from those
// a fifteenth of a second away, so that a marker's noise of some tenths of a millimetre does not decide them.
std::vector<MovementRow> movement_of(const StoredTake& take, const TakeErrors& table, std::size_t method,
                                     double rate_hz);

}  // namespace trilat
