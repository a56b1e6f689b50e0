// SPDX-License-Identifier: MIT
#include "pipeline/recording/clock_methods.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

namespace trilat {
namespace {

constexpr std::size_t kRecentExchanges = 8;

// The server's view: D and E of equation 21.
struct PrintedExchange {
  std::int64_t delay_ns, error_ns;
};

PrintedExchange printed_exchange(const ClockExchange& e) {
  return {((e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns)) / 2, ((-e.t2_ns + e.t1_ns) + (e.t4_ns - e.t3_ns)) / 2};
}

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

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

// `error_ns` of each frame and the exchanges that the server had when it received it, at least one. Frames
// and exchanges come in the order of their arrival at the server.
template <typename ErrorNs>
std::vector<double> by_known_exchanges(const ClockTrial& trial, const ErrorNs& error_ns) {
  const std::span<const ClockExchange> all(trial.exchanges);
  std::vector<double> errors_s;
  std::size_t known = 0;
  for (const TrialFrame& f : trial.frames) {
    while (known < all.size() && all[known].t4_ns <= f.received.ns) ++known;
    errors_s.push_back(known == 0 ? std::numeric_limits<double>::quiet_NaN()
                                  : seconds(error_ns(f, all.first(known))));
  }
  return errors_s;
}

using KnownExchanges = std::span<const ClockExchange>;

std::int64_t printed_sent_ns(const TrialFrame& f, KnownExchanges known) {
  const PrintedExchange latest = printed_exchange(known.back());
  return f.received.ns - latest.delay_ns - latest.error_ns;  // equation 22
}

std::vector<double> as_printed(const ClockTrial& trial) {
  return by_known_exchanges(
      trial, [](const TrialFrame& f, KnownExchanges known) { return printed_sent_ns(f, known) - f.sent.ns; });
}

std::vector<double> as_printed_on_client(const ClockTrial& trial) {
  return by_known_exchanges(trial, [](const TrialFrame& f, KnownExchanges known) {
    return printed_sent_ns(f, known) - f.stamp.arrival_ns;
  });
}

std::vector<double> by_least_delay(const ClockTrial& trial) {
  return by_known_exchanges(trial, [](const TrialFrame& f, KnownExchanges known) {
    const KnownExchanges recent = known.last(std::min(kRecentExchanges, known.size()));
    const auto delay_ns = [](const ClockExchange& e) { return printed_exchange(e).delay_ns; };
    const ClockExchange& best = *std::ranges::min_element(recent, {}, delay_ns);
    return f.stamp.arrival_ns + printed_exchange(best).error_ns - f.sent.ns;
  });
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

struct MethodRow {
  const char* name;
  std::vector<double> (*errors_s)(const ClockTrial&);
};

// In the order of ClockMethod.
constexpr std::array<MethodRow, 7> kMethods{{{"none", without_exchanges},
                                             {"one exchange at the start", by_first_exchange},
                                             {"as printed, for the server's clock", as_printed},
                                             {"as printed, on the client's clock", as_printed_on_client},
                                             {"corrected", by_fit},
                                             {"corrected, causal", by_least_delay},
                                             {"corrected, by the sensor's ticks", by_ticks}}};

}  // namespace

const std::vector<std::string>& clock_method_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const MethodRow& row : kMethods) list.push_back(row.name);
    return list;
  }();
  return names;
}

std::vector<double> clock_errors_s(const ClockTrial& trial, ClockMethod method) {
  return kMethods.at(static_cast<std::size_t>(method)).errors_s(trial);
}

}  // namespace trilat
