// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/movement_lag.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/SVD>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {
namespace {

constexpr double kSearch_s = 1.0, kLeastCorrelation = 0.5;
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

// In instants, one block left out. `by_lag`: from -most to most.
double best_lag(const std::vector<BlockSums>& by_lag, std::ptrdiff_t most, std::size_t without) {
  std::vector<double> correlation;
  for (const BlockSums& blocks : by_lag) correlation.push_back(correlation_of(blocks, without));
  const auto peak =
      std::ranges::max_element(correlation, [](double a, double b) { return std::isnan(a) || a < b; });
  const auto unshifted = static_cast<std::size_t>(most);
  if (peak == correlation.begin() || peak + 1 >= correlation.end() || !(*peak > kLeastCorrelation) ||
      !(1.0 - correlation[unshifted] > kDisagreementWithout * (1.0 - *peak)) ||
      !(*peak > correlation_of(by_lag[unshifted], without, true)))
    return kNaN;
  const double left = *(peak - 1), right = *(peak + 1);
  const double between = 0.5 * (left - right) / (left - 2.0 * *peak + right);  // of the parabola
  return static_cast<double>(peak - correlation.begin() - most) + between;
}

}  // namespace

MovementLag lag_of(const Movements& own, const Movements& others, double rate_hz) {
  if (static_cast<double>(own.moved_m.size() / own.joints) < kShortest_s * rate_hz) return {kNaN, kNaN};
  const auto most = static_cast<std::ptrdiff_t>(kSearch_s * rate_hz);
  std::vector<BlockSums> by_lag;
  for (std::ptrdiff_t lag = -most; lag <= most; ++lag) by_lag.push_back(sums_at(own, others, lag));
  const double lag = best_lag(by_lag, most, kBlocks);
  double squares = 0.0;
  for (std::size_t b = 0; b < kBlocks; ++b)
    squares += std::pow(best_lag(by_lag, most, b) - lag, 2);  // NaN where a block decides
  if (std::isnan(squares)) return {kNaN, kNaN};
  constexpr double kCount = kBlocks;
  return {lag / rate_hz, std::sqrt((kCount - 1.0) / kCount * squares) / rate_hz};
}

}  // namespace trilat
