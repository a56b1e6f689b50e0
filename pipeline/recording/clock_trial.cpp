// SPDX-License-Identifier: MIT
#include "pipeline/recording/clock_trial.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

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
