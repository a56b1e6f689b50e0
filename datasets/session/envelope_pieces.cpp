// SPDX-License-Identifier: MIT
#include "datasets/session/envelope_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trilat {
namespace {

using SensorLine = ClockMap<HostClock, SensorClock>;

constexpr double kMaxLineDrift = 1e-3;
constexpr Duration kShortestPiece{5'000'000'000};
constexpr Duration kShortestDriftSpan{10'000'000'000};
constexpr double kStraightPiece_ns = 300'000.0;
constexpr double kFastestPieceWander = 50e-6;  // change of a clock against its own straight line
constexpr std::size_t kFewestWindows = 3;

ArrivalEnvelope whole_envelope(const TickEpoch& epoch) {
  ArrivalEnvelope whole;
  for (const ArrivalEnvelope& window : epoch.windows)
    for (const ArrivalStamp& stamp : window.hull()) whole.add(stamp);
  return whole.empty() ? epoch.doubtful : whole;
}

// The frame of a window that is least late, and by how much.
struct LeastLate {
  ArrivalStamp stamp;
  double late_ns = 0.0;
};

LeastLate least_late(const ArrivalEnvelope& envelope, const SensorLine& line) {
  LeastLate least{{}, std::numeric_limits<double>::infinity()};
  for (const ArrivalStamp& stamp : envelope.hull()) {
    const auto late_ns = static_cast<double>((stamp.arrival - line(stamp.device)).ns);
    if (late_ns < least.late_ns) least = {stamp, late_ns};
  }
  return least;
}

// Without those that are later than the rest allow.
std::vector<LeastLate> punctual(const std::vector<LeastLate>& all) {
  std::vector<double> most_ns;  // from the windows before, then also from those after
  const auto limit = [](double late_ns, Duration away) {
    return late_ns + kFastestPieceWander * static_cast<double>(away.ns);
  };
  for (std::size_t i = 0; i < all.size(); ++i)
    most_ns.push_back(i == 0 ? all[i].late_ns
                             : std::min(all[i].late_ns, limit(most_ns[i - 1], all[i].stamp.device -
                                                                                  all[i - 1].stamp.device)));
  for (std::size_t i = all.size() - 1; i-- > 0;)
    most_ns[i] = std::min(most_ns[i], limit(most_ns[i + 1], all[i + 1].stamp.device - all[i].stamp.device));
  std::vector<LeastLate> kept;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].late_ns <= most_ns[i]) kept.push_back(all[i]);
  return kept;
}

bool is_straight(const std::vector<LeastLate>& windows) {
  return std::none_of(windows.begin(), windows.end(),
                      [](const LeastLate& w) { return std::abs(w.late_ns) > kStraightPiece_ns; });
}

}  // namespace

SensorLine envelope_line(const TickEpoch& epoch) {
  SensorLine line = whole_envelope(epoch).line();
  if (drift_left_out(epoch) != 0.0) line.drift = 0.0;
  return line;
}

double drift_left_out(const TickEpoch& epoch) {
  const double drift = whole_envelope(epoch).line().drift;
  return std::abs(drift) > kMaxLineDrift && epoch.last - epoch.first < kShortestPiece ? drift : 0.0;
}

SensorLine envelope_line(const TickEpoch& epoch, double drift_of_short) {
  if (epoch.last - epoch.first >= kShortestDriftSpan) return envelope_line(epoch);
  const ArrivalEnvelope whole = whole_envelope(epoch);
  const ArrivalStamp& first = whole.hull().front();
  const SensorLine through_first{first.device, first.arrival, drift_of_short};
  const ArrivalStamp least = least_late(whole, through_first).stamp;
  return {least.device, least.arrival, drift_of_short};
}

PiecewiseClock<HostClock, SensorClock> envelope_pieces(const TickEpoch& epoch, const SensorLine& line) {
  if (epoch.windows.size() < kFewestWindows) return along(line);
  std::vector<LeastLate> windows;
  for (const ArrivalEnvelope& window : epoch.windows) windows.push_back(least_late(window, line));
  windows = punctual(windows);
  if (is_straight(windows)) return along(line);
  std::vector<ClockKnot<HostClock, SensorClock>> knots;
  for (const LeastLate& w : windows)
    if (knots.empty() || w.stamp.device > knots.back().from)
      knots.push_back({w.stamp.device, w.stamp.arrival});
  return through(knots, line);
}

}  // namespace trilat
