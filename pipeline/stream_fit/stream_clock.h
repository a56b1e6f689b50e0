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

// One jump of the subject's clock, as where rows were cut out and those after them numbered on, or where a
// recording was paused.
struct ClockJump {
  double at_s = 0.0;     // the first instant after it, on the subject's clock
  double start_s = 0.0;  // what is to be added to the times before it
  double by_s = 0.0;     // what is to be added to the times from it on, beyond `start_s`
  double after_m = 0.0;  // mean distance between the streams with both
};

// A jump that explains a difference which fit_streams() does not: with it the mean distance is below a third
// of `before_m`.
std::optional<ClockJump> find_clock_jump(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                         const StreamFitOptions& options, double before_m);

}  // namespace trilat
