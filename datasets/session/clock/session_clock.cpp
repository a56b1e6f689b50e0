// SPDX-License-Identifier: MIT
#include "datasets/session/clock/session_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/clock/tick_epochs.h"

namespace trilat {
namespace {

constexpr double kMaxDrift = 1e-3;
constexpr double kMaxPieceDrift = 1e-1;                  // of some seconds, jitter included
constexpr std::int64_t kMostNs = std::int64_t{1} << 59;  // so that sums of some times cannot overflow
constexpr double kPpm = 1e6;
constexpr std::uint64_t kBlock = 4096;

void check_time(std::int64_t ns, const std::string& place) {
  if (ns > kMostNs || ns < -kMostNs)
    throw InputError(place, "hold a time beyond 18 years, which no clock shows");
}

AgentClock checked_agent_clock(std::span<const ClockExchange> exchanges, const std::string& place) {
  for (const ClockExchange& e : exchanges)
    for (std::int64_t ns : {e.t1_ns, e.t2_ns, e.t3_ns, e.t4_ns}) check_time(ns, place);
  AgentClock agent = fit_agent_clock(exchanges);
  const auto refuse = [&](double drift) {
    throw InputError(place, fmt::format("give a drift of {:.0f} ppm between two machines, which no clock has",
                                        drift * kPpm));
  };
  for (const AgentSegment& segment : agent.segments) {
    if (std::abs(segment.line.drift) > kMaxDrift) refuse(segment.line.drift);
    for (const auto& piece : segment.host_from_agent.pieces)
      if (std::abs(piece.map.drift) > kMaxPieceDrift) refuse(piece.map.drift);
  }
  return agent;
}

const ClockMap<HostClock, SensorClock>& checked(const ClockMap<HostClock, SensorClock>& line,
                                                const std::string& place) {
  if (std::abs(line.drift) > kMaxDrift)
    throw InputError(place, fmt::format("has a clock that drifts by {:.0f} ppm against arrival times; check "
                                        "tick_ns and arrival_ns, and whether the computer kept up",
                                        line.drift * kPpm));
  return line;
}

SensorEpoch fit_epoch(const TickEpoch& ticks, const ClockMap<HostClock, SensorClock>& line) {
  return {ticks.first, ticks.last, ticks.frames, line.drift, envelope_pieces(ticks, line)};
}

const TickEpoch& longest_of(const std::vector<TickEpoch>& ticks) {
  return *std::ranges::max_element(
      ticks, [](const auto& a, const auto& b) { return a.last - a.first < b.last - b.first; });
}

// A sensor keeps its crystal when it is restarted: short epochs take the longest one's drift.
std::vector<SensorEpoch> fit_epochs(const std::vector<TickEpoch>& ticks, const std::string& place) {
  const TickEpoch& longest = longest_of(ticks);
  const ClockMap<HostClock, SensorClock> line = checked(envelope_line(longest), place);
  std::vector<SensorEpoch> epochs;
  for (const TickEpoch& epoch : ticks)
    epochs.push_back(
        fit_epoch(epoch, &epoch == &longest ? line : checked(envelope_line(epoch, line.drift), place)));
  return epochs;
}

std::int64_t outside_ns(const SensorEpoch& epoch, SensorTime t) {
  return std::max({std::int64_t{0}, (epoch.first - t).ns, (t - epoch.last).ns});
}

// How far the arrival lies from where the epoch would have it.
std::int64_t arrival_distance_ns(const AgentClock& agent, AgentTime arrival, HostTime expected) {
  if (agent.segments.empty()) return std::abs(arrival.ns - expected.ns);
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (const AgentSegment& segment : agent.segments)
    least_ns = std::min(least_ns, std::abs((segment.host_from_agent(arrival) - expected).ns));
  return least_ns;
}

struct PlacedStamp {
  FrameStamp stamp;
  HostTime arrival;
};

StampEvidence evidence_of_stamps(const SensorClockMap& map, const std::vector<PlacedStamp>& placed) {
  StampEvidence evidence;
  std::vector<Duration> lateness;
  for (const auto& [stamp, arrival] : placed) {
    const OffsetDoubt doubt = map.agent.doubt({stamp.arrival_ns});
    evidence.doubt = {std::max(evidence.doubt.sigma_ns, doubt.sigma_ns),
                      std::max(evidence.doubt.bound_ns, doubt.bound_ns),
                      std::max(evidence.doubt.outside, doubt.outside)};
    lateness.push_back(arrival - (map(stamp) + map.latency));
  }
  const auto quantile = [&](std::size_t percent) {
    const auto at = lateness.begin() + static_cast<std::ptrdiff_t>((lateness.size() - 1) * percent / 100);
    std::nth_element(lateness.begin(), at, lateness.end());
    return *at;
  };
  evidence.lateness_median = quantile(50);
  evidence.lateness_p99 = quantile(99);
  return evidence;
}

}  // namespace

SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp) {
  return {stamp.device_ticks * sensor.tick_ns};
}

