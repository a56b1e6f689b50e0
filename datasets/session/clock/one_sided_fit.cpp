// SPDX-License-Identifier: MIT
#include "datasets/session/clock/one_sided_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "datasets/session/clock/host_arrivals.h"

namespace trilat {
namespace {

constexpr std::size_t kFewestFitted = 12;
constexpr double kQueue_ns = 300'000.0;
constexpr double kUnlike = 3.0;

// Of agent - host against a line: what the delay of each way makes of it.
struct Ways {
  std::vector<double> most_ns, least_ns;  // by the way to the agent, by the way to the host
};

Ways ways_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns, const OffsetLine& line) {
  Ways ways;
  const auto on_line_ns = [&](std::int64_t host_ns) {
    return line.intercept_ns + line.slope * static_cast<double>(host_ns - line.origin_ns);
  };
  for (const ClockExchange& e : exchanges) {
    ways.most_ns.push_back(static_cast<double>(e.t2_ns - e.t1_ns - base_ns) - on_line_ns(e.t1_ns));
    ways.least_ns.push_back(static_cast<double>(e.t3_ns - e.t4_ns - base_ns) - on_line_ns(e.t4_ns));
  }
  return ways;
}

double least(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }
double most(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

struct Queues {
  double to_agent_ns = 0.0, to_host_ns = 0.0;  // medians above the least delay
};
Queues queues_of(const Ways& ways) {
  return {median_of(ways.most_ns) - least(ways.most_ns), most(ways.least_ns) - median_of(ways.least_ns)};
}

// Of agent against host, along the least delays of the steady way.
double envelope_slope(const std::vector<ClockExchange>& exchanges, SteadyWay steady) {
  ArrivalEnvelope envelope;  // a message is a frame: stamped where it leaves and where it arrives
  for (const ClockExchange& e : exchanges)
    if (steady == SteadyWay::to_agent)
      envelope.add({{e.t1_ns}, {e.t2_ns}});
    else
      envelope.add({{e.t3_ns}, {e.t4_ns}});
  const auto line = envelope.line();
  return steady == SteadyWay::to_agent ? line.drift : line.inverse().drift;
}

// Follows the steady way; the distance to the middle is where both ways together are narrowest.
std::vector<WanderWindow> windows_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                                     const OffsetLine& line, SteadyWay steady, double sigma_ns) {
  std::vector<WanderWindow> windows;
  double narrowest_ns = std::numeric_limits<double>::infinity();
  for (const std::vector<ClockExchange>& part : in_windows(exchanges)) {
    const Ways ways = ways_of(part, base_ns, line);
    const double most_ns = least(ways.most_ns), least_ns = most(ways.least_ns);
    narrowest_ns = std::min(narrowest_ns, most_ns - least_ns);
    windows.push_back({part.front().t1_ns + (part.back().t1_ns - part.front().t1_ns) / 2,
                       steady == SteadyWay::to_agent ? most_ns : least_ns, sigma_ns, part.size()});
  }
  const double to_middle_ns = (steady == SteadyWay::to_agent ? -0.5 : 0.5) * narrowest_ns;
  for (WanderWindow& w : windows) w.residual_ns += to_middle_ns;
  return windows;
}

}  // namespace

SteadyWay steady_way(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                     const OffsetLine& line) {
  if (exchanges.size() < kFewestFitted) return SteadyWay::both;
  const Queues queues = queues_of(ways_of(exchanges, base_ns, line));
  if (queues.to_host_ns > std::max(kQueue_ns, kUnlike * queues.to_agent_ns)) return SteadyWay::to_agent;
  if (queues.to_agent_ns > std::max(kQueue_ns, kUnlike * queues.to_host_ns)) return SteadyWay::to_host;
  return SteadyWay::both;
}

OneSidedFit fit_one_sided(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                          const OffsetLine& line, SteadyWay steady, SlopeOf slope) {
  OneSidedFit fit;
  fit.line = line;
  if (slope == SlopeOf::exchanges) fit.line.slope = envelope_slope(exchanges, steady);
  const Ways ways = ways_of(exchanges, base_ns, fit.line);
  fit.line.intercept_ns += 0.5 * (least(ways.most_ns) + most(ways.least_ns));
  // the least of n exponential delays lies their mean / n above the wire's own, and spreads as much
  const Queues queues = queues_of(ways);
  const auto n = static_cast<double>(exchanges.size());
  const double queue_ns = std::hypot(queues.to_agent_ns, queues.to_host_ns) / M_LN2;
  fit.sigma_ns = queue_ns / n;
  const double steady_ns = std::min(queues.to_agent_ns, queues.to_host_ns) / M_LN2;
  const auto span_ns = static_cast<double>(exchanges.back().t1_ns - exchanges.front().t1_ns);
  if (span_ns > 0.0) fit.slope_sigma = 4.0 * steady_ns / (n * span_ns);
  fit.windows = windows_of(exchanges, base_ns, fit.line, steady, fit.sigma_ns);
  return fit;
}

}  // namespace trilat
