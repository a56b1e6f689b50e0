// SPDX-License-Identifier: MIT
#include "datasets/session/session_clock.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/check.h"
#include "datasets/base/error.h"

namespace trilat {
namespace {

constexpr double kMaxDrift = 1e-3;
constexpr Duration kShortest{5'000'000'000};  // of a recording that can tell a drift from jitter
constexpr std::int64_t kShortestDriftSpan_ns = 10'000'000'000;
constexpr std::uint64_t kBlock = 4096;

struct OffsetSample {
  std::int64_t host_ns;  // midpoint of the exchange on the host
  double offset_ns;      // agent - host at that time, less the first sample's
};

// The exchanges whose delay lies within the least quarter: those that queueing disturbed least.
std::vector<ClockExchange> least_delayed(std::span<const ClockExchange> exchanges) {
  const auto delay = [](const ClockExchange& e) { return (e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns); };
  std::vector<ClockExchange> sorted;
  for (const ClockExchange& e : exchanges)
    if (e.t4_ns >= e.t1_ns && e.t3_ns >= e.t2_ns && delay(e) >= 0) sorted.push_back(e);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto& a, const auto& b) { return delay(a) < delay(b); });
  sorted.resize(std::min(sorted.size(), std::max<std::size_t>(3, sorted.size() / 4)));
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.t1_ns < b.t1_ns; });
  return sorted;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Median of the slopes between samples at least a third of the span apart; bounded work for long
// recordings.
double median_slope(const std::vector<OffsetSample>& samples) {
  const std::size_t step = std::max<std::size_t>(1, samples.size() / 200);
  const double least_span = static_cast<double>(samples.back().host_ns - samples.front().host_ns) / 3.0;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < samples.size(); i += step)
    for (std::size_t j = i + 1; j < samples.size(); j += step) {
      const double span = static_cast<double>(samples[j].host_ns - samples[i].host_ns);
      if (span > 0.0 && span >= least_span)
        slopes.push_back((samples[j].offset_ns - samples[i].offset_ns) / span);
    }
  return slopes.empty() ? 0.0 : median_of(std::move(slopes));
}

}  // namespace

AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges) {
  AgentClock result;
  if (exchanges.empty()) return result;
  const std::vector<ClockExchange> used = least_delayed(exchanges);
  if (used.empty()) return result;
  const auto twice_offset = [](const ClockExchange& e) { return (e.t2_ns - e.t1_ns) + (e.t3_ns - e.t4_ns); };
  const std::int64_t base = twice_offset(used.front()) / 2;
  std::vector<OffsetSample> samples;
  for (const ClockExchange& e : used)
    samples.push_back(
        {e.t1_ns + (e.t4_ns - e.t1_ns) / 2, static_cast<double>(twice_offset(e) - 2 * base) / 2.0});
  // a slope from a short burst would be carried far beyond it
  const std::int64_t span_ns = samples.back().host_ns - samples.front().host_ns;
  const double slope = span_ns >= kShortestDriftSpan_ns ? median_slope(samples) : 0.0;
  const std::int64_t origin = samples.front().host_ns;
  std::vector<double> intercepts;
  for (const OffsetSample& s : samples)
    intercepts.push_back(s.offset_ns - slope * static_cast<double>(s.host_ns - origin));
  const double intercept = median_of(intercepts);
  for (double value : intercepts)
    result.worst_residual_ns =
        std::max<std::int64_t>(result.worst_residual_ns, std::llround(std::abs(value - intercept)));
  const ClockMap<AgentClock::AgentTag, HostClock> agent_from_host{
      {origin}, {origin + base + std::llround(intercept)}, slope};
  result.host_from_agent = agent_from_host.inverse();
  result.exchanges_used = used.size();
  return result;
}

