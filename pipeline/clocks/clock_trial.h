// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/session/clock/session_clock.h"

namespace trilat {

// One frame on its way: made by the sensor, stamped and sent on by its computer, received by the recorder.
struct TrialFrame {
  FrameStamp stamp;
  HostTime exposure, sent, received;  // on the recorder's clock
};

// One sensor's clocks in one recording.
struct ClockTrial {
  std::vector<ClockExchange> exchanges;  // by t1
  std::vector<TrialFrame> frames;  // received in this order, as over TCP: a late one holds up those behind it
  SensorClockMap clock;            // the offline fit
  bool is_exact = false;           // the frames' times are the simulator's, and not those of the offline fit
};

// Reads a recorded sensor's body frames, or its depth frames where there are no bodies. Times are those of
// the simulator where truth.json states its clocks, else of the offline fit. A session does not keep when
// frames were received: each is taken to travel as long as the answer of the exchange next to it, and to wait
// for the one before. InputError where it has no exchanges.
ClockTrial read_clock_trial(const SessionReader& session, std::size_t sensor);

// Ways to give a frame its time.
enum class ClockMethod {
  none,            // the computer's clock is taken for the recorder's
  first_exchange,  // its offset at the start is taken off
  // Equations 21 and 22 as printed, by the latest exchange, from the time a frame was received. They give the
  // time of sending on the client's clock (erratum E11): taken for the server's, or compared with the
  // client's.
  printed,
  printed_client,
  causal,   // as a live system can: LiveClock
  offline,  // the fit of all exchanges
  ticks     // the same, and the sensor's own ticks for the exposure
};
const std::vector<std::string>& clock_method_names();

// Error of every frame's time, stated less true, in seconds; NaN where there was no exchange yet, and of the
// offline fit where it is itself the truth.
std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method);

// Fate of a sensor's frames in the paper's queue at the server.
struct QueueCounts {
  std::uint64_t came = 0;
  std::uint64_t untimed = 0;  // no exchange yet, so no time of sending
  std::uint64_t too_early = 0,
                too_late = 0;  // stated time of sending too far from the server's time: dropped
  std::uint64_t taken = 0;
  bool operator==(const QueueCounts&) const = default;
};

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
