// SPDX-License-Identifier: MIT
#include "evaluators/fusion/range_bearing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/error.h"
#include "evaluators/solvers/descent.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

// A joint as one sensor sees it.
struct Ray {
  Vector3d sensor_m, point_m, direction;
  double range_m = 0.0, range_weight = 0.0, bearing_weight = 0.0;  // weights: inverse variances in 1/m^2
};

// The views that count.
struct Rays {
  int count = 0;
  std::array<Ray, kMaxSensors> of;
  std::span<const Ray> all() const { return {of.data(), static_cast<std::size_t>(count)}; }
};

Rays rays_of(std::span<const JointObservation> observations,
             std::span<const RigidTransform> world_from_sensor, const RangeBearingOptions& options) {
  Rays rays;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const JointObservation& o = observations[i];
    if (!options.allowed[i] || !o.seen) continue;
    const double factor = o.state == TrackingState::inferred ? options.sigma.inferred_factor : 1.0;
    const double range_sigma_m = factor * options.sigma.range_m,
                 bearing_sigma_m = factor * options.sigma.bearing_m;
    const Vector3d sensor_m = world_from_sensor[i].translation_m;
    rays.of[static_cast<std::size_t>(rays.count++)] = {
        sensor_m,
        o.point_in_world_m,
        (o.point_in_world_m - sensor_m) / std::max(o.range_m, kOnSensor_m),  // 0 on the sensor
        o.range_m,
        1.0 / (range_sigma_m * range_sigma_m),
        1.0 / (bearing_sigma_m * bearing_sigma_m)};
  }
  return rays;
}

// How far a place is off what one sensor sees.
struct Residual {
  Vector3d e;  // direction from the sensor to the place
  double distance_m = 0.0, along_m = 0.0;
  Vector3d across_m;
  double square = 0.0;  // of all, in sigmas
};
Residual residual_at(const Ray& ray, const Vector3d& x_m) {
  const Vector3d v = x_m - ray.sensor_m;
  const double distance_m = std::max(v.norm(), kOnSensor_m), along_m = distance_m - ray.range_m;
  const Vector3d across_m = v - ray.direction.dot(v) * ray.direction;
  return {v / distance_m, distance_m, along_m, across_m,
          ray.range_weight * along_m * along_m + ray.bearing_weight * across_m.squaredNorm()};
}

// The weight with which a view's residual enters the normal equations.
double weight_of(const RangeBearingOptions& options, double square) {
  if (options.loss == Loss::squares) return 1.0;
  return 1.0 / (1.0 + square / (options.loss_scale * options.loss_scale));
}

// weight (I - direction direction^T)
void add_projection(Symmetric3& matrix, double weight, const Vector3d& direction) {
  matrix.add_to_diagonal(weight);
  matrix.add_outer(-weight, direction);
}

Linearised linearise(const Rays& rays, const RangeBearingOptions& options, const Vector3d& x_m) {
  Linearised sum{{}, Vector3d::Zero()};
  double grown = 0.0;  // the product of all 1 + square / scale^2, less 1: costs add up by one logarithm
  for (const Ray& ray : rays.all()) {
    const Residual r = residual_at(ray, x_m);
    const double weight = weight_of(options, r.square), share = 1.0 / weight - 1.0;
    const double range_weight = weight * ray.range_weight, bearing_weight = weight * ray.bearing_weight;
    sum.matrix.add_outer(range_weight, r.e);
    add_projection(sum.matrix, bearing_weight, ray.direction);
    sum.gradient += range_weight * r.along_m * r.e + bearing_weight * r.across_m;
    sum.cost += r.square;
    sum.rounding_scale +=
        r.distance_m * (range_weight * std::abs(r.along_m) + bearing_weight * r.across_m.norm());
    grown += share + grown * share;
  }
  if (options.loss == Loss::cauchy) sum.cost = options.loss_scale * options.loss_scale * std::log1p(grown);
  return sum;
}

Descent descend(const Rays& rays, const RangeBearingOptions& options, const Vector3d& start_m,
                double step_tolerance_m) {
  DescentOptions descent;
  descent.step_tolerance_m = step_tolerance_m;
  descent.max_iterations = options.max_iterations;
  const auto at = [&](const Vector3d& x_m, Curvature) { return linearise(rays, options, x_m); };
  return minimise(at, start_m, at(start_m, Curvature::gauss_newton).matrix.trace(), descent);
}

