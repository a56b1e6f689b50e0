// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/error_spread.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>

#include "datasets/base/philox.h"
#include "evaluators/metrics/cluster_ratios.h"
#include "evaluators/metrics/error_statistics.h"
#include "evaluators/metrics/quantiles.h"

namespace trilat {
ErrorSpread spread_of(const std::vector<ClusteredError>& errors, std::uint64_t seed) {
  ErrorSpread spread;
  std::map<std::size_t, std::pair<double, double>> clusters;  // sum, count
  std::vector<double> answered;
  CompensatedSum sum, squares;
  for (const ClusteredError& e : errors) {
    ++spread.asked;
    if (!std::isfinite(e.error_m)) continue;
    answered.push_back(e.error_m);
    sum.add(e.error_m);
    clusters[e.cluster].first += e.error_m;
    clusters[e.cluster].second += 1.0;
  }
  spread.answered = answered.size();
  if (answered.empty()) return spread;
  const double n = static_cast<double>(answered.size());
  spread.mean_m = sum.value() / n;
  for (double error : answered) squares.add((error - spread.mean_m) * (error - spread.mean_m));
  if (answered.size() > 1) spread.sd_m = std::sqrt(squares.value() / (n - 1.0));
  const auto q = quantiles_of(answered, {0.5, 0.95, 1.0});
  spread.median_m = q[0];
  spread.p95_m = q[1];
  spread.max_m = q[2];
  std::vector<double> sums, counts;
  for (const auto& [cluster, s] : clusters) {
    sums.push_back(s.first);
    counts.push_back(s.second);
  }
  std::tie(spread.mean_low_m, spread.mean_high_m) = bootstrap_mean(sums, counts, seed);
  return spread;
}

PoseMisfit misfit_of(const Eigen::Matrix<double, 6, 1>& error,
                     const Eigen::Matrix<double, 6, 6>& covariance) {
  constexpr double kNormal95 = 1.959964;
  const Eigen::Array<double, 6, 1> z2 = error.array().square() / covariance.diagonal().array();
  PoseMisfit misfit{z2.head<3>().mean(), z2.tail<3>().mean(), error.dot(covariance.ldlt().solve(error)), 0,
                    6};
  for (const double axis : z2) misfit.covered += axis <= kNormal95 * kNormal95;
  return misfit;
}

}  // namespace trilat
