// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/synthetic/simulated_sensor.h"
#include "recorders/frame_source.h"

namespace trilat {

// Virtual Kinects watching a motion for `duration_s`. Frames of all sensors come frame number by frame
// number, with the clock exchanges between them.
class SyntheticSource : public FrameSource {
 public:
  SyntheticSource(SensorSpec spec, SimulatedItem item, Motion motion, std::vector<SimulatedSensor> sensors,
                  double duration_s);
  const SessionHeader& header() const override { return header_; }
  std::optional<SourceEvent> next() override;

 private:
  std::optional<SourceEvent> frame_of(std::size_t sensor);
  std::optional<SourceEvent> exchange_of(std::size_t sensor);

  SensorSpec spec_;
  SimulatedItem item_;
  Motion motion_;
  std::vector<SimulatedSensor> sensors_;
  double duration_s_;
  SessionHeader header_;
  std::vector<std::uint64_t> next_frame_;
  std::vector<std::uint64_t> next_exchange_;
};

}  // namespace trilat