HostTime SensorClockMap::operator()(const FrameStamp& stamp) const {
  const SensorTime device{stamp.device_ticks * tick_ns};
  if (epochs.size() == 1) return (*this)(device);
  HostTime best;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (const SensorEpoch& epoch : epochs) {
    const HostTime host = epoch.host_from_sensor(device);
    const std::int64_t distance_ns =
        outside_ns(epoch, device) + arrival_distance_ns(agent, {stamp.arrival_ns}, host);
    if (distance_ns >= least_ns) continue;
    least_ns = distance_ns;
    best = host - latency;
  }
  return best;
}

HostTime SensorClockMap::operator()(SensorTime t) const {
  if (epochs.empty()) return {t.ns};
  return std::ranges::min_element(
             epochs, [&](const auto& a, const auto& b) { return outside_ns(a, t) < outside_ns(b, t); })
             ->host_from_sensor(t) -
         latency;
}

SensorClockMap fit_sensor_clock(const SensorDescription& sensor, const EachStamp& each_stamp,
                                std::span<const ClockExchange> exchanges, const std::string& place) {
  SensorClockMap map;
  map.tick_ns = sensor.tick_ns;
  map.latency = {sensor.latency_ns};
  map.agent = checked_agent_clock(exchanges, place + "/clock_exchanges_ns");
  HostArrivals arrivals(map.agent);
  TickEpochs ticks(sensor.tick_ns);
  std::vector<PlacedStamp> placed;
  each_stamp([&](const FrameStamp& stamp) {
    check_time(stamp.arrival_ns, place);
    if (std::abs(stamp.device_ticks) > kMostNs / sensor.tick_ns) check_time(kMostNs + 1, place);
    const HostArrival arrival = arrivals.place(device_time(sensor, stamp), {stamp.arrival_ns});
    ticks.add(stamp.device_ticks, arrival.time, arrival.certain);
    placed.push_back({stamp, arrival.time});
  });
  const std::vector<TickEpoch> epochs = ticks.finish();
  if (epochs.empty()) throw InputError(place, "has no frames, so its clock cannot be placed");
  map.epochs = fit_epochs(epochs, place);
  map.stamps = evidence_of_stamps(map, placed);
  map.stamps.drift_left_out = drift_left_out(longest_of(epochs));
  return map;
}

SensorClockMap fit_sensor_clock(const SessionReader& session, std::size_t sensor) {
  const SensorDescription& description = session.header().sensors.at(sensor);
  const SensorCounts& counts = session.counts(sensor);
  const FrameStream stream = counts.body_frames > 0 ? FrameStream::bodies : FrameStream::depth;
  const std::uint64_t frames = counts.body_frames > 0 ? counts.body_frames : counts.depth_frames;
  const auto each_stamp = [&](const std::function<void(const FrameStamp&)>& take) {
    for (std::uint64_t first = 0; first < frames; first += kBlock)
      for (const FrameStamp& stamp : session.stamps(sensor, stream, first, std::min(kBlock, frames - first)))
        take(stamp);
  };
  return fit_sensor_clock(description, each_stamp, session.clock_exchanges(sensor),
                          session.path().string() + ":/sensors/" + description.name);
}

ClockEvidence evidence_of(const SensorClockMap& map) {
  ClockEvidence evidence;
  std::uint64_t most_frames = 0;
  for (const SensorEpoch& epoch : map.epochs) {
    ++evidence.sensor_epochs;
    evidence.sensor_pieces += epoch.host_from_sensor.pieces.size();
    if (epoch.frames > most_frames) evidence.sensor_drift_ppm = epoch.drift * kPpm;
    most_frames = std::max(most_frames, epoch.frames);
  }
  Duration longest;
  for (const AgentSegment& segment : map.agent.segments) {
    ++evidence.agent_segments;
    evidence.agent_pieces += segment.host_from_agent.pieces.size();
    if (segment.last - segment.first >= longest) evidence.agent_drift_ppm = segment.line.drift * kPpm;
    longest = std::max(longest, segment.last - segment.first);
  }
  evidence.offset_sigma_ns = map.stamps.doubt.sigma_ns;
  evidence.offset_bound_ns = map.stamps.doubt.bound_ns;
  evidence.outside_exchanges_s = map.stamps.doubt.outside.seconds();
  evidence.lateness_median_s = map.stamps.lateness_median.seconds();
  evidence.lateness_p99_s = map.stamps.lateness_p99.seconds();
  evidence.drift_left_out_ppm = map.stamps.drift_left_out * kPpm;
  evidence.exchanges = map.agent.exchanges;
  evidence.exchanges_used = map.agent.exchanges_used;
  evidence.exchanges_backwards = map.agent.exchanges_backwards;
  evidence.exchanges_contradicting = map.agent.exchanges_contradicting;
  return evidence;
}

}  // namespace trilat
