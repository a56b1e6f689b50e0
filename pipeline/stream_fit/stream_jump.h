// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "pipeline/stream_fit/stream_fit.h"

namespace trilat {

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

// A change that holds in a part of the subject alone, as where a camera was moved: until an instant, or from
// it on.
struct PartChange {
  StreamChange change;
  bool is_later = true;
  double at_s = 0.0;     // the first instant behind the part's beginning or end
  double after_m = 0.0;  // mean distance between the streams with it
};

// A change of frame, names or size in a part, which explains a difference that fit_streams() does not: with
// it the mean distance is below `most_left_m`.
std::optional<PartChange> find_part_change(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                           const StreamFitOptions& options, double most_left_m);

// A frame that moves against that of the reference as time goes on: the positions of inertial suits do, and
// those of a camera that is carried.
struct FrameDrift {
  double shift_m = 0.0, turn_rad = 0.0;  // of the subject, from the first piece to the last
  double piece_s = 0.0;
  double after_m = 0.0;  // mean distance between the streams with a frame of its own for each piece
};

// A drift that explains what one frame for all does not: piece by piece the mean distance is 0.6 of that or
// less, 2.5 cm smaller, and below 8 cm. Frames are fitted to every second instant and judged on the others.
std::optional<FrameDrift> find_frame_drift(const StreamPair& pair);

// Mean distance of the streams when each point is held against its own mean place, where that explains what a
// constant pose does not: it is a third of `before_m` or less, below 10 cm, and half of what the points of
// the reference move or less.
std::optional<double> find_own_places(const StreamPair& pair, double before_m);

}  // namespace trilat