void ArrivalEnvelope::add(const ArrivalStamp& p) {
  if (!hull_.empty() && p.device <= hull_.back().device) return;
  const auto turns_up = [](const ArrivalStamp& a, const ArrivalStamp& b, const ArrivalStamp& c) {
    const double ab = static_cast<double>((b.device - a.device).ns);
    const double ac = static_cast<double>((c.device - a.device).ns);
    // slopes near one: compare arrival - device, which keeps the digits
    const double lag_b = static_cast<double>((b.arrival_ns - a.arrival_ns) - (b.device - a.device).ns);
    const double lag_c = static_cast<double>((c.arrival_ns - a.arrival_ns) - (c.device - a.device).ns);
    return lag_b * ac < lag_c * ab;
  };
  while (hull_.size() >= 2 && !turns_up(hull_[hull_.size() - 2], hull_.back(), p)) hull_.pop_back();
  hull_.push_back(p);
}

ClockMap<AgentClock::AgentTag, SensorClock> ArrivalEnvelope::line() const {
  TRILAT_CHECK(!hull_.empty(), "an envelope has points");
  if (hull_.size() == 1) return {hull_[0].device, {hull_[0].arrival_ns}, 0.0};
  const SensorTime middle{hull_.front().device.ns + (hull_.back().device - hull_.front().device).ns / 2};
  std::size_t right = 1;
  while (right + 1 < hull_.size() && hull_[right].device < middle) ++right;
  const ArrivalStamp& a = hull_[right - 1];
  const ArrivalStamp& b = hull_[right];
  const std::int64_t span = (b.device - a.device).ns;
  const double drift = static_cast<double>(b.arrival_ns - a.arrival_ns - span) / static_cast<double>(span);
  return {a.device, {a.arrival_ns}, drift};
}

SensorTime device_time(const SensorDescription& sensor, const FrameStamp& stamp) {
  return {stamp.device_ticks * sensor.tick_ns};
}

ClockMap<HostClock, SensorClock> fit_sensor_clock(const SessionReader& session, std::size_t sensor) {
  const SensorDescription& description = session.header().sensors.at(sensor);
  const std::string place = session.path().string() + ":/sensors/" + description.name;
  const SensorCounts& counts = session.counts(sensor);
  const FrameStream stream = counts.body_frames > 0 ? FrameStream::bodies : FrameStream::depth;
  const std::uint64_t frames = counts.body_frames > 0 ? counts.body_frames : counts.depth_frames;
  if (frames == 0) throw InputError(place, "has no frames, so its clock cannot be placed");
  ArrivalEnvelope envelope;
  for (std::uint64_t first = 0; first < frames; first += kBlock)
    for (const FrameStamp& stamp : session.stamps(sensor, stream, first, std::min(kBlock, frames - first)))
      envelope.add({device_time(description, stamp), stamp.arrival_ns});
  auto agent_from_sensor = envelope.line();
  const auto device_of = [&](std::uint64_t frame) {
    return device_time(description, session.stamps(sensor, stream, frame, 1)[0]);
  };
  // in so short a time jitter of the arrivals looks like drift
  if (std::abs(agent_from_sensor.drift) > kMaxDrift && device_of(frames - 1) - device_of(0) < kShortest)
    agent_from_sensor.drift = 0.0;
  if (std::abs(agent_from_sensor.drift) > kMaxDrift)
    throw InputError(place,
                     fmt::format("has a clock that drifts by {:.0f} ppm against arrival times; check tick_ns "
                                 "and arrival_ns",
                                 agent_from_sensor.drift * 1e6));
  const auto host_from_agent = fit_agent_clock(session.clock_exchanges(sensor)).host_from_agent;
  if (std::abs(host_from_agent.drift) > kMaxDrift)
    throw InputError(place + "/clock_exchanges_ns",
                     fmt::format("give a drift of {:.0f} ppm between two machines, which no clock has",
                                 host_from_agent.drift * 1e6));
  return {agent_from_sensor.origin_from,
          host_from_agent(agent_from_sensor.origin_to) - Duration{description.latency_ns},
          (1.0 + agent_from_sensor.drift) * (1.0 + host_from_agent.drift) - 1.0};
}

}  // namespace trilat
