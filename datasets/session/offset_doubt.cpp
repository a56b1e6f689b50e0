// SPDX-License-Identifier: MIT
#include "datasets/session/offset_doubt.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "datasets/base/check.h"
#include "datasets/session/offset_wander.h"

namespace trilat {
namespace {

constexpr double kFastestWander = 50e-6;
constexpr double kWarmingDrift = 1e-6;  // standard deviation of a drift's change where nothing shows it

// Where the error of a clock (what it says less what is true) can lie.
struct ErrorCorridor {
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t most_ns = std::numeric_limits<std::int64_t>::max();

  bool holds_zero() const { return least_ns <= 0 && most_ns >= 0; }
  std::int64_t width_ns() const { return most_ns - least_ns; }
};

ErrorCorridor corridor_of(const std::vector<ClockExchange>& exchanges,
                          const PiecewiseClock<HostClock, AgentTag>& host_from_agent) {
  ErrorCorridor corridor;
  for (const ClockExchange& e : exchanges) {
    corridor.most_ns = std::min(corridor.most_ns, host_from_agent({e.t2_ns}).ns - e.t1_ns);
    corridor.least_ns = std::max(corridor.least_ns, host_from_agent({e.t3_ns}).ns - e.t4_ns);
  }
  return corridor;
}

void take_from(CorridorWindow& window, const CorridorWindow& neighbour, Duration between) {
  const auto wander_ns = std::llround(kFastestWander * static_cast<double>(std::abs(between.ns)));
  window.bound_ns = std::min<std::int64_t>(window.bound_ns, neighbour.bound_ns + wander_ns);
}

void take_from_neighbours(std::vector<CorridorWindow>& windows, const std::vector<ErrorCorridor>& corridors) {
  const auto middle = [&](std::size_t i) {
    return AgentTime{windows[i].first.ns + (windows[i].last - windows[i].first).ns / 2};
  };
  for (std::size_t i = 1; i < windows.size(); ++i)
    if (corridors[i].holds_zero()) take_from(windows[i], windows[i - 1], middle(i) - middle(i - 1));
  for (std::size_t i = windows.size(); i-- > 1;)
    if (corridors[i - 1].holds_zero()) take_from(windows[i - 1], windows[i], middle(i) - middle(i - 1));
}

std::int64_t distance_ns(AgentTime first, AgentTime last, AgentTime t) {
  return std::max({std::int64_t{0}, (first - t).ns, (t - last).ns});
}

}  // namespace

std::vector<CorridorWindow> corridor_windows(const std::vector<ClockExchange>& exchanges,
                                             const PiecewiseClock<HostClock, AgentTag>& host_from_agent) {
  std::vector<CorridorWindow> windows;
  std::vector<ErrorCorridor> corridors;
  std::int64_t least_width_ns = std::numeric_limits<std::int64_t>::max();
  for (const std::vector<ClockExchange>& part : in_windows(exchanges)) {
    const ErrorCorridor c = corridor_of(part, host_from_agent);
    windows.push_back(
        {{part.front().t2_ns}, {part.back().t3_ns}, std::max(std::abs(c.most_ns), std::abs(c.least_ns))});
    corridors.push_back(c);
    if (c.width_ns() >= 0) least_width_ns = std::min(least_width_ns, c.width_ns());
  }
  // exchanges that no constant error explains: it changes within the window, by more than its ends show
  for (std::size_t i = 0; i < windows.size(); ++i)
    if (corridors[i].width_ns() < 0 && least_width_ns < std::numeric_limits<std::int64_t>::max())
      windows[i].bound_ns += least_width_ns;
  take_from_neighbours(windows, corridors);
  return windows;
}

OffsetDoubt doubt_at(const OffsetSpread& spread, AgentTime t) {
  TRILAT_CHECK(!spread.windows.empty(), "a fitted clock has exchanges");
  const auto nearest =
      std::min_element(spread.windows.begin(), spread.windows.end(), [&](const auto& a, const auto& b) {
        return distance_ns(a.first, a.last, t) < distance_ns(b.first, b.last, t);
      });
  const auto away_ns = static_cast<double>(distance_ns(spread.rest_from, spread.rest_to, t));
  const Duration outside{distance_ns(nearest->first, nearest->last, t)};
  const double sigma_ns = std::hypot(spread.sigma_ns, spread.drift_sigma * away_ns,
                                     kWarmingDrift * static_cast<double>(outside.ns));
  return {std::llround(sigma_ns), nearest->bound_ns, outside};
}

}  // namespace trilat
