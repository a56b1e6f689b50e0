// SPDX-License-Identifier: MIT
#include "datasets/session/clock/session_clock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"

namespace trilat {
namespace {

using SensorLine = ClockMap<HostClock, SensorClock>;

constexpr double kMaxDrift = 1e-3;
constexpr double kDriftSigmas = 4.0;
constexpr std::int64_t kDriftDivisor = 1000;                 // the same, of the time between two frames
constexpr std::int64_t kMaxTime_ns = std::int64_t{1} << 59;  // so that sums of some times cannot overflow
constexpr Duration kMaxAgentDeviation{20'000'000};
constexpr Duration kMaxStep{100'000'000};     // of the arrival delay from one frame to the next
constexpr Duration kMinEpoch{2'000'000'000};  // shorter ones may be frames that came late together
constexpr Duration kMinDriftCheck{5'000'000'000}, kMinDriftSpan{10'000'000'000};
constexpr Duration kWindow{10'000'000'000};
constexpr std::size_t kMinWindowFrames = 30;
constexpr std::uint64_t kBlock = 4096;

void check_time(std::int64_t ns, const std::string& place) {
  if (ns > kMaxTime_ns || ns < -kMaxTime_ns)
    throw InputError(place, "hold a time beyond 18 years, which no clock shows");
}

AgentClock checked_agent_clock(std::span<const ClockExchange> exchanges, const std::string& place) {
  for (const ClockExchange& e : exchanges)
    for (const std::int64_t ns : {e.t1_ns, e.t2_ns, e.t3_ns, e.t4_ns}) check_time(ns, place);
  AgentClock agent = fit_agent_clock(exchanges);
  if (std::abs(agent.line.drift) > kMaxDrift)
    throw InputError(place, fmt::format("give a drift of {:.0f} ppm between two machines, which no clock has",
                                        1e6 * agent.line.drift));
  if (agent.deviation > kMaxAgentDeviation)
    throw InputError(
        place, fmt::format("leave a straight line by {:.0f} ms {:.0f} s after the first: the clock of the "
                           "sensor's computer was set while recording, so its frames cannot be placed",
                           1e3 * agent.deviation.seconds(), agent.deviation_after.seconds()));
  return agent;
}

// One frame's stamps: on the sensor's clock, and its arrival on the host clock.
struct ArrivalStamp {
  SensorTime device;
  HostTime arrival;

  Duration arrival_delay() const { return {arrival.ns - device.ns}; }
};

// Lower convex hull of (device, arrival); frames that do not rise on the sensor's clock are left out.
class ArrivalEnvelope {
 public:
  void add(const ArrivalStamp& stamp) {
    if (!hull_.empty() && stamp.device <= hull_.back().device) return;
    // slopes near one: compare arrival - device, which keeps the digits
    const auto turns_up = [](const ArrivalStamp& a, const ArrivalStamp& b, const ArrivalStamp& c) {
      const double ab = static_cast<double>((b.device - a.device).ns);
      const double ac = static_cast<double>((c.device - a.device).ns);
      const double lag_b = static_cast<double>((b.arrival_delay() - a.arrival_delay()).ns);
      const double lag_c = static_cast<double>((c.arrival_delay() - a.arrival_delay()).ns);
      return lag_b * ac < lag_c * ab;
    };
    while (hull_.size() >= 2 && !turns_up(hull_[hull_.size() - 2], hull_.back(), stamp)) hull_.pop_back();
    hull_.push_back(stamp);
  }
  // The segment under the middle; one stamp gives drift 0.
  SensorLine line() const {
    TRILAT_CHECK(!hull_.empty(), "an envelope has points");
    if (hull_.size() == 1) return {hull_[0].device, hull_[0].arrival, 0.0};
    const SensorTime middle{hull_.front().device.ns + (hull_.back().device - hull_.front().device).ns / 2};
    std::size_t right = 1;
    while (right + 1 < hull_.size() && hull_[right].device < middle) ++right;
    const ArrivalStamp& a = hull_[right - 1];
    const ArrivalStamp& b = hull_[right];
    const double lag_ns = static_cast<double>((b.arrival_delay() - a.arrival_delay()).ns);
    return {a.device, a.arrival, lag_ns / static_cast<double>((b.device - a.device).ns)};
  }
  // The line of this drift that no frame lies under.
  SensorLine line_of(double drift) const {
    const SensorLine through_first{hull_.front().device, hull_.front().arrival, drift};
    const ArrivalStamp& least = *std::ranges::min_element(hull_, {}, [&](const ArrivalStamp& stamp) {
      return (stamp.arrival - through_first(stamp.device)).ns;
    });
    return {least.device, least.arrival, drift};
  }
  const ArrivalStamp& front() const { return hull_.front(); }
  const ArrivalStamp& back() const { return hull_.back(); }
  void add(const ArrivalEnvelope& more) {
    for (const ArrivalStamp& stamp : more.hull_) add(stamp);
  }

 private:
  std::vector<ArrivalStamp> hull_;
};

// Frames between two restarts of a sensor's count of ticks.
struct TickEpoch {
  SensorTime first, last;
  std::uint64_t frames = 0;
  ArrivalEnvelope envelope;

  Duration span() const { return last - first; }
  void add(const ArrivalStamp& stamp) {
    if (frames == 0) first = last = stamp.device;
    last = std::max(last, stamp.device);
    ++frames;
    envelope.add(stamp);
  }
  void add(const TickEpoch& more) {
    last = std::max(last, more.last);
    frames += more.frames;
    envelope.add(more.envelope);
  }
};

// Whether ticks and arrivals go on from `a` to `b` as one clock.
bool is_continuous(const ArrivalStamp& a, const ArrivalStamp& b) {
  const std::int64_t gap_ns =
      std::min(std::abs((b.device - a.device).ns), std::abs((b.arrival - a.arrival).ns));
  return std::abs((b.arrival_delay() - a.arrival_delay()).ns) <= kMaxStep.ns + gap_ns / kDriftDivisor;
}

// Parts a sensor's frames, in the order of the recording, where ticks and arrivals no longer go together.
class TickEpochs {
 public:
  void add(const ArrivalStamp& stamp) {
    if (runs_.empty() || !is_continuous(before_, stamp)) runs_.emplace_back();
    runs_.back().add(stamp);
    before_ = stamp;
  }
  // Without frames that came late together for less than 2 s.
  std::vector<TickEpoch> finish() const {
    std::vector<TickEpoch> kept;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const TickEpoch& run = runs_[i];
      const bool is_behind = !kept.empty() && run.first > kept.back().last;
      const bool is_before = i + 1 < runs_.size() && run.last < runs_[i + 1].first;
      if (run.span() < kMinEpoch &&
          ((is_behind && is_later(run.envelope.front(), kept.back().envelope.back())) ||
           (is_before && is_later(run.envelope.back(), runs_[i + 1].envelope.front()))))
        continue;
      if (is_behind && is_continuous(kept.back().envelope.back(), run.envelope.front()))
        kept.back().add(run);
      else
        kept.push_back(run);
    }
    return kept;
  }

 private:
  static bool is_later(const ArrivalStamp& a, const ArrivalStamp& b) {
    const Duration more = a.arrival_delay() - b.arrival_delay();
    return more > Duration{} && more < kMinEpoch;
  }

  std::vector<TickEpoch> runs_;
  ArrivalStamp before_;
};

bool has_odd_drift(const TickEpoch& epoch) {
  return std::abs(epoch.envelope.line().drift) > kMaxDrift && epoch.span() < kMinDriftCheck;
}

// In less than 5 s jitter of the arrivals looks like drift, and so does what the agent's own drift is
// uncertain by.
SensorLine line_of(const TickEpoch& epoch, const AgentClock& agent, const std::string& place) {
  if (has_odd_drift(epoch)) return epoch.envelope.line_of(0.0);
  const SensorLine line = epoch.envelope.line();
  if (std::abs(line.drift) > kMaxDrift + kDriftSigmas * agent.drift_sigma)
    throw InputError(place, fmt::format("has a clock that drifts by {:.0f} ppm against arrival times; check "
                                        "tick_ns and arrival_ns, and whether the computer kept up",
                                        1e6 * line.drift));
  return line;
}

// A sensor keeps its crystal when it is restarted: short epochs take the longest one's drift.
std::vector<SensorEpoch> fit_epochs(const std::vector<TickEpoch>& ticks, const TickEpoch& longest,
                                    const AgentClock& agent, const std::string& place) {
  const SensorLine line = line_of(longest, agent, place);
  std::vector<SensorEpoch> epochs;
  for (const TickEpoch& epoch : ticks)
    epochs.push_back({epoch.first, epoch.last, epoch.frames,
                      &epoch == &longest              ? line
                      : epoch.span() >= kMinDriftSpan ? line_of(epoch, agent, place)
                                                      : epoch.envelope.line_of(line.drift)});
  return epochs;
}

std::int64_t outside_ns(const SensorEpoch& epoch, SensorTime t) {
  return std::max({std::int64_t{0}, (epoch.first - t).ns, (t - epoch.last).ns});
}

// The largest arrival delay that all frames of some ten seconds have.
void find_deviation(StampEvidence& evidence, const std::vector<FrameStamp>& stamps,
                    const std::vector<Duration>& arrival_delay) {
  for (std::size_t first = 0, end = 0; first < stamps.size(); first = end) {
    while (end < stamps.size() && stamps[end].arrival_ns - stamps[first].arrival_ns < kWindow.ns) ++end;
    end = std::max(end, first + 1);
    if (end - first < kMinWindowFrames) continue;
    const Duration least = *std::min_element(arrival_delay.begin() + static_cast<std::ptrdiff_t>(first),
                                             arrival_delay.begin() + static_cast<std::ptrdiff_t>(end));
    if (least <= evidence.deviation) continue;
    evidence.deviation = least;
    evidence.deviation_after = {stamps[first].arrival_ns - stamps[0].arrival_ns};
  }
}

StampEvidence fit_report(const SensorClockMap& map, const std::vector<FrameStamp>& stamps) {
  StampEvidence evidence;
  std::vector<Duration> arrival_delay;
  for (const FrameStamp& stamp : stamps) {
    const OffsetUncertainty uncertainty = map.agent.uncertainty({stamp.arrival_ns});
    evidence.uncertainty = {std::max(evidence.uncertainty.sigma_ns, uncertainty.sigma_ns),
                            std::max(evidence.uncertainty.bound_ns, uncertainty.bound_ns),
                            std::max(evidence.uncertainty.outside, uncertainty.outside)};
    arrival_delay.push_back(map.agent({stamp.arrival_ns}) - (map(stamp) + map.latency));
  }
  find_deviation(evidence, stamps, arrival_delay);
  const auto quantile = [&](std::size_t percent) {
    const auto at =
        arrival_delay.begin() + static_cast<std::ptrdiff_t>((arrival_delay.size() - 1) * percent / 100);
    std::nth_element(arrival_delay.begin(), at, arrival_delay.end());
    return *at;
  };
  evidence.lateness_median = quantile(50);
  evidence.lateness_p99 = quantile(99);
  return evidence;
}

// The frames by whose stamps a sensor's clock is known: bodies, else depth.
std::pair<FrameStream, std::uint64_t> stamped_frames(const SessionReader& session, std::size_t sensor) {
  const SensorCounts& counts = session.counts(sensor);
  if (counts.body_frames > 0) return {FrameStream::bodies, counts.body_frames};
  return {FrameStream::depth, counts.depth_frames};
}

constexpr double kMinRate_hz = 1.0, kMaxRate_hz = 300.0;
constexpr std::array<std::int64_t, 4> kTickLengths_ns{100, 1, 1'000, 1'000'000};
bool is_kinect_rate(double rate_hz) { return rate_hz >= kMinRate_hz && rate_hz <= kMaxRate_hz; }

// Frames a second by ticks, if one lasted 1 ns, and by arrivals; 0 where neither rises.
struct FrameRates {
  double by_ticks_hz = 0.0, by_arrivals_hz = 0.0;
};

FrameRates frame_rates(const std::vector<FrameStamp>& stamps) {
  const auto rate_hz = [&](std::int64_t FrameStamp::*clock) {
    std::vector<double> steps;  // a file may hold any integers
    for (std::size_t i = 1; i < stamps.size(); ++i)
      if (stamps[i].*clock > stamps[i - 1].*clock)
        steps.push_back(static_cast<double>(stamps[i].*clock) - static_cast<double>(stamps[i - 1].*clock));
    return steps.empty() ? 0.0 : 1e9 / std::max(1.0, upper_median(steps));
  };
  return {rate_hz(&FrameStamp::device_ticks), rate_hz(&FrameStamp::arrival_ns)};
}

// Problem of the units of a sensor's ticks or arrivals: they give other rates of frames, which another unit
// explains, or frames come less than once or more than 300 times a second. Nothing for fewer than three
// frames.
std::optional<std::string> odd_rates_text(const SessionReader& session, std::size_t sensor) {
  constexpr std::uint64_t kMaxLooked = 1024;
  constexpr double kAgree = 0.25;  // of ticks and arrivals, which jitter
  const auto [stream, frames] = stamped_frames(session, sensor);
  if (frames < 3) return std::nullopt;
  const FrameRates rates = frame_rates(session.stamps(sensor, stream, 0, std::min(frames, kMaxLooked)));
  const std::int64_t tick_ns = session.header().sensors[sensor].tick_ns;
  const double by_ticks_hz = rates.by_ticks_hz / static_cast<double>(tick_ns);
  if (rates.by_ticks_hz == 0.0) return std::nullopt;
  const auto agrees = [&](double rate_hz) { return std::abs(rate_hz / rates.by_arrivals_hz - 1.0) < kAgree; };
  if (is_kinect_rate(rates.by_arrivals_hz)) {
    if (agrees(by_ticks_hz)) return std::nullopt;
    for (const std::int64_t of_ns : kTickLengths_ns)
      if (agrees(rates.by_ticks_hz / static_cast<double>(of_ns)))
        return fmt::format(
            "has {:.6g} frames a second by device ticks of {} ns, and {:.4g} by their arrivals; with "
            "ticks of {} ns both agree: write the session again with that tick_ns",
            by_ticks_hz, tick_ns, rates.by_arrivals_hz, of_ns);
  } else if (is_kinect_rate(by_ticks_hz)) {
    for (const auto& [unit, of_ns] : {std::pair{"microseconds", 1e3}, {"milliseconds", 1e6}})
      if (std::abs(by_ticks_hz * of_ns / rates.by_arrivals_hz - 1.0) < kAgree)
        return fmt::format(
            "has {:.6g} frames a second by arrival_ns, and {:.4g} by device ticks; arrivals in {} would "
            "agree: write them in nanoseconds",
            rates.by_arrivals_hz, by_ticks_hz, unit);
  }
  if (is_kinect_rate(by_ticks_hz)) return std::nullopt;
  std::string remedy;
  for (const std::int64_t of_ns : kTickLengths_ns)
    if (const double rate_hz = rates.by_ticks_hz / static_cast<double>(of_ns);
        is_kinect_rate(rate_hz) && remedy.empty())
      remedy = fmt::format("; with ticks of {} ns it has {:.4g}: write the session again with that tick_ns",
                           of_ns, rate_hz);
  return fmt::format("has {:.6g} frames a second by device ticks of {} ns, where a Kinect makes 30{}",
                     by_ticks_hz, tick_ns, remedy);
}

}  // namespace

SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp) {
  return {stamp.device_ticks * sensor.tick_ns};
}

HostTime SensorClockMap::operator()(const FrameStamp& stamp) const {
  if (live) return live({stamp.arrival_ns}) - latency;
  const SensorTime device{stamp.device_ticks * tick_ns};
  if (epochs.size() == 1) return (*this)(device);
  HostTime best;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (const SensorEpoch& epoch : epochs) {
    const HostTime host = epoch.line(device);
    const std::int64_t distance_ns =
        outside_ns(epoch, device) + std::abs((agent({stamp.arrival_ns}) - host).ns);
    if (distance_ns >= least_ns) continue;
    least_ns = distance_ns;
    best = host - latency;
  }
  return best;
}

HostTime SensorClockMap::operator()(SensorTime t) const {
  if (epochs.empty()) return {t.ns};
  return std::ranges::min_element(epochs, {}, [&](const SensorEpoch& e) { return outside_ns(e, t); })
             ->line(t) -
         latency;
}

std::optional<std::string> arrival_jump_text(const SensorClockMap& clock) {
  constexpr Duration kMaxTickStep{1'000'000'000};
  for (std::size_t k = 1; k < clock.epochs.size(); ++k) {
    const SensorEpoch &before = clock.epochs[k - 1], &after = clock.epochs[k];
    const Duration step = after.first - before.last;
    if (step <= Duration{} || step > kMaxTickStep) continue;
    const double jump_s = (after.line(after.first) - before.line(after.first)).seconds() /
                          (1.0 + clock.agent.line.drift);  // on the clock of the arrivals
    return fmt::format(
        "arrivals jump by {:.2f} s, {:.1f} s after its first frame, while its ticks go on: the clock that "
        "stamps them was set. Times before and after do not belong together; {} {:.3f} s {} the arrivals "
        "from there on",
        jump_s, (after.first - clock.epochs.front().first).seconds(), jump_s > 0.0 ? "take" : "add",
        std::abs(jump_s), jump_s > 0.0 ? "from" : "to");
  }
  return std::nullopt;
}

SensorClockMap fit_sensor_clock(const SensorDescription& sensor, const EachStamp& each_stamp,
                                std::span<const ClockExchange> exchanges, const std::string& place) {
  SensorClockMap map;
  map.tick_ns = sensor.tick_ns;
  map.latency = {sensor.latency_ns};
  map.agent = checked_agent_clock(exchanges, place + "/clock_exchanges_ns");
  TickEpochs ticks;
  std::vector<FrameStamp> stamps;
  each_stamp([&](const FrameStamp& stamp) {
    check_time(stamp.arrival_ns, place);
    if (std::abs(stamp.device_ticks) > kMaxTime_ns / sensor.tick_ns) check_time(kMaxTime_ns + 1, place);
    ticks.add({device_time(sensor, stamp), map.agent({stamp.arrival_ns})});
    stamps.push_back(stamp);
  });
  const std::vector<TickEpoch> epochs = ticks.finish();
  if (epochs.empty()) throw InputError(place, "has no frames, so its clock cannot be placed");
  const TickEpoch& longest = *std::ranges::max_element(epochs, {}, &TickEpoch::span);
  map.epochs = fit_epochs(epochs, longest, map.agent, place);
  map.stamps = fit_report(map, stamps);
  if (has_odd_drift(longest)) map.stamps.drift_left_out = longest.envelope.line().drift;
  return map;
}

SensorClockMap fit_sensor_clock(const SessionReader& session, std::size_t sensor) {
  const SensorDescription& description = session.header().sensors.at(sensor);
  const std::string place = session.path().string() + ":/sensors/" + description.name;
  if (const auto text = odd_rates_text(session, sensor)) throw InputError(place, *text);
  const auto [stream, frames] = stamped_frames(session, sensor);
  const auto each_stamp = [&](const std::function<void(const FrameStamp&)>& take) {
    for (std::uint64_t first = 0; first < frames; first += kBlock)
      for (const FrameStamp& stamp : session.stamps(sensor, stream, first, std::min(kBlock, frames - first)))
        take(stamp);
  };
  return fit_sensor_clock(description, each_stamp, session.clock_exchanges(sensor), place);
}

}  // namespace trilat
