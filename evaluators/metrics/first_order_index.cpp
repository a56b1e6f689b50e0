// SPDX-License-Identifier: MIT
#include "evaluators/metrics/first_order_index.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

constexpr std::size_t kFewest = 8, kMostBins = 12;

std::size_t bins_of(std::size_t points) {
  const auto root = static_cast<std::size_t>(std::sqrt(static_cast<double>(points)));
  return std::clamp<std::size_t>(root / 2, 2, kMostBins);
}

// Of values in the order of their positions, one left out (or none: `without` is their number).
double index_without(const std::vector<double>& values, std::size_t without) {
  const std::size_t n = values.size() - (without < values.size() ? 1 : 0), bins = bins_of(values.size());
  std::vector<double> sum(bins), count(bins);
  double all = 0.0, squares = 0.0;
  for (std::size_t i = 0, place = 0; i < values.size(); ++i) {
    if (i == without) continue;
    const std::size_t bin = place++ * bins / n;
    sum[bin] += values[i];
    count[bin] += 1.0;
    all += values[i];
    squares += values[i] * values[i];
  }
  const auto points = static_cast<double>(n);
  const double total = squares - all * all / points;
  double between = -all * all / points;
  for (std::size_t bin = 0; bin < bins; ++bin) between += sum[bin] * sum[bin] / count[bin];
  const double within = (total - between) / (points - static_cast<double>(bins));  // mean square
  return (between - static_cast<double>(bins - 1) * within) / total;
}

}  // namespace

VarianceShare first_order_index(std::span<const double> positions, std::span<const double> values) {
  std::vector<std::pair<double, double>> points;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) points.emplace_back(positions[i], values[i]);
  if (points.size() < kFewest) return {};
  std::ranges::sort(points);
  std::vector<double> sorted;
  for (const auto& [position, value] : points) sorted.push_back(value);
  const double index = index_without(sorted, sorted.size());
  if (!std::isfinite(index)) return {};  // all values are the same
  const auto n = static_cast<double>(sorted.size());
  double mean = 0.0, squares = 0.0;
  std::vector<double> without;
  for (std::size_t i = 0; i < sorted.size(); ++i) mean += without.emplace_back(index_without(sorted, i)) / n;
  for (const double one : without) squares += (one - mean) * (one - mean);
  const double reach = student_quantile(sorted.size() - 1) * std::sqrt((n - 1.0) / n * squares);
  const auto share = [](double value) { return std::clamp(value, 0.0, 1.0); };
  return {share(index), share(index - reach), share(index + reach)};
}

}  // namespace trilat
