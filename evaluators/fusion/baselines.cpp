// SPDX-License-Identifier: MIT
#include "evaluators/fusion/baselines.h"

#include <algorithm>
#include <array>
#include <optional>

#include <Eigen/Cholesky>

#include "datasets/base/error.h"

namespace trilat {
namespace {

PointEstimate estimate_at(const Eigen::Vector3d& position_m, SolveStatus status, int iterations) {
  PointEstimate result;
  result.position_m = position_m;
  result.status = status;
  result.iterations = iterations;
  return result;
}

PointEstimate baseline_at(const Eigen::Vector3d& position_m) {
  if (!position_m.allFinite()) return failed_estimate(SolveStatus::non_finite_input);
  return estimate_at(position_m, SolveStatus::closed_form, 0);
}

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

Eigen::Vector3d mean_of(const Points& points) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points.count; ++i) sum_m += points.at_m[i];
  return sum_m / static_cast<double>(points.count);
}

// The sum of distances about x, all that a step of the median needs.
struct DistanceSum {
  double value_m = 0.0;
  Eigen::Vector3d influence = Eigen::Vector3d::Zero();  // minus the gradient, without points at x itself
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
    sum.influence += direction;
    sum.curvature += (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / distance_m;
    sum.weighted += points.at_m[i] / distance_m;
    sum.weights += 1.0 / distance_m;
  }
  return sum;
}

// Weiszfeld's step, which always makes the sum smaller off the points, or the one of Newton's step and its
// halves that makes it smaller still: beside two points that nearly coincide whole ones go too far.
Eigen::Vector3d median_step(const Points& points, const Eigen::Vector3d& x, const DistanceSum& sum) {
  const double length = sum.influence.norm();
  const double stay = length > 0.0 ? std::min(1.0, sum.on_it / length) : 1.0;
  Eigen::Vector3d best = (1.0 - stay) * (sum.weighted / sum.weights) + stay * x;
  if (sum.on_it > 0.0) return best;
  double least_m = distance_sum(points, best).value_m;
  const Eigen::Vector3d newton_m = sum.curvature.ldlt().solve(sum.influence);
  constexpr int kHalvings = 12;
  for (int k = 0; k <= kHalvings && newton_m.allFinite(); ++k) {
    const Eigen::Vector3d next = x + std::ldexp(1.0, -k) * newton_m;
    const double value_m = distance_sum(points, next).value_m;
    if (value_m < least_m) {
      least_m = value_m;
      best = next;
    } else if (k > 0 && least_m < sum.value_m && best != next && value_m < sum.value_m) {
      break;  // shorter ones make it less small again
    }
  }
  return best;
}

PointEstimate median_of(const Points& points, const MedianOptions& options) {
  Eigen::Vector3d x = mean_of(points);
  if (points.count <= 2) return estimate_at(x, SolveStatus::closed_form, 0);
  for (std::size_t i = 0; i < points.count; ++i) {  // a point that the others cannot pull away from
    const DistanceSum sum = distance_sum(points, points.at_m[i]);
    if (sum.influence.norm() <= sum.on_it) return estimate_at(points.at_m[i], SolveStatus::closed_form, 0);
  }
  for (int k = 1; k <= options.max_iterations; ++k) {
    const Eigen::Vector3d next = median_step(points, x, distance_sum(points, x));
    const double moved_m = (next - x).norm();
    x = next;
    if (moved_m < options.step_tolerance_m) return estimate_at(x, SolveStatus::converged, k);
  }
  return estimate_at(x, SolveStatus::iteration_limit, options.max_iterations);
}

}  // namespace

PointEstimate solve_single_sensor(std::span<const JointObservation> observations,
                                  const SingleSensorOptions& options) {
  TRILAT_CHECK(options.sensor >= 0 && static_cast<std::size_t>(options.sensor) < observations.size(),
               "the rig has the sensor");
  const JointObservation& observation = observations[options.sensor];
  return observation.seen ? baseline_at(observation.point_in_world_m)
                          : failed_estimate(SolveStatus::no_observation);
}

namespace {

// The position that the mean leaves out, as MeanOptions::outlier_m says; nothing where there is none.
std::optional<std::size_t> outlier_of(std::span<const JointObservation> observations,
                                      const MeanOptions& options) {
  if (!(options.outlier_m > 0.0)) return std::nullopt;
  const PointEstimate median = solve_median(observations, {.allowed = options.allowed});
  std::optional<std::size_t> farthest;
  double limit_m = options.outlier_m;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!options.allowed[i] || !observations[i].seen) continue;
    const double away_m = (observations[i].point_in_world_m - median.position_m).norm();
    if (!(away_m > limit_m)) continue;
    limit_m = away_m;
    farthest = i;
  }
  return farthest;
}

}  // namespace

PointEstimate solve_mean(std::span<const JointObservation> observations, const MeanOptions& options) {
  TRILAT_CHECK(observations.size() <= kMaxSensors, "the rig is within the capacity");
  const std::optional<std::size_t> outlier = outlier_of(observations, options);
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d tracked_sum_m = Eigen::Vector3d::Zero();
  int seen = 0;
  int tracked = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!options.allowed[i] || !observations[i].seen || i == outlier) continue;
    sum_m += observations[i].point_in_world_m;
    ++seen;
    if (observations[i].state != TrackingState::tracked) continue;
    tracked_sum_m += observations[i].point_in_world_m;
    ++tracked;
  }
  if (seen == 0) return failed_estimate(SolveStatus::no_observation);
  if (options.prefer_tracked && tracked > 0) return baseline_at(tracked_sum_m / tracked);
  return baseline_at(sum_m / seen);
}

PointEstimate solve_median(std::span<const JointObservation> observations, const MedianOptions& options) {
  const Points points = allowed_points(observations, options.allowed);
  if (points.count == 0) return failed_estimate(SolveStatus::no_observation);
  if (!all_finite(points)) return failed_estimate(SolveStatus::non_finite_input);
  return median_of(points, options);
}

}  // namespace trilat
