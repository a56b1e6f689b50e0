// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "evaluators/alignment/interpolation.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

enum class ClockOffsetStatus : std::uint8_t {
  not_solved = 0,
  found = 1,
  too_little_motion = 2,  // nothing moves, or hardly: any offset would fit
  // The best correlation of the speeds is below least_peak; or the streams are in one frame, and at the best
  // offset the joints are farther apart than largest_misfit_m.
  no_agreement = 3,
  ambiguous = 4,      // another offset within the search fits nearly as well: periodic motion
  at_limit = 5,       // the best offset lies at the end of the search
  too_uncertain = 6,  // the interval is wider than is of use
};
std::string_view name_of(ClockOffsetStatus status);

// How the frames of two streams lie to each other. Unless they are shifted, one offset is chosen of those
// that fit the speeds alike, such as those a gait cycle apart: the one that lays the joints over each other,
// when it does so clearly better.
enum class StreamFrames : std::uint8_t {
  same,
  shifted,  // the axes agree
  turned,   // anyhow: the estimate is turned onto the truth, which costs some accuracy
};

struct ClockOffsetOptions {
  double search_s = 0.3;  // to both sides
  StreamFrames frames = StreamFrames::shifted;
  double smooth_s = 0.06;  // sigma of the window of speeds and positions, the same for both streams
  double slow_s = 0.5;     // what is slower than this is not compared: offsets and drift of trackers
  double grid_hz = 240.0;  // of the truth, between whose points is interpolated
  double longest_gap_s = 0.11;
  double block_s = 2.0;  // errors of trackers last for about this long; the interval counts them by blocks
  double least_speed_m_s = 0.05;  // root mean square about the mean speed
  double least_peak = 0.5;
  double largest_second = 0.9;  // second peak over first
  // Largest median distance between the joints at the best offset, and its largest ratio to that at any other
  // candidate.
  double largest_misfit_m = 0.15, largest_misfit_ratio = 0.8;
  double largest_sigma_s = 0.010;
};

// truth(t + offset_s) is what the estimate shows at t: the truth's clock minus the estimate's, together with
// the mean lag of the tracker, which motion cannot tell from a clock.
struct ClockOffset {
  ClockOffsetStatus status = ClockOffsetStatus::not_solved;
  double offset_s = kNaN;              // NaN unless found
  double sigma_s = kNaN;               // one standard deviation, by jackknife over blocks of time
  double low_s = kNaN, high_s = kNaN;  // 95 %, Student's t over the blocks
  double drift_ppm = kNaN, drift_sigma_ppm = kNaN;  // from the first third of the take to the last
  double peak = kNaN;       // correlation of the speeds at the best offset, mean over joints
  double second = kNaN;     // the largest other peak over it; 0 when there is none
  double speed_m_s = kNaN;  // mean of the truth's joints
  double median_distance_m =
      kNaN;  // median distance between the joints at the best offset, unless they are shifted
};

// Finds by motion how two recordings of the same joints are shifted in time. First the speeds are correlated,
// which needs no common frame, over the whole search, and of peaks that are alike the positions choose; then
// the positions, less what is slow, are laid over each other in least squares with Cauchy's loss, which finds
// the offset to a small part of a frame. Streams whose axes differ are first turned onto each other.
// `estimate` and `truth` hold the same joints in the same order. InternalError otherwise.
[[nodiscard]] ClockOffset find_clock_offset(std::vector<PointPath> estimate, std::span<const PointPath> truth,
                                            const ClockOffsetOptions& options);

}  // namespace trilat
