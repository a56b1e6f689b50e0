// SPDX-License-Identifier: MIT
#include "datasets/session/clock/offset_wander.h"

#include <algorithm>
#include <cmath>

#include "datasets/session/clock/offset_samples.h"

namespace trilat {

namespace {

constexpr std::int64_t kWindow_ns = 10'000'000'000;
constexpr std::ptrdiff_t kFewestExchanges = 12;
constexpr std::size_t kFewestUsed = 3;
constexpr double kStraight_ns = 300'000.0;
constexpr double kCertain_sigmas = 4.0;

// 10 s each, longer where these hold fewer than twelve exchanges.
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

}  // namespace

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

}  // namespace trilat
