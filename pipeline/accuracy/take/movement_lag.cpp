// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/movement_lag.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/SVD>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

constexpr double kSearch_s = 1.0, kFarSearch_s = 3.0;  // where the first shows that a lag is needed
constexpr double kLeastCorrelation = 0.5;
constexpr double kShortest_s = 6.0;  // in less a few steps agree at several lags
// The part of the movements that does not agree is so many times as large without the lag.
constexpr double kDisagreementWithout = 1.1;
constexpr std::size_t kBlocks = 8;  // of time

// Products of two streams, summed over one block of time.
struct MovementSums {
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double squares = 0.0, other_squares = 0.0;
};
using BlockSums = std::array<MovementSums, kBlocks>;

BlockSums sums_at(const Movements& own, const Movements& others, std::ptrdiff_t lag) {
  BlockSums sums;
  const auto count = static_cast<std::ptrdiff_t>(own.moved_m.size());
  const std::ptrdiff_t shift = lag * static_cast<std::ptrdiff_t>(own.joints);
  for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, shift); k < std::min(count, count + shift); ++k) {
    const Eigen::Vector3d& a = own.moved_m[static_cast<std::size_t>(k)];
    const Eigen::Vector3d& b = others.moved_m[static_cast<std::size_t>(k - shift)];
    if (!a.allFinite() || b.isZero(0.0)) continue;
    MovementSums& block = sums[static_cast<std::size_t>(k) * kBlocks / own.moved_m.size()];
    block.products += a * b.transpose();
    block.squares += a.squaredNorm();
    block.other_squares += b.squaredNorm();
  }
  return sums;
}

// `turned`: one stream turned as it agrees best with the other.
double correlation_of(const BlockSums& blocks, std::size_t without, bool turned = false) {
  MovementSums sum;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (b == without) continue;
    sum.products += blocks[b].products;
    sum.squares += blocks[b].squares;
    sum.other_squares += blocks[b].other_squares;
  }
  const Eigen::Vector3d singular = sum.products.jacobiSvd().singularValues();
  const double best = singular[0] + singular[1] + std::copysign(singular[2], sum.products.determinant());
  return (turned ? best : sum.products.trace()) / std::sqrt(sum.squares * sum.other_squares);
}

// The sums of every lag from -most to most.
struct LagSearch {
  std::ptrdiff_t most;
  std::vector<BlockSums> by_lag;
  LagSearch(const Movements& own, const Movements& others, std::ptrdiff_t most_lag) : most(most_lag) {
    for (std::ptrdiff_t lag = -most; lag <= most; ++lag) by_lag.push_back(sums_at(own, others, lag));
  }
};

// The correlation at each lag, one block left out, and the place of the highest.
struct Correlations {
  std::vector<double> at;
  std::size_t peak = 0, unshifted;
  double unshifted_turned;  // without a lag, one stream turned as it agrees best
  Correlations(const LagSearch& search, std::size_t without)
      : unshifted(static_cast<std::size_t>(search.most)),
        unshifted_turned(correlation_of(search.by_lag[unshifted], without, true)) {
    for (const BlockSums& blocks : search.by_lag) at.push_back(correlation_of(blocks, without));
    peak = static_cast<std::size_t>(
        std::ranges::max_element(at, [](double a, double b) { return std::isnan(a) || a < b; }) - at.begin());
  }
  bool agrees() const { return at[peak] > kLeastCorrelation; }
  // Nearly as well as with the best lag.
  bool agrees_without() const {
    return !(1.0 - at[unshifted] > kDisagreementWithout * (1.0 - at[peak])) || !(at[peak] > unshifted_turned);
  }
};

// In instants, one block left out; NaN where no lag is needed, or none within the search is the best.
double best_lag(const LagSearch& search, std::size_t without) {
  const Correlations c(search, without);
  if (!c.agrees() || c.agrees_without() || c.peak == 0 || c.peak + 1 == c.at.size()) return kNaN;
  const double left = c.at[c.peak - 1], right = c.at[c.peak + 1];
  const double between = 0.5 * (left - right) / (left - 2.0 * c.at[c.peak] + right);  // of the parabola
  return static_cast<double>(c.peak) - static_cast<double>(search.most) + between;
}

}  // namespace

MovementLag lag_of(const Movements& own, const Movements& others, double rate_hz) {
  if (static_cast<double>(own.moved_m.size() / own.joints) < kShortest_s * rate_hz) return {kNaN, kNaN};
  const auto instants = [&](double seconds) { return static_cast<std::ptrdiff_t>(seconds * rate_hz); };
  const Correlations near({own, others, instants(kSearch_s)}, kBlocks);
  if (!near.agrees() || near.agrees_without()) return {kNaN, kNaN};
  const LagSearch search(own, others, instants(kFarSearch_s));
  const double lag = best_lag(search, kBlocks);
  double squares = 0.0;
  for (std::size_t b = 0; b < kBlocks; ++b)
    squares += std::pow(best_lag(search, b) - lag, 2);  // NaN where a block decides
  if (std::isnan(squares)) return {kNaN, kNaN};
  constexpr double kCount = kBlocks;
  return {lag / rate_hz, std::sqrt((kCount - 1.0) / kCount * squares) / rate_hz};
}

}  // namespace trilat
