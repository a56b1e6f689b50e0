// SPDX-License-Identifier: MIT
#include "pipeline/recording/clock_methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "datasets/base/philox.h"

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
    errors_s.push_back(clock.exchanges_used == 0 ? std::numeric_limits<double>::quiet_NaN()
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

constexpr HostTime kStart{1'000'000'000'000};
constexpr double kAnswer_s = 0.00005;

class Draws {
 public:
  Draws(const RecordingSpec& spec, std::uint64_t run, std::uint64_t sensor)
      : seed_(spec.seed), run_(run), sensor_(sensor) {}
  RandomStream of(Purpose purpose, std::uint64_t step) const {
    return {seed_, purpose, random_item(run_, sensor_, 2, step)};
  }

 private:
  std::uint64_t seed_, run_, sensor_;
};

Duration exponential(const RandomStream& random, std::uint32_t index, double mean_s) {
  return duration_from_s(-mean_s * std::log(random.uniform(index)));
}

struct TrueClocks {
  ClockMap<AgentTag, HostClock> agent_from_host;
  ClockMap<SensorClock, HostClock> sensor_from_host;
  double phase = 0.0;  // of the frames, in periods
};

TrueClocks draw_clocks(const RecordingSpec& spec, const RandomStream& random) {
  const double drift = 1e-6 * spec.clock_drift_ppm;
  const Duration offset = duration_from_s(random.uniform(0, -spec.clock_offset_s, spec.clock_offset_s));
  const Duration since_power_on = duration_from_s(random.uniform(1, 0.0, 1000.0));
  return {{kStart, {kStart.ns + offset.ns}, random.uniform(2, -drift, drift)},
          {kStart, {since_power_on.ns}, random.uniform(3, -drift, drift)},
          random.uniform(4)};
}

// How long a message takes.
struct Delays {
  Duration there, back;  // at least
  double jitter_there_s = 0.0, jitter_back_s = 0.0;
};

std::vector<ClockExchange> simulate_exchanges(const RecordingSpec& spec, double lost_share,
                                              const Draws& draws, const TrueClocks& clocks,
                                              const Delays& delays) {
  const double duration_s = static_cast<double>(spec.frames) / spec.rate_hz;
  std::vector<ClockExchange> exchanges;
  for (std::uint64_t e = 0; static_cast<double>(e) * spec.exchange_period_s <= duration_s; ++e) {
    const RandomStream random = draws.of(Purpose::clock_exchange, e);
    if (random.uniform(0) < lost_share) continue;
    const HostTime t1 = kStart + duration_from_s(static_cast<double>(e) * spec.exchange_period_s);
    const HostTime t2 = t1 + delays.there + exponential(random, 1, delays.jitter_there_s);
    const HostTime t3 = t2 + duration_from_s(kAnswer_s);
    const HostTime t4 = t3 + delays.back + exponential(random, 2, delays.jitter_back_s);
    exchanges.push_back({t1.ns, clocks.agent_from_host(t2).ns, clocks.agent_from_host(t3).ns, t4.ns});
  }
  return exchanges;
}

// The sensor exposes at the rate of its own clock.
TrialFrame simulate_frame(const RecordingSpec& spec, std::uint64_t f, const RandomStream& random,
                          const TrueClocks& clocks, const Delays& delays) {
  const Duration since_start = duration_from_s((static_cast<double>(f) + clocks.phase) / spec.rate_hz);
  const SensorTime exposed = clocks.sensor_from_host.origin_to + since_start;
  TrialFrame frame;
  frame.exposure = clocks.sensor_from_host.inverse()(exposed);
  frame.sent =
      frame.exposure + duration_from_s(spec.latency_s) + exponential(random, 0, spec.arrival_jitter_s);
  frame.received = frame.sent + delays.back + exponential(random, 1, delays.jitter_back_s);
  frame.stamp = {static_cast<std::int64_t>(f), exposed.ns / SensorDescription{}.tick_ns,
                 clocks.agent_from_host(frame.sent).ns};
  return frame;
}

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

ClockTrial simulate_clocks(const RecordingSpec& spec, const NetworkSpec& network, std::uint64_t run,
                           std::uint64_t sensor) {
  const Draws draws(spec, run, sensor);
  const TrueClocks clocks = draw_clocks(spec, draws.of(Purpose::sensor_clock, 0));
  const Delays delays{duration_from_s(network.wire_s + network.asymmetry_s), duration_from_s(network.wire_s),
                      network.jitter_s, network.jitter_back_s.value_or(network.jitter_s)};
  ClockTrial trial;
  trial.sensor.name = fmt::format("k{}", sensor + 1);
  trial.sensor.latency_ns = duration_from_s(spec.latency_s).ns;
  trial.exchanges = simulate_exchanges(spec, network.lost_share, draws, clocks, delays);
  for (std::uint64_t f = 0; f < spec.frames; ++f) {
    TrialFrame frame = simulate_frame(spec, f, draws.of(Purpose::arrival_delay, f), clocks, delays);
    if (f > 0) frame.received = std::max(frame.received, trial.frames.back().received);
    trial.frames.push_back(frame);
  }
  return trial;
}

}  // namespace trilat
