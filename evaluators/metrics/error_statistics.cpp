// SPDX-License-Identifier: MIT
#include "evaluators/metrics/error_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "datasets/base/error.h"

namespace trilat {

void CompensatedSum::add(double value) {
  const double total = sum_ + value;
  lost_ += std::abs(sum_) >= std::abs(value) ? (sum_ - total) + value : (value - total) + sum_;
  sum_ = total;
}

void CompensatedSum::merge(const CompensatedSum& later) {
  add(later.sum_);
  add(later.lost_);
}

void ErrorSums::add(SolveStatus status, const Eigen::Vector3d& error_m) {
  ++asked_;
  ++status_counts_[static_cast<std::size_t>(status)];
  if (!is_usable(status)) return;
  TRILAT_CHECK(error_m.allFinite(), "a usable estimate has a finite error");
  ++answered_;
  const double square_m2 = error_m.squaredNorm();
  distance_m_.add(std::sqrt(square_m2));
  squared_m2_.add(square_m2);
  for (int axis = 0; axis < 3; ++axis) axis_distance_m_[axis].add(std::abs(error_m[axis]));
  max_m_ = std::max(max_m_, std::sqrt(square_m2));
}

void ErrorSums::merge(const ErrorSums& later) {
  asked_ += later.asked_;
  answered_ += later.answered_;
  for (std::size_t i = 0; i < status_counts_.size(); ++i) status_counts_[i] += later.status_counts_[i];
  distance_m_.merge(later.distance_m_);
  squared_m2_.merge(later.squared_m2_);
  for (int axis = 0; axis < 3; ++axis) axis_distance_m_[axis].merge(later.axis_distance_m_[axis]);
  max_m_ = std::max(max_m_, later.max_m_);
}

ErrorStatistics ErrorStatistics::of(const ErrorSums& sums, const QuantileSelection& distances_m) {
  const std::vector<double> quantiles = distances_m.quantiles();
  TRILAT_CHECK(quantiles.size() == kErrorQuantiles.size() && distances_m.count() == sums.answered_,
               "quantiles are of the same items");
  ErrorStatistics result;
  result.asked = sums.asked_;
  result.answered = sums.answered_;
  result.status_counts = sums.status_counts_;
  if (sums.asked_ > 0)
    result.coverage = static_cast<double>(sums.answered_) / static_cast<double>(sums.asked_);
  if (sums.answered_ == 0) return result;
  const auto n = static_cast<double>(sums.answered_);
  result.mae_m = sums.distance_m_.value() / n;
  for (int axis = 0; axis < 3; ++axis) result.axis_mae_m[axis] = sums.axis_distance_m_[axis].value() / n;
  result.rmse_m = std::sqrt(sums.squared_m2_.value() / n);
  result.p05_m = quantiles[0];
  result.p25_m = quantiles[1];
  result.median_m = quantiles[2];
  result.p75_m = quantiles[3];
  result.p90_m = quantiles[4];
  result.p95_m = quantiles[5];
  result.max_m = sums.max_m_;
  return result;
}

}  // namespace trilat
