// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pipeline/stream_fit/stream_change.h"
#include "pipeline/stream_fit/stream_fit.h"

namespace trilat {

// A change with the errors that it leaves.
struct JudgedChange {
  StreamChange change;
  unsigned causes = 0;  // causes_of() it
  int parameters = 0;   // parameters_of() it
  ChangeErrors errors;
  // Mean of errors.judged_m over the blocks that any change answers; NaN where there are none.
  double mean_m = 0.0;
  bool is_noticed = true;  // whether it is as large as what is named
};

// No change first; then the changes that leave least, by squared distances at some instants, each fitted and
// judged, with every simpler one of the same parts. A block that a change does not answer counts as a
// constant pose, and as no better than without a change.
// Where frames have nothing in common, a turned frame alone counts as no change.
std::vector<JudgedChange> search_changes(const StreamPair& pair, const TimeBlocks& blocks,
                                         const std::vector<std::size_t>& mirrored,
                                         const StreamFitOptions& options);

// Sizes that the numbers of the subject may have, the unchanged first: by ratios of distances between points,
// which need no common clock, frame or sides; of one point by how far it moves or how far from the origin it
// is.
std::vector<std::vector<SizeChange>> size_candidates(const StreamPair& pair);

// Points about which the subject's positions may have been taken: its point, or the middle of two, stays
// where it is while that of the reference moves; or it has no such point at all.
std::vector<BodyRoot> root_candidates(const StreamPair& pair, const std::vector<std::size_t>& mirrored);

// The axis along which all points of the subject are one number, while the reference moves along every axis.
std::optional<int> flat_axis(const StreamPair& pair);

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
