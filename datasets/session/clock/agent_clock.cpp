// SPDX-License-Identifier: MIT
#include "datasets/session/clock/agent_clock.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/median.h"
#include "datasets/session/clock/offset_samples.h"

namespace trilat {
namespace {

constexpr std::int64_t kShortestDriftSpan_ns = 10'000'000'000;
constexpr double kUnknownDrift = 50e-6;  // standard deviation, of common crystals
constexpr std::size_t kFewestOfSpread = 3;
constexpr double kWarmingDrift = 1e-6;  // standard deviation of a drift's change where nothing shows it

// Of agent against host.
struct KnownDrift {
  double drift = 0.0;
  double sigma = kUnknownDrift;
};

struct FittedSegment {
  AgentSegment segment;
  std::size_t used = 0;
};

std::int64_t most_delay_ns(const std::vector<ClockExchange>& exchanges) {
  std::int64_t most_ns = 0;
  for (const ClockExchange& e : exchanges) most_ns = std::max(most_ns, delay_ns(e));
  return most_ns;
}

// How much the drift of pieces differs from that of their line.
double drift_spread(const AgentSegment& segment) {
  double squares = 0.0;
  for (const auto& piece : segment.host_from_agent.pieces)
    squares += std::pow(piece.map.drift - segment.line.drift, 2);
  return std::sqrt(squares / static_cast<double>(segment.host_from_agent.pieces.size()));
}

// Straight pieces through the medians of windows.
void bend(FittedSegment& fitted, const std::vector<WanderWindow>& windows) {
  AgentSegment& segment = fitted.segment;
  const auto agent_from_host = segment.line.inverse();
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
  segment.host_from_agent = through(knots, segment.line);
  segment.spread = {segment.first, segment.last, sigma_ns, drift_spread(segment)};
}

void lay_along(AgentSegment& segment, const OffsetLine& line, std::int64_t base_ns) {
  const ClockMap<AgentTag, HostClock> agent_from_host{
      {line.origin_ns}, {line.origin_ns + base_ns + std::llround(line.intercept_ns)}, line.slope};
  segment.line = agent_from_host.inverse();
  segment.host_from_agent = along(segment.line);
}

void spread_from_middle(AgentSegment& segment, double sigma_ns, double drift_sigma) {
  const AgentTime middle{segment.first.ns + (segment.last - segment.first).ns / 2};
  segment.spread = {middle, middle, sigma_ns, drift_sigma};
}

// `known` where the segment is too short to tell its drift.
OffsetLine fit_line(AgentSegment& segment, const std::vector<OffsetSample>& samples, std::int64_t base_ns,
                    KnownDrift known) {
  OffsetLine line{samples.front().host_ns, 0.0, known.drift};
  const auto span_ns = static_cast<double>(samples.back().host_ns - line.origin_ns);
  // a slope from a short burst would be carried far beyond it
  segment.has_drift = samples.back().host_ns - line.origin_ns >= kShortestDriftSpan_ns;
  if (segment.has_drift) line.slope = median_slope(samples);
  line.intercept_ns = upper_median(residuals_of(samples, line));
  lay_along(segment, line, base_ns);
  const double sigma_ns = sigma_of_median(sigma_of(residuals_of(samples, line), 0.0), samples.size());
  spread_from_middle(segment, sigma_ns,
                     segment.has_drift ? std::sqrt(12.0) * sigma_ns / span_ns : known.sigma);
  return line;
}

// Unlike delays of both ways move the midpoint of an exchange by half of its delay at most.
void state_doubt(AgentSegment& segment, const std::vector<ClockExchange>& used) {
  for (const ClockExchange& e : used) {
    const HostTime midpoint{e.t1_ns + (e.t4_ns - e.t1_ns) / 2};
    const HostTime fitted = segment.host_from_agent({e.t2_ns + (e.t3_ns - e.t2_ns) / 2});
    segment.offset_bound_ns =
        std::max(segment.offset_bound_ns, delay_ns(e) / 2 + std::abs((fitted - midpoint).ns));
  }
  // one or two show no spread; anywhere within the bound is as likely
  if (used.size() < kFewestOfSpread)
    segment.spread.sigma_ns =
        std::max(segment.spread.sigma_ns, static_cast<double>(segment.offset_bound_ns) / std::sqrt(3.0));
  for (AgentTime end : {segment.first, segment.last})
    segment.offset_sigma_ns = std::max(segment.offset_sigma_ns, segment.doubt(end).sigma_ns);
}

FittedSegment fit_segment(const std::vector<ClockExchange>& exchanges, KnownDrift known) {
  const std::vector<ClockExchange> used = least_delayed(exchanges);
  FittedSegment fitted;
  fitted.used = used.size();
  fitted.segment.first = {exchanges.front().t2_ns};
  fitted.segment.last = {exchanges.back().t3_ns};
  const std::int64_t base_ns = twice_offset_ns(used.front()) / 2;
  const OffsetLine line = fit_line(fitted.segment, samples_of(used, base_ns), base_ns, known);
  if (fitted.segment.has_drift)
    if (const auto windows = wander_windows(exchanges, base_ns, line, most_delay_ns(used));
        !is_straight(windows))
      bend(fitted, windows);
  state_doubt(fitted.segment, used);
  return fitted;
}

// A machine keeps its crystal when its clock is set anew: short segments take the longest one's drift.
KnownDrift drift_of_longest(const std::vector<std::vector<ClockExchange>>& segments) {
  KnownDrift known;
  std::size_t longest = 0;
  for (const std::vector<ClockExchange>& exchanges : segments) {
    if (exchanges.size() <= longest) continue;
    const AgentSegment segment = fit_segment(exchanges, {}).segment;
    if (!segment.has_drift) continue;
    longest = exchanges.size();
    known = {segment.line.inverse().drift, segment.spread.drift_sigma};
  }
  return known;
}

std::int64_t distance_ns(AgentTime first, AgentTime last, AgentTime t) {
  return std::max({std::int64_t{0}, (first - t).ns, (t - last).ns});
}

const AgentSegment& nearest(const std::vector<AgentSegment>& segments, AgentTime t) {
  return *std::ranges::min_element(segments, [&](const auto& a, const auto& b) {
    return distance_ns(a.first, a.last, t) < distance_ns(b.first, b.last, t);
  });
}

}  // namespace

OffsetDoubt AgentSegment::doubt(AgentTime t) const {
  const auto away_ns = static_cast<double>(distance_ns(spread.rest_from, spread.rest_to, t));
  const Duration outside{distance_ns(first, last, t)};
  const double sigma_ns = std::hypot(spread.sigma_ns, spread.drift_sigma * away_ns,
                                     kWarmingDrift * static_cast<double>(outside.ns));
  return {std::llround(sigma_ns), offset_bound_ns, outside};
}

HostTime AgentClock::operator()(AgentTime t) const {
  return segments.empty() ? HostTime{t.ns} : nearest(segments, t).host_from_agent(t);
}

OffsetDoubt AgentClock::doubt(AgentTime t) const {
  return segments.empty() ? OffsetDoubt{} : nearest(segments, t).doubt(t);
}

AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges) {
  AgentClock clock;
  const ExchangeSegments split = split_exchanges(exchanges);
  clock.exchanges = exchanges.size();
  clock.exchanges_backwards = split.backwards;
  clock.exchanges_contradicting = split.contradicting;
  const KnownDrift known = split.segments.size() > 1 ? drift_of_longest(split.segments) : KnownDrift{};
  for (const std::vector<ClockExchange>& part : split.segments) {
    FittedSegment fitted = fit_segment(part, known);
    clock.exchanges_used += fitted.used;
    clock.segments.push_back(std::move(fitted.segment));
  }
  return clock;
}

}  // namespace trilat
