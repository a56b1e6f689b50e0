// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_totals.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace trilat {
namespace {

void describe_digits(const SweepTotals& totals, SweepCell& cell) {
  const SweepCounts& counts = totals.counts;
  cell.digits_trials = counts.digit_bins.all();
  cell.mean_digits = totals.sum[SweepSums::digits].value() / static_cast<double>(cell.digits_trials);
  cell.p50_digits = std::clamp(bin_digits(counts.digit_bins.quantile(0.5)), counts.min_digits, kMostDigits);
  cell.min_digits = counts.min_digits;
}

}  // namespace

void SweepTotals::add(const SweepSums& chunk) {
  counts.add(chunk.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term].add(chunk.sum[term]);
}

void SweepTotals::add(const SweepTotals& other) {
  counts.add(other.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term].add(other.sum[term]);
}

SweepCell SweepTotals::cell() const {
  SweepCell cell;
  cell.asked = counts.asked;
  for (std::size_t i = 0; i < counts.statuses.size(); ++i) {
    if (counts.statuses[i] == 0) continue;
    cell.statuses[std::string(name_of(static_cast<SolveStatus>(i)))] = counts.statuses[i];
    if (is_usable(static_cast<SolveStatus>(i))) cell.answered += counts.statuses[i];
  }
  const auto mean = [&](SweepSums::Term term, std::uint64_t n) {
    return sum[term].value() / static_cast<double>(n);
  };
  if (counts.starts > 0) cell.start_mae_m = mean(SweepSums::start, counts.starts);
  if (cell.asked > 0) {
    cell.mean_iterations = mean(SweepSums::iterations, cell.asked);
    cell.p50_iterations = static_cast<double>(counts.iteration_counts.quantile(0.5));
    cell.p99_iterations = static_cast<double>(counts.iteration_counts.quantile(0.99));
    cell.max_iterations = static_cast<double>(counts.iteration_counts.quantile(1.0));
  }
  const std::uint64_t n = cell.answered;
  if (n == 0) return cell;
  cell.mae_m = mean(SweepSums::distance, n);
  cell.axis_mae_m = {mean(SweepSums::x, n), mean(SweepSums::y, n), mean(SweepSums::z, n)};
  const double mean_square_m2 = mean(SweepSums::square, n);
  cell.rmse_m = std::sqrt(mean_square_m2);
  if (n > 1)
    cell.mae_standard_error_m =
        std::sqrt(std::max(0.0, mean_square_m2 - cell.mae_m * cell.mae_m) / (static_cast<double>(n) - 1.0));
  cell.p50_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.5)));
  cell.p95_m = std::min(counts.max_m, bin_distance_m(counts.distance_bins.quantile(0.95)));
  cell.max_m = counts.max_m;
  if (counts.digit_bins.all() > 0) describe_digits(*this, cell);
  return cell;
}

}  // namespace trilat
