// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "datasets/synthetic/depth/depth_renderer.h"
#include "recorders/synthetic_source.h"

namespace trilat {

// What the sensors look at, as a function of the time since the start of the motion. May be asked at any
// time, in any order and by several threads.
using SceneMotion = std::function<DepthScene(double time_s)>;

// Calls body(i) for every i < count, in any order and by any number of threads.
using ForEach = std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

struct SyntheticDepth {
  SceneMotion scene;
  DepthNoiseSpec noise;
  ForEach for_each = {};  // empty: one after another; what it throws ends next()
};

// Virtual Kinects with depth: behind every frame of bodies the depth of the same exposure, with the same
// stamps; a dropped frame has neither. Frames are rendered a few at a time, so that memory stays bounded.
class SyntheticDepthSource : public FrameSource {
 public:
  SyntheticDepthSource(SensorSpec spec, SimulatedItem item, Motion motion,
                       std::vector<SimulatedSensor> sensors, double duration_s, SyntheticDepth depth,
                       SyntheticTracker tracker);
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;

 private:
  void fetch();
  void render(SourceEvent& event) const;

  SensorSpec spec_;
  SimulatedItem item_;
  std::vector<SimulatedSensor> sensors_;
  SyntheticDepth depth_;
  SyntheticSource bodies_;
  SessionHeader header_;
  std::vector<DepthRenderer> renderers_;
  std::deque<SourceEvent> ready_;
};

}  // namespace trilat
