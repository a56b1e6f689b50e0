// SPDX-License-Identifier: MIT
#include "evaluators/metrics/error_statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

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

double ErrorSums::mae_m() const { return distance_m_.value() / static_cast<double>(answered_); }

Eigen::Vector3d ErrorSums::axis_mae_m() const {
  const auto n = static_cast<double>(answered_);
  return {axis_distance_m_[0].value() / n, axis_distance_m_[1].value() / n, axis_distance_m_[2].value() / n};
}

double ErrorSums::rmse_m() const { return std::sqrt(squared_m2_.value() / static_cast<double>(answered_)); }

double ErrorSums::max_m() const { return answered_ == 0 ? kNaN : max_m_; }

namespace {

// Puts the values of all `ranks`, which rise, in their places; `values` begins at rank `first`.
void place(std::span<double> values, std::size_t first, std::span<const std::size_t> ranks) {
  if (ranks.empty()) return;
  const std::size_t middle = ranks.size() / 2, at = ranks[middle] - first;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  place(values.first(at), first, ranks.first(middle));
  place(values.subspan(at + 1), ranks[middle] + 1, ranks.subspan(middle + 1));
}

}  // namespace

std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles) {
  TRILAT_CHECK(std::ranges::is_sorted(quantiles) &&
                   (quantiles.empty() || (quantiles.front() >= 0.0 && quantiles.back() <= 1.0)),
               "quantiles rise from 0 to 1");
  TRILAT_CHECK(std::ranges::none_of(values, [](double x) { return std::isnan(x); }), "a value is a number");
  std::vector<double> result(quantiles.size(), std::numeric_limits<double>::quiet_NaN());
  if (values.empty()) return result;
  const std::size_t last = values.size() - 1;
  std::vector<std::size_t> ranks;
  for (const double q : quantiles)
    for (const std::size_t above : {0, 1})
      ranks.push_back(
          std::min(static_cast<std::size_t>(std::floor(static_cast<double>(last) * q)) + above, last));
  std::ranges::sort(ranks);
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  place(values, 0, ranks);
  for (std::size_t i = 0; i < quantiles.size(); ++i) {
    const double position = static_cast<double>(last) * quantiles[i], share = position - std::floor(position);
    const auto rank = static_cast<std::size_t>(position);
    const double below = values[rank], above = values[std::min(rank + 1, last)];
    result[i] = share == 0.0 || below == above ? below : below + share * (above - below);
  }
  return result;
}

}  // namespace trilat
