// SPDX-License-Identifier: MIT
#include "datasets/session/clock/agent_clock.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "datasets/base/median.h"

namespace trilat {
namespace {

constexpr std::int64_t kMinDriftSpan_ns = 10'000'000'000;
constexpr std::int64_t kWindow_ns = 10'000'000'000;
constexpr std::ptrdiff_t kMinWindowExchanges = 12;
constexpr std::size_t kMinUsed = 3;
constexpr double kUnknownDrift = 50e-6;  // standard deviation, of common crystals
constexpr double kWarmingDrift = 1e-6;   // standard deviation of a drift's change where nothing shows it
constexpr double kCertainSigmas = 4.0;
constexpr double kExplained_ns = 20e6;      // what unlike delays may explain counts up to here as a deviation
constexpr double kMedianVariance = 1.5708;  // of a median of normal values against that of their mean

// Time that an exchange spent on the wire, both ways.
std::int64_t delay_ns(const ClockExchange& e) { return (e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns); }

// False when it was answered before it was sent, or took longer to answer than it was away.
bool runs_forwards(const ClockExchange& e) {
  return e.t4_ns >= e.t1_ns && e.t3_ns >= e.t2_ns && delay_ns(e) >= 0;
}

std::int64_t midpoint_ns(const ClockExchange& e) { return e.t1_ns + (e.t4_ns - e.t1_ns) / 2; }
std::int64_t twice_offset_ns(const ClockExchange& e) { return (e.t2_ns - e.t1_ns) + (e.t3_ns - e.t4_ns); }

std::vector<ClockExchange> forwards_by_time(std::span<const ClockExchange> exchanges) {
  std::vector<ClockExchange> sound;
  std::ranges::copy_if(exchanges, std::back_inserter(sound), runs_forwards);
  std::ranges::stable_sort(sound, {}, &ClockExchange::t1_ns);
  return sound;
}

// The quarter of least delay, but three at least, by t1.
std::vector<ClockExchange> least_delayed(std::vector<ClockExchange> exchanges) {
  std::ranges::stable_sort(exchanges, {}, delay_ns);
  exchanges.resize(std::min(exchanges.size(), std::max(kMinUsed, exchanges.size() / 4)));
  std::ranges::sort(exchanges, {}, &ClockExchange::t1_ns);
  return exchanges;
}

// agent - host = base + intercept + slope (host - origin), delays taken as alike both ways
struct OffsetLine {
  std::int64_t origin_ns = 0, base_ns = 0;  // the base keeps the digits of the rest
  double intercept_ns = 0.0;
  double slope = 0.0;

