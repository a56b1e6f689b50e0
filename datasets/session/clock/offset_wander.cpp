// SPDX-License-Identifier: MIT
#include "datasets/session/clock/offset_wander.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "datasets/base/error.h"
#include "datasets/session/clock/offset_samples.h"

namespace trilat {

namespace {

constexpr std::int64_t kWindow_ns = 10'000'000'000;
constexpr std::ptrdiff_t kFewestExchanges = 12;
constexpr std::size_t kFewestUsed = 3;
constexpr double kStraight_ns = 300'000.0;
constexpr double kCertain_sigmas = 4.0;

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

std::vector<std::vector<ClockExchange>> in_windows(const std::vector<ClockExchange>& exchanges) {
  std::vector<std::vector<ClockExchange>> windows;
  for (auto first = exchanges.begin(); first != exchanges.end();) {
    auto end = first;
    while (end != exchanges.end() &&
           (end->t1_ns - first->t1_ns < kWindow_ns || end - first < kFewestExchanges))
      ++end;
    windows.emplace_back(first, end);
    first = end;
  }
  return windows;
}

std::vector<WanderWindow> wander_windows(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns,
                                         const OffsetLine& line, std::int64_t usual_delay_ns) {
  std::vector<WanderWindow> windows;
  std::vector<double> sigmas_ns;
  for (const std::vector<ClockExchange>& part : in_windows(exchanges)) {
    std::vector<ClockExchange> used = least_delayed(part);
    std::erase_if(used, [&](const ClockExchange& e) { return delay_ns(e) > 2 * usual_delay_ns; });
    if (used.size() < kFewestUsed) continue;
    const std::vector<OffsetSample> samples = samples_of(used, base_ns);
    const std::vector<double> residuals_ns = residuals_of(samples, line);
    const double median_ns = median_of(residuals_ns);
    sigmas_ns.push_back(sigma_of(residuals_ns, median_ns));
    windows.push_back({samples.front().host_ns + (samples.back().host_ns - samples.front().host_ns) / 2,
                       median_ns, 0.0, used.size()});
  }
  if (windows.empty()) return windows;
  const double sigma_ns = median_of(sigmas_ns);
  for (WanderWindow& w : windows) w.sigma_ns = sigma_of_median(sigma_ns, w.exchanges);
  return windows;
}

bool is_straight(const std::vector<WanderWindow>& windows) {
  const auto side = [](const WanderWindow& w) {
    if (std::abs(w.residual_ns) <= std::max(kStraight_ns, kCertain_sigmas * w.sigma_ns)) return 0;
    return w.residual_ns > 0.0 ? 1 : -1;
  };
  for (std::size_t i = 1; i < windows.size(); ++i)
    if (side(windows[i]) != 0 && side(windows[i]) == side(windows[i - 1])) return false;
  return true;
}

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
