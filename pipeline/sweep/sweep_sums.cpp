// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace trilat {
namespace {

constexpr int kBinBits = 6;                        // of the mantissa
constexpr std::uint64_t kFirstOctave = 1023 - 40;  // 1e-12 m
constexpr std::uint64_t kOctaves = 64;
constexpr std::size_t kLanes = 8;

// Eight sums side by side, added up in one order whatever the processor does at once.
struct LaneSums {
  std::array<double, kLanes> of{};
  double total() const { return ((of[0] + of[4]) + (of[2] + of[6])) + ((of[1] + of[5]) + (of[3] + of[7])); }
};

void add_carefully(double& sum, double& lost, double term) {
  const double total = sum + term;
  lost += std::abs(sum) >= std::abs(term) ? (sum - total) + term : (term - total) + sum;
  sum = total;
}

double quantile_of(std::vector<double> values, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
  const auto at = values.begin() + std::max<std::ptrdiff_t>(rank, 0);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void describe_digits(const std::vector<double>& digits, SweepCell& cell) {
  double sum = 0.0;
  for (const double d : digits) sum += d;
  cell.digits_trials = digits.size();
  cell.mean_digits = sum / static_cast<double>(digits.size());
  cell.p50_digits = quantile_of(digits, 0.5);
  cell.min_digits = *std::min_element(digits.begin(), digits.end());
}

}  // namespace

std::size_t Counts::quantile(double share) const {
  std::uint64_t all = 0;
  for (const std::uint64_t count : counts_) all += count;
  const auto rank = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(all)));
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
  return std::clamp(bin, first, first + (kOctaves << kBinBits) - 1) - first;
}

double bin_distance_m(std::size_t bin) {
  if (bin == 0) return 0.0;
  const std::uint64_t bits = (bin + (kFirstOctave << kBinBits)) << (52 - kBinBits);
  const double low = std::bit_cast<double>(bits);
  const double high = std::bit_cast<double>(bits + (std::uint64_t{1} << (52 - kBinBits)));
  return 0.5 * (low + high);
}

void SweepSums::clear() {
  distance_bins.clear();
  iteration_counts.clear();
  digits.clear();
  sum = lost = {};
  asked = starts = 0;
  statuses = {};
  max_m = 0.0;
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
    starts += finite ? 1 : 0;
  }
  sum[start] += sums.total();
}

void SweepSums::add_outcomes(const SweepOutcomeRows& rows) {
  std::array<LaneSums, kTerms> sums;
  asked += rows.count;
  for (std::size_t i = 0; i < rows.count; ++i) {
    ++statuses[static_cast<std::size_t>(rows.status[i])];
    const std::size_t lane = i % kLanes;
    sums[iterations].of[lane] += rows.iterations[i];
    iteration_counts.add(static_cast<std::size_t>(rows.iterations[i]));
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
    max_m = std::max(max_m, distance_m);
    distance_bins.add(distance_bin(distance_m));
  }
  for (const Term term : {x, y, z, distance, square, iterations}) sum[term] += sums[term].total();
}

void SweepSums::add(const SweepSums& later) {
  for (std::size_t term = 0; term < kTerms; ++term) {
    add_carefully(sum[term], lost[term], later.sum[term]);
    add_carefully(sum[term], lost[term], later.lost[term]);
  }
  asked += later.asked;
  starts += later.starts;
  for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += later.statuses[i];
  max_m = std::max(max_m, later.max_m);
  distance_bins.add(later.distance_bins);
  iteration_counts.add(later.iteration_counts);
  digits.insert(digits.end(), later.digits.begin(), later.digits.end());
}

SweepCell SweepSums::cell() const {
  SweepCell cell;
  cell.asked = asked;
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (statuses[i] == 0) continue;
    cell.statuses[std::string(name_of(static_cast<SolveStatus>(i)))] = statuses[i];
    if (is_usable(static_cast<SolveStatus>(i))) cell.answered += statuses[i];
  }
  if (starts > 0) cell.start_mae_m = (sum[start] + lost[start]) / static_cast<double>(starts);
  if (cell.asked > 0) {
    cell.mean_iterations = (sum[iterations] + lost[iterations]) / static_cast<double>(asked);
    cell.p50_iterations = static_cast<double>(iteration_counts.quantile(0.5));
    cell.p99_iterations = static_cast<double>(iteration_counts.quantile(0.99));
    cell.max_iterations = static_cast<double>(iteration_counts.quantile(1.0));
  }
  if (cell.answered == 0) return cell;
  const double n = static_cast<double>(cell.answered);
  const auto mean = [&](Term term) { return (sum[term] + lost[term]) / n; };
  cell.mae_m = mean(distance);
  cell.axis_mae_m = {mean(x), mean(y), mean(z)};
  cell.rmse_m = std::sqrt(mean(square));
  if (cell.answered > 1)
    cell.mae_standard_error_m = std::sqrt(std::max(0.0, mean(square) - cell.mae_m * cell.mae_m) / (n - 1.0));
  cell.p50_m = std::min(max_m, bin_distance_m(distance_bins.quantile(0.5)));
  cell.p95_m = std::min(max_m, bin_distance_m(distance_bins.quantile(0.95)));
  cell.max_m = max_m;
  if (!digits.empty()) describe_digits(digits, cell);
  return cell;
}

}  // namespace trilat
