// SPDX-License-Identifier: MIT
#include "pipeline/recording_study/clock_methods.h"

#include <cmath>
#include <limits>
#include <optional>

namespace trilat {
namespace {

// The server's view: D and E of equation 21.
struct PrintedExchange {
  std::int64_t delay_ns, error_ns;
};

PrintedExchange printed_exchange(const ClockExchange& e) {
  return {((e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns)) / 2, ((-e.t2_ns + e.t1_ns) + (e.t4_ns - e.t3_ns)) / 2};
}

double seconds(std::int64_t ns) { return std::abs(static_cast<double>(ns)) * 1e-9; }

std::vector<double> without_exchanges(const ClockTrial& trial) {
  std::vector<double> errors_s;
  for (const TrialFrame& f : trial.frames) errors_s.push_back(seconds(f.stamp.arrival_ns - f.sent.ns));
  return errors_s;
}

std::vector<double> by_first_exchange(const ClockTrial& trial) {
  std::vector<double> errors_s;
  for (const TrialFrame& f : trial.frames)
    errors_s.push_back(
        trial.exchanges.empty()
            ? std::numeric_limits<double>::quiet_NaN()
            : seconds(f.stamp.arrival_ns + printed_exchange(trial.exchanges.front()).error_ns - f.sent.ns));
  return errors_s;
}

// Frames and exchanges come in the order of their arrival at the server.
std::vector<double> as_printed(const ClockTrial& trial, bool on_client_clock) {
  std::vector<double> errors_s;
  std::size_t next = 0;
  std::optional<PrintedExchange> latest;
  for (const TrialFrame& f : trial.frames) {
    for (; next < trial.exchanges.size() && trial.exchanges[next].t4_ns <= f.received.ns; ++next)
      latest = printed_exchange(trial.exchanges[next]);
    if (!latest) {
      errors_s.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    const std::int64_t sent_ns = f.received.ns - latest->delay_ns - latest->error_ns;  // equation 22
    errors_s.push_back(seconds(sent_ns - (on_client_clock ? f.stamp.arrival_ns : f.sent.ns)));
  }
  return errors_s;
}

std::vector<double> by_fit(const ClockTrial& trial) {
  const AgentClock clock = fit_agent_clock(trial.exchanges);
  std::vector<double> errors_s;
  for (const TrialFrame& f : trial.frames)
    errors_s.push_back(clock.segments.empty() ? std::numeric_limits<double>::quiet_NaN()
                                              : seconds((clock({f.stamp.arrival_ns}) - f.sent).ns));
  return errors_s;
}

std::vector<double> by_ticks(const ClockTrial& trial) {
  const auto each_stamp = [&](const std::function<void(const FrameStamp&)>& take) {
    for (const TrialFrame& f : trial.frames) take(f.stamp);
  };
  const SensorClockMap clock = fit_sensor_clock(trial.sensor, each_stamp, trial.exchanges, trial.sensor.name);
  std::vector<double> errors_s;
  for (const TrialFrame& f : trial.frames)
    errors_s.push_back(trial.exchanges.empty() ? std::numeric_limits<double>::quiet_NaN()
                                               : seconds((clock(f.stamp) - f.exposure).ns));
  return errors_s;
}

}  // namespace

const std::vector<std::string>& clock_method_names() {
  static const std::vector<std::string> names{"none",
                                              "one exchange at the start",
                                              "as printed, for the server's clock",
                                              "as printed, on the client's clock",
                                              "corrected",
                                              "corrected, by the sensor's ticks"};
  return names;
}

std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method) {
  switch (method) {
    case ClockMethod::none:
      break;
    case ClockMethod::first_exchange:
      return by_first_exchange(trial);
    case ClockMethod::printed:
      return as_printed(trial, false);
    case ClockMethod::printed_client:
      return as_printed(trial, true);
    case ClockMethod::corrected:
      return by_fit(trial);
    case ClockMethod::corrected_ticks:
      return by_ticks(trial);
  }
  return without_exchanges(trial);
}

}  // namespace trilat
