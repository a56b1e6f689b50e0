// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A sum whose rounding error does not grow with the number of terms (Neumaier 1974). Depends on the order of
// its terms in the last bits: add and merge in a fixed order.
class CompensatedSum {
 public:
  void add(double value);
  void merge(const CompensatedSum& later);
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0;
  double lost_ = 0.0;
};

// One cell of a table, fed one item at a time. An item is asked when there is a truth to compare with, and
// answered when its status is usable.
class ErrorSums {
 public:
  // `error_m` is estimate - truth after alignment; read only when the status is usable, and then finite
  // (InternalError).
  void add(SolveStatus status, const Eigen::Vector3d& error_m);
  // As if `later`'s items had been added after what is here.
  void merge(const ErrorSums& later);

  std::int64_t asked() const { return asked_; }
  std::int64_t answered() const { return answered_; }
  std::int64_t count_of(SolveStatus status) const { return status_counts_[static_cast<std::size_t>(status)]; }
  // Of the answered items; NaN when there is none.
  double mae_m() const;                // mean of |error|, as in the paper
  Eigen::Vector3d axis_mae_m() const;  // mean of |x|, |y|, |z|
  double rmse_m() const;               // sqrt(mean of |error|^2)
  double max_m() const;

 private:
  std::int64_t asked_ = 0;
  std::int64_t answered_ = 0;
  std::array<std::int64_t, kSolveStatusCount> status_counts_{};
  CompensatedSum distance_m_;
  CompensatedSum squared_m2_;
  std::array<CompensatedSum, 3> axis_distance_m_;
  double max_m_ = 0.0;
};

// The quantiles of `values`, in the order asked for, which rises from 0 to 1. Quantile q of n values in order
// is x at position (n - 1) q, linear between neighbours (type 7 of Hyndman and Fan 1996); NaN without values.
// Infinity is allowed; InternalError for NaN.
std::vector<double> quantiles_of(std::vector<double> values, const std::vector<double>& quantiles);

}  // namespace trilat
