// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pipeline/stream_fit/stream_fit.h"

namespace trilat {

// Frame rates of cameras and motion capture, any two of which may be taken for each other.
inline constexpr std::array kFrameRates_hz{24.0, 25.0,  29.97, 30.0,  48.0,  50.0,  60.0,
                                           90.0, 100.0, 120.0, 150.0, 200.0, 240.0, 250.0};

// Starts and rates at which the distances between the points of the subject vary as those of the reference
// do, which needs no common frame; points of the left and the right are added, so that it does not matter
// which is which. Every local maximum is kept: the positions decide. Starts of a short search are all
// candidates. Always holds the clock as it is.
std::vector<StreamChange> clock_candidates(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                           const std::vector<SizeChange>& sizes,
                                           const StreamFitOptions& options);

}  // namespace trilat
