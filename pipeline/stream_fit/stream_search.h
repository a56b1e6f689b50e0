// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace trilat
