// SPDX-License-Identifier: MIT
#include "datasets/session/session_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/envelope_pieces.h"
#include "datasets/session/host_arrivals.h"

namespace trilat {
namespace {

constexpr double kMaxDrift = 1e-3;
constexpr double kPpm = 1e6;
constexpr std::uint64_t kBlock = 4096;

void check_agent(const AgentClock& agent, const std::string& place) {
  for (const AgentSegment& segment : agent.segments)
    if (std::abs(segment.line.drift) > kMaxDrift)
      throw InputError(place + "/clock_exchanges_ns",
                       fmt::format("give a drift of {:.0f} ppm between two machines, which no clock has",
                                   segment.line.drift * kPpm));
}

void check_ticks(const SensorEpoch& epoch, const std::string& place) {
  if (std::abs(epoch.drift) > kMaxDrift)
    throw InputError(place,
                     fmt::format("has a clock that drifts by {:.0f} ppm against arrival times; check tick_ns "
                                 "and arrival_ns",
                                 epoch.drift * kPpm));
}

SensorEpoch fit_epoch(const TickEpoch& ticks, const ClockMap<HostClock, SensorClock>& line) {
  return {ticks.first, ticks.last, ticks.wraps, ticks.frames, line.drift, envelope_pieces(ticks, line)};
}

// A sensor keeps its crystal when it is restarted: short epochs take the longest one's drift.
std::vector<SensorEpoch> fit_epochs(const std::vector<TickEpoch>& ticks) {
  const auto longest = std::max_element(ticks.begin(), ticks.end(), [](const auto& a, const auto& b) {
    return a.last - a.first < b.last - b.first;
  });
  const double drift = envelope_line(*longest).drift;
  std::vector<SensorEpoch> epochs;
  for (auto epoch = ticks.begin(); epoch != ticks.end(); ++epoch)
    epochs.push_back(
        fit_epoch(*epoch, epoch == longest ? envelope_line(*epoch) : envelope_line(*epoch, drift)));
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

}  // namespace

SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp) {
  return {stamp.device_ticks * sensor.tick_ns};
}

HostTime SensorClockMap::operator()(const FrameStamp& stamp) const {
  const SensorTime device{stamp.device_ticks * tick_ns};
  if (epochs.size() == 1 && epochs.front().wraps == 0) return (*this)(device);
  HostTime best;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  for (const SensorEpoch& epoch : epochs)
    for (int wraps = 0; wraps <= epoch.wraps; ++wraps) {
      const SensorTime t = device + Duration{wraps * kTicksOfWrap * tick_ns};
      const HostTime host = epoch.host_from_sensor(t);
      const std::int64_t distance_ns =
          outside_ns(epoch, t) + arrival_distance_ns(agent, {stamp.arrival_ns}, host);
      if (distance_ns >= least_ns) continue;
      least_ns = distance_ns;
      best = host - latency;
    }
  return best;
}

HostTime SensorClockMap::operator()(SensorTime t) const {
  if (epochs.empty()) return {t.ns};
  return std::min_element(epochs.begin(), epochs.end(),
                          [&](const auto& a, const auto& b) { return outside_ns(a, t) < outside_ns(b, t); })
             ->host_from_sensor(t) -
         latency;
}

SensorClockMap fit_sensor_clock(const SensorDescription& sensor, const EachStamp& each_stamp,
                                std::span<const ClockExchange> exchanges, const std::string& place) {
  SensorClockMap map;
  map.tick_ns = sensor.tick_ns;
  map.latency = {sensor.latency_ns};
  map.agent = fit_agent_clock(exchanges);
  HostArrivals arrivals(map.agent);
  TickEpochs ticks(sensor.tick_ns);
  each_stamp([&](const FrameStamp& stamp) {
    const HostArrival arrival = arrivals.place(device_time(sensor, stamp), {stamp.arrival_ns});
    ticks.add(stamp.device_ticks, arrival.time, arrival.certain);
  });
  const std::vector<TickEpoch> epochs = ticks.finish();
  if (epochs.empty()) throw InputError(place, "has no frames, so its clock cannot be placed");
  map.epochs = fit_epochs(epochs);
  for (const SensorEpoch& epoch : map.epochs) check_ticks(epoch, place);
  check_agent(map.agent, place);
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
    evidence.offset_sigma_ns = std::max(evidence.offset_sigma_ns, segment.offset_sigma_ns);
    evidence.offset_bound_ns = std::max(evidence.offset_bound_ns, segment.offset_bound_ns);
  }
  evidence.exchanges = map.agent.exchanges;
  evidence.exchanges_used = map.agent.exchanges_used;
  evidence.exchanges_backwards = map.agent.exchanges_backwards;
  evidence.exchanges_contradicting = map.agent.exchanges_contradicting;
  return evidence;
}

}  // namespace trilat
