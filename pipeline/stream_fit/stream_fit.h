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
  double overlap_s = 0.0;  // of both, without a change
  int flat_axis = 0;       // 0 to 2
  // Mean distance after the first change by point, and by block of time; NaN where it is not known.
  std::vector<double> of_point_m, of_block_m;
};

// So much of the error without a cause may be left with it.
inline constexpr double kEarnedShare = 0.8;

struct StreamFitOptions {
  double min_start_s = 0.02;           // a start nearer to the stated one is not named
  double max_start_s = 600.0;          // a start farther from it is not looked for
  double min_scale = 0.10;             // a scale nearer to 1 is not named, unless it is that of a unit
  unsigned causes = kAllStreamCauses;  // that are looked for
  double alpha = 0.0027;               // of the paired blocks, two-sided: three standard errors of many
  bool any_frame = false;              // the frames have nothing in common, and are no cause
};

// The change that changes nothing; of streams in any frame one that lays them over each other.
StreamChange no_change(const StreamFitOptions& options);
// Causes of a change but for a frame that may be any.
unsigned named_causes(const StreamChange& change, const StreamFitOptions& options);

// Finds what turns the subject into the reference: unit and scale, start and rate of its clock, exchanged
// points, and its frame (shifted, turned, mirrored, axes exchanged, relative to a point of the body). All are
// fitted together. A cause counts when the error on blocks of time that it was not fitted to falls by a fifth
// and by what `alpha` asks for of the paired blocks; what does not earn that is taken away again, so that
// simpler explanations win. Below these sizes nothing is named: `min_scale`, 15 cm of shift, 0.05 rad of
// turn, `min_start_s`, and a rate that moves the ends of the stream by less than 0.02 s.
// `mirrored`: mirrored_points() of both, which have the same points in the same order.
StreamFit fit_streams(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                      const StreamFitOptions& options = {});

}  // namespace trilat
