// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/tracker/body_tracker.h"
#include "recorders/frame_source.h"

namespace trilat {

// Scene before the sensors, as a function of the time since the start of the motion. May be asked at any
// time, in any order and by several threads.
using SceneMotion = std::function<DepthScene(double time_s)>;

// Calls body(i) for every i < count, in any order and by any number of threads.
using ForEach = std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

struct SyntheticDepth {
  SceneMotion scene;
  DepthNoiseSpec noise;
  ForEach for_each = {};  // empty: one after another; what it throws ends next()
};

// Virtual Kinects watching a motion for `duration_s`. Frames of all sensors come frame number by frame
// number, with the clock exchanges between them. With `depth` every frame of bodies has behind it the depth
// of the same exposure, with the same stamps; it is rendered a few frames at a time, so that memory stays
// bounded.
class SyntheticSource : public FrameSource {
 public:
  SyntheticSource(SensorSpec spec, SimulatedItem item, Motion motion, std::vector<SimulatedSensor> sensors,
                  double duration_s, const BodyTrackerSpec& tracker,
                  std::optional<SyntheticDepth> depth = {});
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;

 private:
  std::optional<SourceEvent> next_without_depth();
  std::optional<SourceEvent> frame_of(std::size_t sensor);
  std::optional<SourceEvent> exchange_of(std::size_t sensor);
  std::optional<BodyFrame> simulate(std::size_t sensor, std::uint64_t frame);

  SensorSpec spec_;
  SimulatedItem item_;
  Motion motion_;
  std::vector<SimulatedSensor> sensors_;
  double duration_s_;
  std::vector<BodyTracker> trackers_;  // one a sensor
  SessionHeader header_;
  std::vector<std::uint64_t> next_frame_;
  std::vector<std::uint64_t> next_exchange_;

  void fetch_with_depth();
  void render(SourceEvent& event) const;
  std::optional<SyntheticDepth> depth_;
  std::vector<DepthRenderer> renderers_;
  std::deque<SourceEvent> ready_;
};

}  // namespace trilat
