// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/stream_fit/stream_change.h"

namespace trilat {

enum class StreamFitStatus : std::uint8_t {
  too_few,      // fewer than four blocks of time with points of both, at any start
  sound,        // no change is needed
  flat,         // one coordinate of the subject is constant: a result of two dimensions
  found,        // one change explains the difference
  one_of,       // several do, and the streams do not tell them apart
  unexplained,  // the streams differ, and none of the changes that are looked at explains it
};

struct StreamFit {
  StreamFitStatus status = StreamFitStatus::too_few;
  std::vector<StreamChange> changes;  // one, or those that are not told apart
  // Mean distance between the streams without and with the first change, each judged on blocks of time that
  // its frame was not fitted to. `before_m` is NaN where they have no time in common.
  double before_m = 0.0, after_m = 0.0;
  double overlap_s = 0.0;          // of both, without a change
  int flat_axis = 0;               // 0 to 2
  std::vector<double> of_point_m;  // mean distance by point after the first change, NaN where it is not known
};

struct StreamFitOptions {
  double min_start_s = 0.02;  // no start nearer to the stated one is named
};

// Finds what turns the subject into the reference: unit and scale, start and rate of its clock, exchanged
// points, and its frame (shifted, turned, mirrored, axes exchanged, relative to a point of the body). All are
// fitted together. A cause counts when the error on blocks of time that it was not fitted to falls by a fifth
// and by three standard errors of the paired blocks; what does not earn that is taken away again, so that
// simpler explanations win. Below these sizes nothing is named: 10 % of scale, 10 cm of shift, 0.05 rad of
// turn, `min_start_s`, and a rate that moves the ends of the stream by less than 0.02 s.
// `mirrored`: mirrored_points() of both, which have the same points in the same order.
StreamFit fit_streams(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                      const StreamFitOptions& options = {});

}  // namespace trilat
