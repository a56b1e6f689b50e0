// SPDX-License-Identifier: MIT
#include "datasets/session/clock/offset_samples.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/median.h"
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
    const double median_ns = upper_median(residuals_ns);
    sigmas_ns.push_back(sigma_of(residuals_ns, median_ns));
    windows.push_back({samples.front().host_ns + (samples.back().host_ns - samples.front().host_ns) / 2,
                       median_ns, 0.0, used.size()});
  }
  if (windows.empty()) return windows;
  const double sigma_ns = upper_median(sigmas_ns);
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

namespace {

constexpr double kFastestChange = 1e-2;  // of one clock against another: far beyond any crystal
constexpr std::int64_t kTolerance_ns = 1'000'000;
constexpr std::size_t kFewest = 3;

// Where agent - host can lie, after all that one setting of the clock has said so far.
class Corridor {
 public:
  explicit Corridor(const ClockExchange& e)
      : host_ns_(e.t1_ns), least_ns_(e.t3_ns - e.t4_ns), most_ns_(e.t2_ns - e.t1_ns) {}

  // Narrows it when the exchange fits.
  bool admits(const ClockExchange& e) {
    const auto wander = static_cast<std::int64_t>(kFastestChange * static_cast<double>(e.t1_ns - host_ns_));
    const std::int64_t least_ns = std::max(least_ns_ - wander, e.t3_ns - e.t4_ns);
    const std::int64_t most_ns = std::min(most_ns_ + wander, e.t2_ns - e.t1_ns);
    if (least_ns > most_ns + kTolerance_ns) return false;
    host_ns_ = e.t1_ns;
    least_ns_ = std::min(least_ns, most_ns);
    most_ns_ = std::max(least_ns, most_ns);
    return true;
  }

 private:
  std::int64_t host_ns_, least_ns_, most_ns_;
};

std::vector<ClockExchange> forwards_by_time(std::span<const ClockExchange> exchanges) {
  std::vector<ClockExchange> sound;
  std::copy_if(exchanges.begin(), exchanges.end(), std::back_inserter(sound), runs_forwards);
  std::ranges::stable_sort(sound, [](const auto& a, const auto& b) { return a.t1_ns < b.t1_ns; });
  return sound;
}

// Segments of one or two say nothing once there are longer ones.
void drop_fragments(ExchangeSegments& split) {
  const bool any_long =
      std::ranges::any_of(split.segments, [](const auto& s) { return s.size() >= kFewest; });
  if (!any_long) return;
  std::erase_if(split.segments, [&](const auto& s) {
    if (s.size() >= kFewest) return false;
    split.contradicting += s.size();
    return true;
  });
}

}  // namespace

std::int64_t twice_offset_ns(const ClockExchange& e) { return (e.t2_ns - e.t1_ns) + (e.t3_ns - e.t4_ns); }

std::vector<OffsetSample> samples_of(const std::vector<ClockExchange>& exchanges, std::int64_t base_ns) {
  std::vector<OffsetSample> samples;
  for (const ClockExchange& e : exchanges)
    samples.push_back(
        {e.t1_ns + (e.t4_ns - e.t1_ns) / 2, static_cast<double>(twice_offset_ns(e) - 2 * base_ns) / 2.0});
  return samples;
}

std::vector<ClockExchange> least_delayed(std::vector<ClockExchange> exchanges) {
  std::ranges::stable_sort(exchanges, [](const auto& a, const auto& b) { return delay_ns(a) < delay_ns(b); });
  exchanges.resize(std::min(exchanges.size(), std::max<std::size_t>(3, exchanges.size() / 4)));
  std::ranges::sort(exchanges, [](const auto& a, const auto& b) { return a.t1_ns < b.t1_ns; });
  return exchanges;
}

std::vector<double> residuals_of(const std::vector<OffsetSample>& samples, const OffsetLine& line) {
  std::vector<double> residuals;
  for (const OffsetSample& s : samples)
    residuals.push_back(s.offset_ns - line.slope * static_cast<double>(s.host_ns - line.origin_ns) -
                        line.intercept_ns);
  return residuals;
}

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
  return slopes.empty() ? 0.0 : upper_median(std::move(slopes));
}

double sigma_of(const std::vector<double>& values, double middle) {
  std::vector<double> deviations;
  for (double value : values) deviations.push_back(std::abs(value - middle));
  return 1.4826 * upper_median(std::move(deviations));
}

double sigma_of_median(double sigma, std::size_t count) {
  return 1.2533 * sigma / std::sqrt(static_cast<double>(count));
}

ExchangeSegments split_exchanges(std::span<const ClockExchange> exchanges) {
  ExchangeSegments split;
  const std::vector<ClockExchange> sound = forwards_by_time(exchanges);
  split.backwards = exchanges.size() - sound.size();
  if (sound.empty()) return split;
  std::vector<Corridor> corridor{Corridor(sound.front())}, other_corridor;
  std::vector<ClockExchange> other;  // agree with each other, and not with the segment
  split.segments.push_back({sound.front()});
  for (std::size_t i = 1; i < sound.size(); ++i) {
    if (corridor.back().admits(sound[i])) {
      split.segments.back().push_back(sound[i]);
      split.contradicting += other.size();
      other.clear();
      continue;
    }
    if (other.empty() || !other_corridor.back().admits(sound[i])) {
      split.contradicting += other.size();
      other.clear();
      other_corridor.assign(1, Corridor(sound[i]));
    }
    other.push_back(sound[i]);
    if (other.size() < kFewest) continue;
    split.segments.push_back(std::move(other));
    corridor = other_corridor;
    other.clear();
  }
  split.contradicting += other.size();
  drop_fragments(split);
  return split;
}

}  // namespace trilat
