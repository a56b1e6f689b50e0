// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "pipeline/stream_fit/stream_search.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxSignals = 6;
constexpr std::size_t kMaxClockLooks = 200;  // instants of the reference
constexpr double kStep_s = 0.04;             // between starts
constexpr double kSearchAtRate_s = 2.0;      // of starts at another rate
constexpr double kMinOverlap = 0.3;          // of the shorter stream
constexpr double kMinOverlap_s = 1.5;
constexpr double kMinVariation_m = 0.01;  // standard deviation of a distance
constexpr double kMinAgreement = 0.4;     // correlation
constexpr double kBehindBest = 0.35;      // of the correlation
constexpr std::size_t kMaxStarts = 200, kMaxRates = 16;
constexpr double kBlindSearch_s = 10.0;                 // shorter ones, and where no distance varies
constexpr double kMinStretch = 0.4, kMaxStretch = 2.5;  // of rates that are none of these

// Distances between points over time: instants x signals.
struct DistanceSignals {
  std::size_t signals = 0;
  std::vector<float> at_m;
};

// Two points, and those of the other side.
struct PointsOfSignal {
  std::size_t one, other, mirrored_one, mirrored_other;
};

float distance_m(const PointStream& stream, std::size_t instant, const PointsOfSignal& p) {
  return static_cast<float>(
      (stream.at(instant, p.one) - stream.at(instant, p.other)).norm() +
      (stream.at(instant, p.mirrored_one) - stream.at(instant, p.mirrored_other)).norm());
}

DistanceSignals signals_of(const PointStream& stream, const std::vector<PointsOfSignal>& points) {
  DistanceSignals signals{points.size(), {}};
  signals.at_m.reserve(stream.instants() * points.size());
  for (std::size_t i = 0; i < stream.instants(); ++i)
    for (const PointsOfSignal& p : points) signals.at_m.push_back(distance_m(stream, i, p));
  return signals;
}

double deviation_m(const PointStream& stream, const PointsOfSignal& p) {
  double count = 0.0, sum = 0.0, squares = 0.0;
  const std::size_t step = std::max<std::size_t>(1, stream.instants() / kMaxClockLooks);
  for (std::size_t i = 0; i < stream.instants(); i += step)
    if (const double m = distance_m(stream, i, p); std::isfinite(m)) {
      count += 1.0;
      sum += m;
      squares += m * m;
    }
  const double looks = static_cast<double>(stream.instants()) / static_cast<double>(step);
  if (count < 8.0 || count < 0.2 * looks) return 0.0;
  return std::sqrt(std::max(0.0, squares / count - sum / count * sum / count));
}

// The distances that vary most, of those that vary in both.
std::vector<PointsOfSignal> varying_points(const StreamPair& pair, const std::vector<std::size_t>& mirrored) {
  std::vector<std::pair<double, PointsOfSignal>> found;
  std::set<std::array<std::size_t, 4>> known;
  for (std::size_t j = 0; j < mirrored.size(); ++j)
    for (std::size_t k = j + 1; k < mirrored.size(); ++k) {
      std::array<std::size_t, 4> key{j, k, std::min(mirrored[j], mirrored[k]),
                                     std::max(mirrored[j], mirrored[k])};
      if (std::make_pair(key[2], key[3]) < std::make_pair(j, k)) continue;
      const PointsOfSignal points{j, k, mirrored[j], mirrored[k]};
      const double m = std::min(deviation_m(pair.reference, points), deviation_m(pair.subject, points));
      if (known.insert(key).second && m > kMinVariation_m) found.emplace_back(m, points);
    }
  std::ranges::sort(found, std::greater{}, &std::pair<double, PointsOfSignal>::first);
  found.resize(std::min(found.size(), kMaxSignals));
  std::vector<PointsOfSignal> points;
  for (const auto& [m, p] : found) points.push_back(p);
  return points;
}

class ClockSearch {
 public:
  ClockSearch(const StreamPair& pair, const std::vector<PointsOfSignal>& points)
      : pair_(pair),
        reference_(signals_of(pair.reference, points)),
        subject_(signals_of(pair.subject, points)) {}

  // Correlation of the variations, all signals together; -1 for too little overlap.
  double agreement(double stretch, double start_s) const {
    const std::size_t signals = reference_.signals;
    std::array<std::array<double, 6>, kMaxSignals> sums{};
    const std::size_t step = std::max<std::size_t>(1, pair_.reference.instants() / kMaxClockLooks);
    const double first_s = pair_.subject.first_s;
    const auto last = static_cast<double>(pair_.subject.instants()) - 1.0;
    for (std::size_t i = 0; i < pair_.reference.instants(); i += step) {
      const double place = (pair_.reference.time_s(i) - first_s - start_s) / stretch * pair_.subject.rate_hz;
      if (!(place >= 0.0 && place < last)) continue;
      const auto below = static_cast<std::size_t>(place);
      const double share = place - static_cast<double>(below);
      const float* const a = &reference_.at_m[i * signals];
      const float* const b = &subject_.at_m[below * signals];
      for (std::size_t s = 0; s < signals; ++s) {
        const double x = a[s], below_m = b[s], above_m = b[s + signals];
        const double y = below_m + share * (above_m - below_m);
        if (!std::isfinite(x + y)) continue;
        auto& sum = sums.at(s);
        sum[0] += 1.0;
        sum[1] += x;
        sum[2] += y;
        sum[3] += x * x;
        sum[4] += y * y;
        sum[5] += x * y;
      }
    }
    const double overlap_s = static_cast<double>(step) / pair_.reference.rate_hz;
    const double needed_s =
        std::max(kMinOverlap_s,
                 kMinOverlap * std::min(pair_.reference.duration_s(), stretch * pair_.subject.duration_s()));
    double products = 0.0, squares = 0.0, other_squares = 0.0;
    for (std::size_t s = 0; s < signals; ++s) {
      const auto& sum = sums.at(s);
      if (sum[0] * overlap_s < needed_s || sum[0] < 8.0) continue;
      products += sum[5] - sum[1] * sum[2] / sum[0];
      squares += sum[3] - sum[1] * sum[1] / sum[0];
      other_squares += sum[4] - sum[2] * sum[2] / sum[0];
    }
    return squares > 0.0 && other_squares > 0.0 ? products / std::sqrt(squares * other_squares) : -1.0;
  }

