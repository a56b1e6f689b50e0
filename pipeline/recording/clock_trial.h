// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/session/session_clock.h"
#include "pipeline/recording/recording_spec.h"

namespace trilat {

// One frame on its way: made by the sensor, stamped and sent on by its machine, received by the server.
struct TrialFrame {
  FrameStamp stamp;
  HostTime exposure, sent, received;  // truly, on the server's clock
};

// What one sensor's machine and the server exchange during one run, with the truth.
struct ClockTrial {
  SensorDescription sensor;
  std::vector<ClockExchange> exchanges;  // by t1
  std::vector<TrialFrame> frames;  // received in this order, as over TCP: a late one holds up those behind it
};

// The noise depends on seed, run and sensor, not on the network: all networks are compared on the same draws.
ClockTrial simulate_clocks(const RecordingSpec& spec, const NetworkSpec& network, std::uint64_t run,
                           std::uint64_t sensor);

}  // namespace trilat
