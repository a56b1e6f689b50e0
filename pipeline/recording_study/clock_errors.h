// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "datasets/results/recording_summary.h"
#include "pipeline/items/study_items.h"
#include "pipeline/recording_study/recording_spec.h"

namespace trilat {

struct RecordingHooks {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
};

// Every method on every network, and what the paper's queue does with its times, over all runs, sensors and
// frames: an item a network; without those that are another shard's. Throws Interrupted.
struct ClockErrorResults {
  std::vector<ClockErrorRow> rows;
  std::vector<ClockFitRow> fits;
  std::vector<QueueRow> queues;
};
ClockErrorResults measure_clocks(const RecordingSpec& spec, StudyItems& items, const RecordingHooks& hooks);
std::vector<PartItem> clock_items(const RecordingSpec& spec);

}  // namespace trilat