 private:
  const StreamPair& pair_;
  DistanceSignals reference_, subject_;
};

struct Peak {
  double agreement, stretch, start_s;
};

// Local maxima along a list of neighbours.
void add_peaks(const std::vector<Peak>& line, std::vector<Peak>& peaks) {
  for (std::size_t k = 0; k < line.size(); ++k) {
    const bool rises = k == 0 || line[k].agreement >= line[k - 1].agreement;
    const bool falls = k + 1 == line.size() || line[k].agreement > line[k + 1].agreement;
    if (rises && falls && line[k].agreement > kMinAgreement) peaks.push_back(line[k]);
  }
}

void keep_best(std::vector<Peak>& peaks, std::size_t count) {
  std::ranges::sort(peaks, std::greater{}, &Peak::agreement);
  if (peaks.empty()) return;
  const double enough = peaks.front().agreement - kBehindBest;
  std::erase_if(peaks, [&](const Peak& peak) { return peak.agreement < enough; });
  peaks.resize(std::min(peaks.size(), count));
}

std::vector<Peak> starts_of(const StreamPair& pair, const ClockSearch& search, double max_start_s) {
  // from where the subject ends before the reference begins to where it begins after the reference has ended
  const double least_s =
      std::max(-max_start_s, -pair.subject.duration_s()) + pair.reference.first_s - pair.subject.first_s;
  const double most_s =
      std::min(max_start_s, pair.reference.duration_s()) + pair.reference.first_s - pair.subject.first_s;
  std::vector<Peak> line, peaks;
  for (double start_s = std::floor(least_s / kStep_s) * kStep_s; start_s <= most_s; start_s += kStep_s)
    line.push_back({search.agreement(1.0, start_s), 1.0, start_s});
  add_peaks(line, peaks);
  keep_best(peaks, kMaxStarts);
  return peaks;
}

std::vector<Peak> rates_of(const StreamPair& pair, const ClockSearch& search) {
  std::vector<Peak> line, peaks;
  const double longest_s = std::max(pair.reference.duration_s(), pair.subject.duration_s());
  const double step = std::clamp(0.05 / longest_s, 0.0005, 0.02);
  for (double stretch = kMinStretch; stretch <= kMaxStretch; stretch *= 1.0 + step)
    line.push_back({search.agreement(stretch, 0.0), stretch, 0.0});
  add_peaks(line, peaks);
  std::set<long> known;
  for (const double stated : kFrameRates_hz)
    for (const double true_hz : kFrameRates_hz) {
      const double stretch = stated / true_hz;
      if (std::abs(std::log(stretch)) < 0.01 || !known.insert(std::lround(1e4 * stretch)).second) continue;
      line.clear();
      for (double start_s = -kSearchAtRate_s; start_s <= kSearchAtRate_s; start_s += 2.0 * kStep_s)
        line.push_back({search.agreement(stretch, start_s), stretch, start_s});
      add_peaks(line, peaks);
    }
  keep_best(peaks, kMaxRates);
  return peaks;
}

PointStream resized(const PointStream& stream, const std::vector<SizeChange>& sizes) {
  PointStream result = stream;
  for (std::size_t i = 0; i < result.instants(); ++i)
    undo_sizes(sizes, result.time_s(i), std::span(result.at_m).subspan(i * result.points, result.points));
  return result;
}

}  // namespace

std::vector<StreamChange> clock_candidates(const StreamPair& pair, const std::vector<std::size_t>& mirrored,
                                           const std::vector<SizeChange>& sizes,
                                           const StreamFitOptions& options) {
  std::vector<StreamChange> candidates(1);
  candidates.front().sizes = sizes;
  const bool has_starts = (options.causes & kStartCause) != 0, has_rates = (options.causes & kRateCause) != 0;
  if (!has_starts && !has_rates) return candidates;
  const auto add = [&](double stretch, double start_s) {
    StreamChange change;
    change.sizes = sizes;
    change.stretch = stretch;
    change.start_s = start_s;
    change.has_stretch = stretch != 1.0;
    change.has_start = start_s != 0.0;
    candidates.push_back(change);
  };
  const PointStream subject = resized(pair.subject, sizes);
  const StreamPair both{pair.reference, subject};
  const std::vector<PointsOfSignal> points = varying_points(both, mirrored);
  if (points.empty() || options.max_start_s <= kBlindSearch_s) {
    const double most_s = std::min(kBlindSearch_s, options.max_start_s);
    for (double start_s = -most_s; start_s <= most_s; start_s += 2.0 * kStep_s) add(1.0, start_s);
    return candidates;
  }
  const ClockSearch search(both, points);
  for (const Peak& peak : starts_of(both, search, options.max_start_s)) add(1.0, peak.start_s);
  if (has_rates)
    for (const Peak& peak : rates_of(both, search)) add(peak.stretch, peak.start_s);
  return candidates;
}

}  // namespace trilat
