// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "datasets/base/philox.h"
#include "datasets/session/clock/session_clock.h"

namespace trilat {

// A sensor on a PC of its own, with true clocks that a test can ask. Times in seconds from the start.
struct SimulatedClocks {
  static constexpr std::int64_t kStart_ns = 1'000'000'000'000;

  std::uint64_t seed = 1;
  double seconds = 600.0;
  double agent_drift_ppm = 30.0, sensor_drift_ppm = -30.0;
  double sine_ms = 0.0, sine_period_s = 300.0;                // of both clocks
  double wire_ms = 0.2, asymmetry_ms = 0.0, jitter_ms = 0.5;  // asymmetry: more on the way to the agent
  double jitter_back_ms = -1.0;  // on the way to the host; below 0: as the other way
  double exchange_every_s = 0.25, exchanges_until_s = 1e9, lost_share = 0.0;
  double burst_every_s = 0.0, burst_length_s = 0.0, burst_ms = 0.0;  // of delay, on both ways and of frames
  double agent_step_at_s = 1e9, agent_step_s = 0.0;
  double sensor_restart_at_s = 1e9;
  std::int64_t tick_ns = 100;
  std::int64_t first_tick = 123'456'789;
  double arrival_jitter_ms = 1.0;

  double uniform(std::uint64_t purpose, std::uint64_t number, std::uint32_t index = 0) const {
    return RandomStream{seed, Purpose::test, random_item(purpose, 0, 0, number)}.uniform(index);
  }
  double jitter_s(double mean_ms, std::uint64_t purpose, std::uint64_t number) const {
    return -1e-3 * mean_ms * std::log(uniform(purpose, number));
  }
  bool in_burst(double t_s) const {
    return burst_every_s > 0.0 && std::fmod(t_s, burst_every_s) < burst_length_s;
  }
  double sine_s(double t_s) const { return 1e-3 * sine_ms * std::sin(2.0 * M_PI * t_s / sine_period_s); }
  std::int64_t agent_ns(double t_s) const {
    double agent_s = 5000.0 + t_s * (1.0 + 1e-6 * agent_drift_ppm) + sine_s(t_s);
    if (t_s >= agent_step_at_s) agent_s += agent_step_s;
    return std::llround(agent_s * 1e9);
  }
  std::int64_t ticks(double t_s) const {
    const double since_s = t_s < sensor_restart_at_s ? t_s : t_s - sensor_restart_at_s;
    const auto ns = std::llround((since_s * (1.0 + 1e-6 * sensor_drift_ppm) + sine_s(t_s)) * 1e9);
    return (t_s < sensor_restart_at_s ? first_tick : 1000) + ns / tick_ns;
  }

  std::vector<ClockExchange> exchanges() const {
    std::vector<ClockExchange> all;
    const auto count = static_cast<std::uint64_t>(std::min(seconds, exchanges_until_s) / exchange_every_s);
    const double back_ms = jitter_back_ms < 0.0 ? jitter_ms : jitter_back_ms;
    for (std::uint64_t i = 0; i <= count; ++i) {
      if (uniform(3, i) < lost_share) continue;
      const double sent_s = static_cast<double>(i) * exchange_every_s;
      const double more_s = in_burst(sent_s) ? 1e-3 * burst_ms : 0.0;
      const double out_s =
          1e-3 * (wire_ms + asymmetry_ms) + jitter_s(jitter_ms, 1, i) + more_s * uniform(4, i);
      const double back_s = 1e-3 * wire_ms + jitter_s(back_ms, 2, i) + more_s * uniform(5, i);
      const double there_s = sent_s + out_s, answered_s = there_s + 50e-6;
      all.push_back({kStart_ns + std::llround(sent_s * 1e9), agent_ns(there_s), agent_ns(answered_s),
                     kStart_ns + std::llround((answered_s + back_s) * 1e9)});
    }
    return all;
  }

  struct Frame {
    FrameStamp stamp;
    HostTime exposure;
  };
  std::vector<Frame> frames() const {
    std::vector<Frame> all;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(seconds * 30.0); ++i) {
      if (uniform(7, i) < lost_share) continue;
      const double t_s = (static_cast<double>(i) + 0.3) / 30.0;
      const double late_s =
          jitter_s(arrival_jitter_ms, 6, i) + (in_burst(t_s) ? 1e-3 * burst_ms * uniform(8, i) : 0.0);
      all.push_back({{static_cast<std::int64_t>(i), ticks(t_s), agent_ns(t_s + late_s)},
                     {kStart_ns + std::llround(t_s * 1e9)}});
    }
    return all;
  }
};

struct ClockErrors {
  std::vector<double> ms;  // absolute, rising
  SensorClockMap map;

  double max_ms() const { return ms.back(); }
  double quantile_ms(double share) const {
    return ms[static_cast<std::size_t>(share * static_cast<double>(ms.size() - 1))];
  }
  double share_within(double limit_ms) const {
    return static_cast<double>(std::ranges::upper_bound(ms, limit_ms) - ms.begin()) /
           static_cast<double>(ms.size());
  }
};

inline SensorClockMap fitted(const SimulatedClocks& clocks, const std::vector<SimulatedClocks::Frame>& frames,
                             const std::vector<ClockExchange>& exchanges) {
  SensorDescription sensor;
  sensor.name = "k1";
  sensor.tick_ns = clocks.tick_ns;
  const auto each = [&](const std::function<void(const FrameStamp&)>& take) {
    for (const auto& frame : frames) take(frame.stamp);
  };
  return fit_sensor_clock(sensor, each, exchanges, "k1");
}

// How far every frame's time is off, after the fit.
inline ClockErrors clock_errors(const SimulatedClocks& clocks) {
  const auto frames = clocks.frames();
  ClockErrors errors;
  errors.map = fitted(clocks, frames, clocks.exchanges());
  for (const auto& frame : frames)
    errors.ms.push_back(std::abs((errors.map(frame.stamp) - frame.exposure).seconds()) * 1e3);
  std::ranges::sort(errors.ms);
  return errors;
}

}  // namespace trilat
