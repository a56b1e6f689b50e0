// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/error_spread.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

// Where the paper sees the error grow: columns 0 to 149 and 351 to the last.
constexpr std::size_t kMiddleFrom = 150, kMiddleTo = 350;

struct Mean {
  double sum = 0.0, n = 0.0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    n += 1.0;
  }
  double value() const { return n > 0.0 ? sum / n : kNotMeasured; }
};

}  // namespace

ErrorSpread spread_of(const std::vector<ClusteredError>& errors) {
  ErrorSpread spread;
  std::map<std::size_t, std::pair<double, double>> clusters;  // sum, count
  std::vector<double> answered;
  double sum = 0.0, squares = 0.0;
  for (const ClusteredError& e : errors) {
    ++spread.asked;
    if (!std::isfinite(e.error_m)) continue;
    answered.push_back(e.error_m);
    sum += e.error_m;
    clusters[e.cluster].first += e.error_m;
    clusters[e.cluster].second += 1.0;
  }
  spread.answered = answered.size();
  if (answered.empty()) return spread;
  const double n = static_cast<double>(answered.size());
  spread.mean_m = sum / n;
  for (double error : answered) squares += (error - spread.mean_m) * (error - spread.mean_m);
  if (answered.size() > 1) spread.sd_m = std::sqrt(squares / (n - 1.0));
  const auto q = quantiles_of(answered, {0.5, 0.95, 1.0});
  spread.median_m = q[0];
  spread.p95_m = q[1];
  spread.max_m = q[2];
  std::vector<double> sums, counts;
  for (const auto& [cluster, s] : clusters) {
    sums.push_back(s.first);
    counts.push_back(s.second);
  }
  std::tie(spread.mean_low_m, spread.mean_high_m) = mean_interval(sums, counts);
  return spread;
}

std::string mean_text(const ErrorSpread& spread) {
  if (spread.answered == 0 || !std::isfinite(spread.mean_m)) return "an unknown distance (no answer)";
  std::string text = fmt::format("{:.2f} cm", spread.mean_m * kCentimetresPerMetre);
  if (!std::isfinite(spread.mean_low_m) || !std::isfinite(spread.mean_high_m))
    return text + " (too few sensors for an interval)";
  return text + fmt::format(" (95 % interval {:.2f} to {:.2f} cm)", spread.mean_low_m * kCentimetresPerMetre,
                            spread.mean_high_m * kCentimetresPerMetre);
}

ColumnMeans column_means(const std::vector<double>& by_column) {
  Mean left, middle, right, edge;
  for (std::size_t c = 0; c < by_column.size(); ++c) {
    const bool is_left = c<kMiddleFrom, is_right = c> kMiddleTo;
    (is_left ? left : is_right ? right : middle).add(by_column[c]);
    if (is_left || is_right) edge.add(by_column[c]);
  }
  return {left.value(), middle.value(), right.value(), edge.value()};
}

}  // namespace trilat
