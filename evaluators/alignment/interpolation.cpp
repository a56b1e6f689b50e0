// SPDX-License-Identifier: MIT
#include "evaluators/alignment/interpolation.h"

#include <algorithm>
#include <cmath>

namespace trilat {
namespace {

constexpr double kReach = 3.0;  // sigma

}  // namespace

std::optional<LocalMotion> local_motion(const PointPath& path, double time_s, double sigma_s,
                                        double longest_gap_s) {
  const double per_square = 1.0 / (sigma_s * sigma_s);
  const double reach_s = kReach * sigma_s, widest_s = std::max(longest_gap_s, 1.5 * sigma_s);
  const auto from = std::ranges::lower_bound(path.time_s, time_s - reach_s);
  double weights = 0.0, first_moment = 0.0, second_moment = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  int before = 0, after = 0;
  double last_s = time_s - std::min(reach_s, widest_s);
  for (auto it = from; it != path.time_s.end() && *it <= time_s + reach_s; ++it) {
    const Eigen::Vector3d& position = path.position_m[static_cast<std::size_t>(it - path.time_s.begin())];
    if (!position.allFinite()) continue;
    // a hole far out carries little weight and does no harm
    if (*it - last_s > widest_s && std::abs(0.5 * (*it + last_s) - time_s) < 2.0 * sigma_s)
      return std::nullopt;
    last_s = *it;
    const double since = *it - time_s;
    (since <= 0.0 ? before : after) += 1;
    const double weight = std::exp(-0.5 * since * since * per_square);
    weights += weight;
    first_moment += weight * since;
    second_moment += weight * since * since;
    sum += weight * position;
    moment += weight * since * position;
  }
  if (before == 0 || after == 0 || before + after < 3 || time_s - last_s > widest_s) return std::nullopt;
  const double determinant = weights * second_moment - first_moment * first_moment;
  if (!(determinant > 1e-12 * weights * second_moment)) return std::nullopt;
  return LocalMotion{(second_moment * sum - first_moment * moment) / determinant,
                     (weights * moment - first_moment * sum) / determinant};
}

}  // namespace trilat
