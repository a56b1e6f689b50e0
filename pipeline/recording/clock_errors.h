// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/recording/clock_methods.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/recording/recording_summary.h"
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

struct QueueRule {
  Duration late{0};  // the most by which a stated time of sending may differ from the server's time
  Duration server_frame{
      0};  // from one frame of the server to the next; 0: a frame is taken as soon as it comes
};

// The paper's queue of one client: first in, first out. In each of its frames the server takes the first
// frame whose stated time of sending, which is the true one + its error, lies within the limit; those in
// front of it are dropped. Frames stand in the order in which they were received; the server's frames begin
// at multiples of their length.
QueueCounts run_queue(const std::vector<TrialFrame>& frames, const std::vector<double>& errors_s,
                      const QueueRule& rule);

}  // namespace trilat