// The lowest of the minima that descents find: from the mean and, where a sensor is so far off that the loss
// bends back, from what each sees, since each may be right.
Descent global_minimum(const Rays& rays, const RangeBearingOptions& options) {
  constexpr double kCoarse_m = 1e-4;  // tells whose minimum is the lowest, which then is found exactly
  Vector3d mean_m = Vector3d::Zero();
  for (const Ray& ray : rays.all()) mean_m += ray.point_m / rays.count;
  if (options.loss == Loss::squares) return descend(rays, options, mean_m, options.step_tolerance_m);
  Descent best = descend(rays, options, mean_m, kCoarse_m);
  int iterations = best.iterations;
  const auto is_far_off = [&](const Ray& ray) {
    return !(residual_at(ray, best.position_m).square <= options.loss_scale * options.loss_scale);
  };
  if (std::ranges::any_of(rays.all(), is_far_off))
    for (const Ray& ray : rays.all()) {
      const Descent found = descend(rays, options, ray.point_m, kCoarse_m);
      iterations += found.iterations;
      if (found.cost < best.cost) best = found;
    }
  best = descend(rays, options, best.position_m, options.step_tolerance_m);
  best.iterations += iterations;
  return best;
}

// Estimate at the minimum. Its covariance weighs each view as the loss does there, so that a dismissed view
// adds no information.
PointEstimate estimate_of(const Rays& rays, const RangeBearingOptions& options, const Descent& minimum) {
  RangeProblem ranges;
  Symmetric3 information;
  for (const Ray& ray : rays.all()) {
    ranges.sensor_m[ranges.count] = ray.sensor_m;
    ranges.range_m[ranges.count++] = ray.range_m;
    const Residual r = residual_at(ray, minimum.position_m);
    const double weight = weight_of(options, r.square);
    information.add_outer(weight * ray.range_weight, r.e);
    add_projection(information, weight * ray.bearing_weight, r.e);
  }
  PointEstimate estimate = estimate_at(ranges, minimum.position_m, minimum.status, minimum.iterations);
  const Symmetric3 inverse = information.adjugate();
  estimate.covariance = inverse.matrix() / information.determinant(inverse);
  return estimate;
}

}  // namespace

std::string contradiction_in(const RangeBearingOptions& o) {
  for (const double sigma_m : {o.sigma.range_m, o.sigma.bearing_m})
    if (!(sigma_m > 0.0) || std::isinf(sigma_m)) return "both sigmas must be greater than 0 and finite";
  if (!(o.sigma.inferred_factor > 0.0)) return "the factor of inferred joints must be greater than 0";
  if (!(o.loss_scale > 0.0)) return "the scale of the loss must be greater than 0";
  return {};
}

PointEstimate solve_range_bearing(std::span<const JointObservation> observations,
                                  std::span<const RigidTransform> world_from_sensor,
                                  const RangeBearingOptions& options) {
  TRILAT_CHECK(observations.size() == world_from_sensor.size() && observations.size() <= kMaxSensors,
               "every sensor has one observation and one pose");
  TRILAT_CHECK(contradiction_in(options).empty(), "the options fit each other");
  const Rays rays = rays_of(observations, world_from_sensor, options);
  if (rays.count == 0) return failed_estimate(SolveStatus::no_observation);
  for (const Ray& ray : rays.all())
    if (!ray.sensor_m.allFinite() || !ray.point_m.allFinite() || !std::isfinite(ray.range_m))
      return failed_estimate(SolveStatus::non_finite_input);
  const Descent minimum = global_minimum(rays, options);
  if (!is_usable(minimum.status) && minimum.status != SolveStatus::iteration_limit)
    return failed_estimate(minimum.status);
  return estimate_of(rays, options, minimum);
}

double range_bearing_cost(std::span<const JointObservation> observations,
                          std::span<const RigidTransform> world_from_sensor,
                          const RangeBearingOptions& options, const Eigen::Vector3d& x_m) {
  return linearise(rays_of(observations, world_from_sensor, options), options, x_m).cost;
}

}  // namespace trilat
