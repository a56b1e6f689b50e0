// SPDX-License-Identifier: MIT
#include "pipeline/recording/spread_times.h"

#include <algorithm>
#include <cmath>

#include "evaluators/metrics/quantile_selection.h"

namespace trilat {

TimeSpread spread_times(std::vector<double> times_s) {
  std::erase_if(times_s, [](double t) { return !std::isfinite(t); });
  TimeSpread spread;
  spread.n = times_s.size();
  for (double t : times_s) {
    const auto edge = std::upper_bound(kTimeEdges_s.begin() + 1, kTimeEdges_s.end(), t);
    ++spread.bins[static_cast<std::size_t>(edge - kTimeEdges_s.begin()) - 1];
  }
  if (times_s.empty()) return spread;
  const auto q = quantiles_of(times_s, {0.5, 0.95, 0.99, 0.999, 1.0});
  spread.median_s = q[0];
  spread.p95_s = q[1];
  spread.p99_s = q[2];
  spread.p999_s = q[3];
  spread.max_s = q[4];
  return spread;
}

}  // namespace trilat
