// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/recording_summary.h"
#include "pipeline/recording/recording_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// Every method on every network, and what the paper's queue does with its times, over all runs, sensors and
// frames: an item a network.
std::vector<Item> clock_items(const RecordingSpec& spec);
struct ClockErrorResults {
  std::vector<ClockErrorRow> rows;
  std::vector<ClockFitRow> fits;
  std::vector<QueueRow> queues;
};
ClockErrorResults read_clocks(const RecordingSpec& spec, const Outcomes& outcomes);

}  // namespace trilat
