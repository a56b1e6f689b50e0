// SPDX-License-Identifier: MIT
#include "pipeline/recording_study/clock_trial.h"

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

}  // namespace

ClockTrial simulate_clocks(const RecordingSpec& spec, const NetworkSpec& network, std::uint64_t run,
                           std::uint64_t sensor) {
  const Draws draws(spec, run, sensor);
  const TrueClocks clocks = draw_clocks(spec, draws.of(Purpose::sensor_clock, 0));
  ClockTrial trial;
  trial.sensor.name = fmt::format("k{}", sensor + 1);
  trial.sensor.latency_ns = duration_from_s(spec.latency_s).ns;
  const double duration_s = static_cast<double>(spec.frames) / spec.rate_hz;
  const Duration there = duration_from_s(network.wire_s + network.asymmetry_s),
                 back = duration_from_s(network.wire_s);
  const double jitter_back_s = network.jitter_back_s.value_or(network.jitter_s);
  for (std::uint64_t e = 0; static_cast<double>(e) * spec.exchange_period_s <= duration_s; ++e) {
    const RandomStream random = draws.of(Purpose::clock_exchange, e);
    if (random.uniform(0) < network.lost_share) continue;
    const HostTime t1 = kStart + duration_from_s(static_cast<double>(e) * spec.exchange_period_s);
    const HostTime t2 = t1 + there + exponential(random, 1, network.jitter_s);
    const HostTime t3 = t2 + duration_from_s(kAnswer_s);
    const HostTime t4 = t3 + back + exponential(random, 2, jitter_back_s);
    trial.exchanges.push_back({t1.ns, clocks.agent_from_host(t2).ns, clocks.agent_from_host(t3).ns, t4.ns});
  }
  for (std::uint64_t f = 0; f < spec.frames; ++f) {
    const RandomStream random = draws.of(Purpose::arrival_delay, f);
    TrialFrame frame;
    frame.exposure = kStart + duration_from_s((static_cast<double>(f) + clocks.phase) / spec.rate_hz);
    frame.sent =
        frame.exposure + duration_from_s(spec.latency_s) + exponential(random, 0, spec.arrival_jitter_s);
    frame.received = frame.sent + back + exponential(random, 1, jitter_back_s);
    frame.stamp = {static_cast<std::int64_t>(f),
                   clocks.sensor_from_host(frame.exposure).ns / trial.sensor.tick_ns,
                   clocks.agent_from_host(frame.sent).ns};
    trial.frames.push_back(frame);
  }
  return trial;
}

}  // namespace trilat
