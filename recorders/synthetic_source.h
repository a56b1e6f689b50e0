// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "datasets/synthetic/tracker/body_tracker.h"
#include "recorders/frame_source.h"

namespace trilat {

// The body tracker of virtual Kinects, who else is there, and who gets the truth: called for every
// frame that is delivered, a sensor's in their order.
struct SyntheticTracker {
  BodyTrackerSpec spec;
  std::vector<Motion> bystanders = {};
  std::function<void(std::size_t sensor, const TrackerTruth&)> on_truth = {};
};

// Virtual Kinects watching a motion for `duration_s`. Frames of all sensors come frame number by frame
// number, with the clock exchanges between them.
class SyntheticSource : public FrameSource {
 public:
  SyntheticSource(SensorSpec spec, SimulatedItem item, Motion motion, std::vector<SimulatedSensor> sensors,
                  double duration_s, SyntheticTracker tracker);
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;

 private:
  std::optional<SourceEvent> frame_of(std::size_t sensor);
  std::optional<SourceEvent> exchange_of(std::size_t sensor);
  std::optional<BodyFrame> simulate(std::size_t sensor, std::uint64_t frame);

  SensorSpec spec_;
  SimulatedItem item_;
  Motion motion_;
  std::vector<SimulatedSensor> sensors_;
  double duration_s_;
  SyntheticTracker tracker_;
  std::vector<BodyTracker> trackers_;  // one a sensor
  SessionHeader header_;
  std::vector<std::uint64_t> next_frame_;
  std::vector<std::uint64_t> next_exchange_;
};

}  // namespace trilat