  double residual_ns(const ClockExchange& e) const {
    const double offset_ns = static_cast<double>(twice_offset_ns(e) - 2 * base_ns) / 2.0;
    return offset_ns - slope * static_cast<double>(midpoint_ns(e) - origin_ns) - intercept_ns;
  }
  std::vector<double> residuals_ns(const std::vector<ClockExchange>& exchanges) const {
    std::vector<double> residuals_ns;
    for (const ClockExchange& e : exchanges) residuals_ns.push_back(residual_ns(e));
    return residuals_ns;
  }
};

// Median of the slopes between exchanges at least a third of the span apart (Theil and Sen); bounded work for
// long recordings.
double median_slope(const std::vector<ClockExchange>& exchanges) {
  const std::size_t step = std::max<std::size_t>(1, exchanges.size() / 200);
  const double min_span =
      static_cast<double>(midpoint_ns(exchanges.back()) - midpoint_ns(exchanges.front())) / 3.0;
  std::vector<double> slopes;
  for (std::size_t i = 0; i < exchanges.size(); i += step)
    for (std::size_t j = i + 1; j < exchanges.size(); j += step) {
      const double span = static_cast<double>(midpoint_ns(exchanges[j]) - midpoint_ns(exchanges[i]));
      const std::int64_t twice_ns = twice_offset_ns(exchanges[j]) - twice_offset_ns(exchanges[i]);
      if (span > 0.0 && span >= min_span) slopes.push_back(static_cast<double>(twice_ns) / 2.0 / span);
    }
  return slopes.empty() ? 0.0 : upper_median(std::move(slopes));
}

OffsetLine fit_line(const std::vector<ClockExchange>& used, bool has_drift) {
  OffsetLine line{midpoint_ns(used.front()), twice_offset_ns(used.front()) / 2};
  if (has_drift) line.slope = median_slope(used);
  line.intercept_ns = upper_median(line.residuals_ns(used));
  return line;
}

// Standard deviation of the median of normal values, from their median absolute deviation.
double sigma_of_median(std::vector<double> values) {
  const double middle = upper_median(values);
  for (double& value : values) value = std::abs(value - middle);
  const auto count = static_cast<double>(values.size());
  return 1.4826 * upper_median(std::move(values)) * std::sqrt(kMedianVariance / count);
}

// Median of the least delayed exchanges of some seconds, against the line.
struct Window {
  std::int64_t agent_ns = 0;
  double residual_ns = 0.0;
  double sigma_ns = 0.0;
  double delays_ns = 0.0;  // what unlike delays both ways can add: half of the longest
};

// Windows of 10 s, of a quarter of a short recording, or longer where these hold fewer than twelve exchanges.
// Exchanges of more than twice the usual delay are left out, and windows that keep fewer than three.
std::vector<Window> windows_of(const std::vector<ClockExchange>& exchanges, const OffsetLine& line,
                               std::int64_t usual_delay_ns) {
  std::vector<Window> windows;
  const std::int64_t length_ns = std::min(kWindow_ns, (exchanges.back().t1_ns - exchanges.front().t1_ns) / 4);
  for (auto first = exchanges.begin(), end = first; first != exchanges.end(); first = end) {
    while (end != exchanges.end() &&
           (end->t1_ns - first->t1_ns < length_ns || end - first < kMinWindowExchanges))
      ++end;
    std::vector<ClockExchange> used = least_delayed({first, end});
    std::erase_if(used, [&](const ClockExchange& e) { return delay_ns(e) > 2 * usual_delay_ns; });
    if (used.size() < kMinUsed) continue;
    const std::vector<double> residuals_ns = line.residuals_ns(used);
    const std::int64_t longest_ns = delay_ns(*std::ranges::max_element(used, {}, delay_ns));
    windows.push_back({used[used.size() / 2].t2_ns, upper_median(residuals_ns), sigma_of_median(residuals_ns),
                       0.5 * static_cast<double>(longest_ns)});
  }
  std::vector<double> sigmas_ns;
  for (const Window& w : windows) sigmas_ns.push_back(w.sigma_ns);
  // one window's own is too uncertain
  if (!windows.empty())
    for (const double usual_ns = upper_median(sigmas_ns); Window & w : windows) w.sigma_ns = usual_ns;
  return windows;
}

// The line's and the clock's own uncertainty, from what the windows show of it, or of few windows from the
// exchanges themselves.
void state_sigma(AgentClock& clock, const OffsetLine& line, const std::vector<ClockExchange>& used,
                 const std::vector<Window>& windows) {
  clock.middle_sigma_ns = sigma_of_median(line.residuals_ns(used));
  if (windows.size() >= kMinUsed) {
    double squares = 0.0;
    for (const Window& w : windows) squares += w.residual_ns * w.residual_ns;
    squares /= static_cast<double>(windows.size());
    clock.middle_sigma_ns = std::max(
        clock.middle_sigma_ns, std::sqrt(kMedianVariance * squares / static_cast<double>(windows.size())));
    clock.residual_sigma_ns = std::sqrt(std::max(0.0, squares - windows[0].sigma_ns * windows[0].sigma_ns));
  }
  // one or two exchanges show no spread; anywhere within the bound is as likely
  if (used.size() < kMinUsed) clock.middle_sigma_ns = static_cast<double>(clock.bound_ns) / std::sqrt(3.0);
  const auto span_ns = static_cast<double>((clock.last - clock.first).ns);
  clock.drift_sigma = clock.has_drift ? std::sqrt(12.0) * clock.middle_sigma_ns / span_ns : kUnknownDrift;
}

// Finds the clock's largest distance from the line: that of a window beyond its noise, up to 20 ms where
// unlike delays may explain it, or that of three exchanges in a row beyond half of their own delay, as behind
// the moment at which a clock was set.
void find_deviation(AgentClock& clock, const OffsetLine& line, const std::vector<ClockExchange>& exchanges,
                    const std::vector<Window>& windows) {
  const auto take = [&](double away_ns, std::int64_t agent_ns) {
    if (const Duration away{std::llround(away_ns)}; away > clock.deviation) {
      clock.deviation = away;
      clock.deviation_after = AgentTime{agent_ns} - clock.first;
    }
  };
  for (const Window& w : windows)
    if (const double away_ns = std::abs(w.residual_ns); away_ns > kCertainSigmas * w.sigma_ns)
      take(std::min(away_ns, std::max(away_ns - w.delays_ns, kExplained_ns)), w.agent_ns);
  constexpr std::size_t kInARow = 3;
  for (const double side : {1.0, -1.0})
    for (std::size_t i = 0, row = 0; i < exchanges.size(); ++i) {
      const auto beyond_ns = [&](const ClockExchange& e) {
        return side * line.residual_ns(e) - 0.5 * static_cast<double>(delay_ns(e));
      };
      row = beyond_ns(exchanges[i]) > 0.0 ? row + 1 : 0;
      if (row < kInARow) continue;
      take(std::min({beyond_ns(exchanges[i]), beyond_ns(exchanges[i - 1]), beyond_ns(exchanges[i - 2])}),
           exchanges[i - 2].t2_ns);
    }
}

}  // namespace

OffsetUncertainty AgentClock::uncertainty(AgentTime t) const {
  if (exchanges_used == 0) return {};
  const AgentTime middle{first.ns + (last - first).ns / 2};
  const Duration outside{std::max({std::int64_t{0}, (first - t).ns, (t - last).ns})};
  const double sigma_ns = std::hypot(std::hypot(residual_sigma_ns, middle_sigma_ns),
                                     drift_sigma * static_cast<double>((t - middle).ns),
                                     kWarmingDrift * static_cast<double>(outside.ns));
  return {std::llround(sigma_ns), bound_ns, outside};
}

std::int64_t AgentClock::sigma_ns() const {
  return std::max(uncertainty(first).sigma_ns, uncertainty(last).sigma_ns);
}

AgentClock fit_agent_clock(std::span<const ClockExchange> exchanges) {
  AgentClock clock;
  const std::vector<ClockExchange> sound = forwards_by_time(exchanges);
  clock.exchanges = exchanges.size();
  clock.exchanges_backwards = exchanges.size() - sound.size();
  if (sound.empty()) return clock;
  const std::vector<ClockExchange> used = least_delayed(sound);
  clock.exchanges_used = used.size();
  clock.first = {sound.front().t2_ns};
  clock.last = {sound.back().t3_ns};
  // a slope from a short burst would be carried far beyond it
  clock.has_drift = midpoint_ns(used.back()) - midpoint_ns(used.front()) >= kMinDriftSpan_ns;
  const OffsetLine line = fit_line(used, clock.has_drift);
  const ClockMap<AgentTag, HostClock> agent_from_host{
      {line.origin_ns}, {line.origin_ns + line.base_ns + std::llround(line.intercept_ns)}, line.slope};
  clock.line = agent_from_host.inverse();
  // unlike delays of both ways move the midpoint of an exchange by half of its delay at most
  for (const ClockExchange& e : used)
    clock.bound_ns =
        std::max<std::int64_t>(clock.bound_ns, delay_ns(e) / 2 + std::llround(std::abs(line.residual_ns(e))));
  std::int64_t usual_delay_ns = 0;
  for (const ClockExchange& e : used) usual_delay_ns = std::max(usual_delay_ns, delay_ns(e));
  const std::vector<Window> windows = windows_of(sound, line, usual_delay_ns);
  state_sigma(clock, line, used, windows);
  find_deviation(clock, line, sound, windows);
  return clock;
}

LiveClock::LiveClock(std::span<const ClockExchange> exchanges) {
  for (const ClockExchange& e : exchanges)
    exchanges_.push_back({{e.t3_ns},
                          {(e.t4_ns - e.t1_ns) - (e.t3_ns - e.t2_ns)},
                          {((e.t1_ns - e.t2_ns) + (e.t4_ns - e.t3_ns)) / 2}});
  std::ranges::stable_sort(exchanges_, {}, &Known::answered);
}

HostTime LiveClock::operator()(AgentTime t) const {
  constexpr std::ptrdiff_t kRecent = 8;
  if (exchanges_.empty()) return {t.ns};
  const auto end =
      std::max(exchanges_.begin() + 1, std::ranges::upper_bound(exchanges_, t, {}, &Known::answered));
  const auto first = end - std::min(kRecent, end - exchanges_.begin());
  return {t.ns + std::ranges::min_element(first, end, {}, &Known::delay)->host_minus_agent.ns};
}

}  // namespace trilat
