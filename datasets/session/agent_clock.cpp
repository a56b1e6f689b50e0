// SPDX-License-Identifier: MIT
#include "datasets/session/agent_clock.h"

#include <algorithm>
#include <cmath>

#include "datasets/session/exchange_segments.h"
#include "datasets/session/offset_wander.h"

namespace trilat {
namespace {

constexpr std::int64_t kShortestDriftSpan_ns = 10'000'000'000;

struct FittedSegment {
  AgentSegment segment;
  std::size_t used = 0;
};

std::int64_t least_delay_ns(const std::vector<ClockExchange>& exchanges) {
  std::int64_t least_ns = delay_ns(exchanges.front());
  for (const ClockExchange& e : exchanges) least_ns = std::min(least_ns, delay_ns(e));
  return least_ns;
}

std::int64_t most_delay_ns(const std::vector<ClockExchange>& exchanges) {
  std::int64_t most_ns = 0;
  for (const ClockExchange& e : exchanges) most_ns = std::max(most_ns, delay_ns(e));
  return most_ns;
}

// Straight pieces through the medians of windows.
void bend(FittedSegment& fitted, const std::vector<WanderWindow>& windows) {
  const auto agent_from_host = fitted.segment.line.inverse();
  std::vector<ClockKnot<HostClock, AgentTag>> knots;
  double sigma_ns = 0.0;
  fitted.used = 0;
  for (const WanderWindow& w : windows) {
    const AgentTime agent = agent_from_host({w.host_ns}) + Duration{std::llround(w.residual_ns)};
    if (!knots.empty() && agent <= knots.back().from) continue;
    knots.push_back({agent, {w.host_ns}});
    sigma_ns = std::max(sigma_ns, w.sigma_ns);
    fitted.used += w.exchanges;
  }
  fitted.segment.host_from_agent = through(knots, fitted.segment.line);
  fitted.segment.offset_sigma_ns = std::llround(sigma_ns);
}

// `drift` is that of agent against host where the segment is too short to tell.
OffsetLine fit_line(AgentSegment& segment, const std::vector<OffsetSample>& samples, std::int64_t base_ns,
                    double drift) {
  OffsetLine line{samples.front().host_ns, 0.0, drift};
  // a slope from a short burst would be carried far beyond it
  segment.has_drift = samples.back().host_ns - line.origin_ns >= kShortestDriftSpan_ns;
  if (segment.has_drift) line.slope = median_slope(samples);
  line.intercept_ns = median_of(residuals_of(samples, line));
  const ClockMap<AgentTag, HostClock> agent_from_host{
      {line.origin_ns}, {line.origin_ns + base_ns + std::llround(line.intercept_ns)}, line.slope};
  segment.line = agent_from_host.inverse();
  segment.host_from_agent = along(segment.line);
  const std::vector<double> residuals_ns = residuals_of(samples, line);
  for (double r : residuals_ns)
    segment.worst_residual_ns = std::max<std::int64_t>(segment.worst_residual_ns, std::llround(std::abs(r)));
  // at its ends a line is twice as uncertain as in its middle
  const double ends = segment.has_drift ? 2.0 : 1.0;
  segment.offset_sigma_ns = std::llround(ends * sigma_of_median(sigma_of(residuals_ns, 0.0), samples.size()));
  return line;
}

FittedSegment fit_segment(const std::vector<ClockExchange>& exchanges, double drift) {
  const std::vector<ClockExchange> used = least_delayed(exchanges);
  const std::int64_t base_ns = twice_offset_ns(used.front()) / 2;
  FittedSegment fitted;
  fitted.used = used.size();
  fitted.segment.first = {exchanges.front().t2_ns};
  fitted.segment.last = {exchanges.back().t3_ns};
  fitted.segment.offset_bound_ns = least_delay_ns(used) / 2;
  const OffsetLine line = fit_line(fitted.segment, samples_of(used, base_ns), base_ns, drift);
  if (!fitted.segment.has_drift) return fitted;
  const std::vector<WanderWindow> windows = wander_windows(exchanges, base_ns, line, most_delay_ns(used));
  if (!is_straight(windows)) bend(fitted, windows);
  return fitted;
}

// A machine keeps its crystal when its clock is set anew: short segments take the longest one's drift.
double drift_of_longest(const std::vector<std::vector<ClockExchange>>& segments) {
  double drift = 0.0;
  std::size_t longest = 0;
  for (const std::vector<ClockExchange>& exchanges : segments) {
    if (exchanges.size() <= longest) continue;
    const AgentSegment segment = fit_segment(exchanges, 0.0).segment;
    if (!segment.has_drift) continue;
    longest = exchanges.size();
    drift = segment.line.inverse().drift;
  }
  return drift;
}

std::int64_t distance_ns(const AgentSegment& s, AgentTime t) {
  return std::max({std::int64_t{0}, (s.first - t).ns, (t - s.last).ns});
}

}  // namespace

HostTime AgentClock::operator()(AgentTime t) const {
  if (segments.empty()) return {t.ns};
  return std::min_element(segments.begin(), segments.end(),
                          [&](const auto& a, const auto& b) { return distance_ns(a, t) < distance_ns(b, t); })
      ->host_from_agent(t);
}

AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges) {
  AgentClock clock;
  const ExchangeSegments split = split_exchanges(exchanges);
  clock.exchanges = exchanges.size();
  clock.exchanges_backwards = split.backwards;
  clock.exchanges_contradicting = split.contradicting;
  const double drift = split.segments.size() > 1 ? drift_of_longest(split.segments) : 0.0;
  for (const std::vector<ClockExchange>& part : split.segments) {
    FittedSegment fitted = fit_segment(part, drift);
    clock.exchanges_used += fitted.used;
    clock.segments.push_back(std::move(fitted.segment));
  }
  return clock;
}

}  // namespace trilat
