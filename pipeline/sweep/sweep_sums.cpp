// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace trilat {
namespace {

constexpr int kBinBits = 6;                        // of the mantissa
constexpr std::uint64_t kFirstOctave = 1023 - 40;  // 1e-12 m
constexpr double kBinsPerDigit = 256.0;
constexpr std::size_t kLanes = 8;

// Eight sums side by side, added up in one order whatever the processor does at once.
struct LaneSums {
  std::array<double, kLanes> of{};
  double total() const { return ((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7])); }
};

void describe_digits(const SweepSums& sums, SweepCell& cell) {
  const SweepCounts& counts = sums.counts;
  cell.digits_trials = counts.digit_bins.all();
  cell.mean_digits = sums.sum[SweepSums::digits] / static_cast<double>(cell.digits_trials);
  cell.p50_digits = std::clamp(bin_digits(counts.digit_bins.quantile(0.5)), counts.min_digits, kMostDigits);
  cell.min_digits = counts.min_digits;
}

}  // namespace

std::uint64_t Counts::all() const {
  std::uint64_t all = 0;
  for (const std::uint64_t count : counts_) all += count;
  return all;
}

std::size_t Counts::quantile(double share) const {
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(all())));
  std::uint64_t seen = 0;
  for (std::size_t value = 0; value < counts_.size(); ++value) {
    seen += counts_[value];
    if (seen > 0 && seen >= rank) return value;
  }
  return 0;
}

std::size_t distance_bin(double distance_m) {
  const std::uint64_t bin = std::bit_cast<std::uint64_t>(distance_m) >> (52 - kBinBits);
  constexpr std::uint64_t first = kFirstOctave << kBinBits;
  return std::clamp(bin, first, first + kDistanceBins - 1) - first;
}

double bin_distance_m(std::size_t bin) {
  if (bin == 0) return 0.0;
  const std::uint64_t bits = (bin + (kFirstOctave << kBinBits)) << (52 - kBinBits);
  const double low = std::bit_cast<double>(bits);
  const double high = std::bit_cast<double>(bits + (std::uint64_t{1} << (52 - kBinBits)));
  return 0.5 * (low + high);
}

std::size_t digit_bin(double digits) {
  return static_cast<std::size_t>(std::clamp(digits, 0.0, kMostDigits) * kBinsPerDigit);
}

double bin_digits(std::size_t bin) { return (static_cast<double>(bin) + 0.5) / kBinsPerDigit; }

void SweepCounts::add(const SweepCounts& other) {
  asked += other.asked;
  starts += other.starts;
  for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += other.statuses[i];
  max_m = std::max(max_m, other.max_m);
  min_digits = std::min(min_digits, other.min_digits);
  distance_bins.add(other.distance_bins);
  iteration_counts.add(other.iteration_counts);
  digit_bins.add(other.digit_bins);
}

void SweepSums::add(const SweepSums& later) {
  counts.add(later.counts);
  for (std::size_t term = 0; term < sum.size(); ++term) sum[term] += later.sum[term];
}

void SweepSums::add_starts(const SweepOutcomeRows& rows) {
  LaneSums sums;
  for (std::size_t i = 0; i < rows.count; ++i) {
    const double dx = rows.position_m[i] - rows.truth_m[i];
    const double dy = rows.position_m[rows.stride + i] - rows.truth_m[rows.stride + i];
    const double dz = rows.position_m[2 * rows.stride + i] - rows.truth_m[2 * rows.stride + i];
    const double distance_m = std::sqrt(dx * dx + dy * dy + dz * dz);
    const bool finite = std::isfinite(distance_m);
    sums.of[i % kLanes] += finite ? distance_m : 0.0;
    counts.starts += finite ? 1 : 0;
  }
  sum[start] += sums.total();
}

void SweepSums::add_outcomes(const SweepOutcomeRows& rows) {
  std::array<LaneSums, kTerms> sums;
  counts.asked += rows.count;
  for (std::size_t i = 0; i < rows.count; ++i) {
    ++counts.statuses[static_cast<std::size_t>(rows.status[i])];
    const std::size_t lane = i % kLanes;
    sums[iterations].of[lane] += rows.iterations[i];
    counts.iteration_counts.add(static_cast<std::size_t>(rows.iterations[i]));
    if (!is_usable(rows.status[i])) continue;
    const double dx = std::abs(rows.position_m[i] - rows.truth_m[i]);
    const double dy = std::abs(rows.position_m[rows.stride + i] - rows.truth_m[rows.stride + i]);
    const double dz = std::abs(rows.position_m[2 * rows.stride + i] - rows.truth_m[2 * rows.stride + i]);
    const double square_m2 = dx * dx + dy * dy + dz * dz;
    const double distance_m = std::sqrt(square_m2);
    sums[x].of[lane] += dx;
    sums[y].of[lane] += dy;
    sums[z].of[lane] += dz;
    sums[distance].of[lane] += distance_m;
    sums[square].of[lane] += square_m2;
    counts.max_m = std::max(counts.max_m, distance_m);
    counts.distance_bins.add(distance_bin(distance_m));
  }
  for (const Term term : {x, y, z, distance, square, iterations}) sum[term] += sums[term].total();
}

void SweepSums::add_digits(double digits_of_trial) {
  sum[digits] += digits_of_trial;
  counts.min_digits = std::min(counts.min_digits, digits_of_trial);
  counts.digit_bins.add(digit_bin(digits_of_trial));
}

SweepCell cell_of(const SweepSums& sums) {
  const SweepCounts& counts = sums.counts;
  SweepCell cell;
  cell.asked = counts.asked;
  for (std::size_t i = 0; i < counts.statuses.size(); ++i) {
    if (counts.statuses[i] == 0) continue;
    cell.statuses[std::string(name_of(static_cast<SolveStatus>(i)))] = counts.statuses[i];
    if (is_usable(static_cast<SolveStatus>(i))) cell.answered += counts.statuses[i];
  }
  const auto mean = [&](SweepSums::Term term, std::uint64_t n) {
    return sums.sum[term] / static_cast<double>(n);
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
  if (counts.digit_bins.all() > 0) describe_digits(sums, cell);
  return cell;
}

}  // namespace trilat
