// SPDX-License-Identifier: MIT
#include "evaluators/fusion/robust_fusion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "datasets/base/error.h"

namespace trilat {
namespace {

// The allowed positions.
struct Points {
  std::array<Eigen::Vector3d, kMaxSensors> at_m;
  std::size_t count = 0;
};

Points allowed_points(std::span<const JointObservation> observations, SensorMask allowed) {
  TRILAT_CHECK(observations.size() <= kMaxSensors, "the rig is within the capacity");
  Points points;
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (allowed[i] && observations[i].seen) points.at_m[points.count++] = observations[i].point_in_world_m;
  return points;
}

bool all_finite(const Points& points) {
  for (std::size_t i = 0; i < points.count; ++i)
    if (!points.at_m[i].allFinite()) return false;
  return true;
}

PointEstimate estimate_at(const Eigen::Vector3d& position_m, SolveStatus status, int iterations) {
  PointEstimate result;
  result.position_m = position_m;
  result.status = status;
  result.iterations = iterations;
  return result;
}

Eigen::Vector3d mean_of(const Points& points) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.count; ++i) sum_m += points.at_m[i];
  return sum_m / static_cast<double>(points.count);
}

// The sum of distances about x, all that a step of the median needs.
struct DistanceSum {
  double value_m = 0.0;
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();  // minus the gradient, without points at x itself
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero();  // Weiszfeld's step goes to weighted / weights
  double weights = 0.0;
  double on_it = 0.0;  // points at x
};

DistanceSum distance_sum(const Points& points, const Eigen::Vector3d& x) {
  DistanceSum sum;
  for (std::size_t i = 0; i < points.count; ++i) {
    const Eigen::Vector3d to = points.at_m[i] - x;
    const double distance_m = to.norm();
    if (distance_m == 0.0) {
      sum.on_it += 1.0;
      continue;
    }
    const Eigen::Vector3d direction = to / distance_m;
    sum.value_m += distance_m;
    sum.pull += direction;
    sum.curvature += (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / distance_m;
    sum.weighted += points.at_m[i] / distance_m;
    sum.weights += 1.0 / distance_m;
  }
  return sum;
}

// Newton's step where it makes the sum smaller, else Weiszfeld's, which always does off the points.
Eigen::Vector3d median_step(const Points& points, const Eigen::Vector3d& x, const DistanceSum& sum) {
  const Eigen::Vector3d newton = x + sum.curvature.ldlt().solve(sum.pull);
  if (sum.on_it == 0.0 && newton.allFinite() && distance_sum(points, newton).value_m < sum.value_m)
    return newton;
  const double length = sum.pull.norm();
  const double stay = length > 0.0 ? std::min(1.0, sum.on_it / length) : 1.0;
  return (1.0 - stay) * (sum.weighted / sum.weights) + stay * x;
}

PointEstimate median_of(const Points& points, double tolerance_m, int max_iterations) {
  Eigen::Vector3d x = mean_of(points);
  if (points.count <= 2) return estimate_at(x, SolveStatus::closed_form, 0);
  for (std::size_t i = 0; i < points.count; ++i) {  // a point that the others cannot pull away from
    const DistanceSum sum = distance_sum(points, points.at_m[i]);
    if (sum.pull.norm() <= sum.on_it) return estimate_at(points.at_m[i], SolveStatus::closed_form, 0);
  }
  for (int k = 1; k <= max_iterations; ++k) {
    const Eigen::Vector3d next = median_step(points, x, distance_sum(points, x));
    const double moved_m = (next - x).norm();
    x = next;
    if (moved_m < tolerance_m) return estimate_at(x, SolveStatus::converged, k);
  }
  return estimate_at(x, SolveStatus::iteration_limit, max_iterations);
}

}  // namespace

PointEstimate solve_weighted_mean(std::span<const JointObservation> observations,
                                  const WeightedMeanOptions& options) {
  TRILAT_CHECK(observations.size() <= kMaxSensors, "the rig is within the capacity");
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double weights = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const JointObservation& o = observations[i];
    if (!options.allowed[i] || !o.seen) continue;
    double weight = o.state == TrackingState::tracked ? 1.0 : options.inferred_weight;
    if (options.by_depth_noise) {
      const double sigma_m = options.noise.sigma_m(o.range_m, 0.0);
      weight /= sigma_m * sigma_m;
    }
    sum_m += weight * o.point_in_world_m;
    weights += weight;
  }
  if (weights == 0.0) return failed_estimate(SolveStatus::no_observation);
  const Eigen::Vector3d position_m = sum_m / weights;
  if (!position_m.allFinite()) return failed_estimate(SolveStatus::non_finite_input);
  return estimate_at(position_m, SolveStatus::closed_form, 0);
}

PointEstimate solve_median(std::span<const JointObservation> observations, const MedianOptions& options) {
  const Points points = allowed_points(observations, options.allowed);
  if (points.count == 0) return failed_estimate(SolveStatus::no_observation);
  if (!all_finite(points)) return failed_estimate(SolveStatus::non_finite_input);
  return median_of(points, options.step_tolerance_m, options.max_iterations);
}

PointEstimate solve_robust_mean(std::span<const JointObservation> observations,
                                const RobustMeanOptions& options) {
  const Points points = allowed_points(observations, options.allowed);
  if (points.count == 0) return failed_estimate(SolveStatus::no_observation);
  if (!all_finite(points)) return failed_estimate(SolveStatus::non_finite_input);
  // a rough median is start enough
  Eigen::Vector3d x = median_of(points, 1e-3 * options.scale_m, 50).position_m;
  if (points.count == 1) return estimate_at(x, SolveStatus::closed_form, 0);
  for (int k = 1; k <= options.max_iterations; ++k) {
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (std::size_t i = 0; i < points.count; ++i) {
      const double weight =
          1.0 / (1.0 + (points.at_m[i] - x).squaredNorm() / (options.scale_m * options.scale_m));
      weighted += weight * points.at_m[i];
      weights += weight;
    }
    const Eigen::Vector3d next = weighted / weights;
    const double moved_m = (next - x).norm();
    x = next;
    if (moved_m < options.step_tolerance_m) return estimate_at(x, SolveStatus::converged, k);
  }
  return estimate_at(x, SolveStatus::iteration_limit, options.max_iterations);
}

}  // namespace trilat
