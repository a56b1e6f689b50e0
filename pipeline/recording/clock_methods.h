// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/session/clock/session_clock.h"
#include "pipeline/recording/recording_study.h"

namespace trilat {

// One frame on its way: made by the sensor, stamped and sent on by its machine, received by the server.
struct TrialFrame {
  FrameStamp stamp;
  HostTime exposure, sent, received;  // truly, on the server's clock
};

// Messages between one sensor's machine and the server during one run, with the truth.
struct ClockTrial {
  SensorDescription sensor;
  std::vector<ClockExchange> exchanges;  // by t1
  std::vector<TrialFrame> frames;  // received in this order, as over TCP: a late one holds up those behind it
};

// The noise depends on seed, run and sensor, not on the network: all networks are compared on the same draws.
ClockTrial simulate_clocks(const RecordingSpec& spec, const NetworkSpec& network, std::uint64_t run,
                           std::uint64_t sensor);

// How a frame gets its time.
enum class ClockMethod {
  none,            // the machine's clock is taken for the server's
  first_exchange,  // its offset at the start is taken off
  // Equations 21 and 22 as printed, by the latest exchange, from the time a frame was received. They give the
  // time of sending on the client's clock (erratum E11): taken for the server's, or compared with the
  // client's.
  printed,
  printed_client,
  corrected,  // the offline fit of all exchanges
  // Possible in a live system: the machine's clock and, of the last 8 exchanges that the server had when it
  // received the frame, the offset by the one of least delay, as NTP's clock filter (RFC 5905, section 10).
  corrected_causal,
  corrected_ticks  // the same, and the sensor's own ticks for the exposure
};
const std::vector<std::string>& clock_method_names();

// Error of every frame's time, stated less true, in seconds; NaN where there was no exchange yet.
std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method);

}  // namespace trilat
