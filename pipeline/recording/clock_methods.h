// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/recording/clock_trial.h"

namespace trilat {

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
  // What a live system can do: the machine's clock and, of the last 8 exchanges that the server had when it
  // received the frame, the offset by the one of least delay, as NTP's clock filter (RFC 5905, section 10).
  corrected_causal,
  corrected_ticks  // the same, and the sensor's own ticks for the exposure
};
const std::vector<std::string>& clock_method_names();

// Error of every frame's time, stated less true, in seconds; NaN where there was no exchange yet.
std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method);

}  // namespace trilat
