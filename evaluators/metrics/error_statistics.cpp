// SPDX-License-Identifier: MIT
#include "evaluators/metrics/error_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

#include "datasets/base/error.h"
#include "evaluators/metrics/quantiles.h"

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

ErrorStatistics ErrorStatistics::of(const ErrorSums& sums, std::vector<double> distances_m) {
  TRILAT_CHECK(std::ssize(distances_m) == sums.answered_, "distances are of the same items");
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
  const auto q = quantiles_of(std::move(distances_m), {0.05, 0.25, 0.5, 0.75, 0.9, 0.95});
  std::tie(result.p05_m, result.p25_m, result.median_m) = std::tie(q[0], q[1], q[2]);
  std::tie(result.p75_m, result.p90_m, result.p95_m) = std::tie(q[3], q[4], q[5]);
  result.max_m = sums.max_m_;
  return result;
}

}  // namespace trilat
