// SPDX-License-Identifier: MIT
#include "evaluators/fusion/range_bearing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/error.h"
#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/squared_ranges.h"
#include "evaluators/solvers/symmetric3.h"

namespace trilat {
namespace {

// A joint as the sensors see it whose views count, in sigmas.
struct Rays {
  int count = 0;
  std::array<Eigen::Vector3d, kMaxSensors> sensor_m, point_m, direction;
  std::array<double, kMaxSensors> range_m, range_weight, bearing_weight;  // inverse variances in 1/m^2
};

Rays rays_of(std::span<const JointObservation> observations,
             std::span<const RigidTransform> world_from_sensor, const RangeBearingOptions& options) {
  Rays rays;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const JointObservation& o = observations[i];
    if (!options.allowed[i] || !o.seen) continue;
    const int k = rays.count++;
    const double factor = o.state == TrackingState::inferred ? options.sigma.inferred_factor : 1.0;
    const double range_sigma_m = factor * options.sigma.range_m,
                 bearing_sigma_m = factor * options.sigma.bearing_m;
    rays.sensor_m[k] = world_from_sensor[i].translation_m;
    rays.point_m[k] = o.point_in_world_m;
    rays.range_m[k] = o.range_m;
    rays.direction[k] =
        (o.point_in_world_m - rays.sensor_m[k]) / std::max(o.range_m, kOnSensor_m);  // 0 on the sensor
    rays.range_weight[k] = 1.0 / (range_sigma_m * range_sigma_m);
    rays.bearing_weight[k] = 1.0 / (bearing_sigma_m * bearing_sigma_m);
  }
  return rays;
}

bool is_finite(const Rays& rays) {
  for (int i = 0; i < rays.count; ++i)
    if (!rays.sensor_m[i].allFinite() || !rays.point_m[i].allFinite() || !std::isfinite(rays.range_m[i]))
      return false;
  return true;
}

// What the sensors' squared residuals cost together. Cauchy's is the logarithm of a product.
class Costs {
 public:
  explicit Costs(const RangeBearingOptions& options) : options_(options) {}
  // The weight with which the residual enters the normal equations.
  double add(double square) {
    const double limit = options_.loss_scale * options_.loss_scale;
    if (options_.loss == Loss::cauchy) {
      const double grown = square / limit;
      product_less_1_ += grown + product_less_1_ * grown;
      return 1.0 / (1.0 + grown);
    }
    sum_ += square;
    return 1.0;
  }
  double value() const {
    if (options_.loss != Loss::cauchy) return sum_;
    return options_.loss_scale * options_.loss_scale * std::log1p(product_less_1_);
  }

 private:
  const RangeBearingOptions& options_;
  double sum_ = 0.0, product_less_1_ = 0.0;
};

struct Equations {
  Symmetric3 normal;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // half the derivative
  double cost = 0.0;
};

void add_projection(Symmetric3& matrix, double weight, const Eigen::Vector3d& direction) {
  matrix.add_to_diagonal(weight);
  matrix.add_outer(-weight, direction);
}

// How far a place is off what one sensor sees.
struct Residual {
  Eigen::Vector3d e;  // direction from the sensor to the place
  double along_m;
  Eigen::Vector3d across_m;
  double square;  // of all, in sigmas
};
Residual residual_at(const Rays& rays, int i, const Eigen::Vector3d& x_m) {
  const Eigen::Vector3d v = x_m - rays.sensor_m[i];
  const double distance_m = v.norm(), along_m = distance_m - rays.range_m[i];
  const Eigen::Vector3d across_m = v - rays.direction[i].dot(v) * rays.direction[i];
  return {v / std::max(distance_m, kOnSensor_m), along_m, across_m,
          rays.range_weight[i] * along_m * along_m + rays.bearing_weight[i] * across_m.squaredNorm()};
}

Equations linearise(const Rays& rays, const RangeBearingOptions& options, const Eigen::Vector3d& x_m) {
  Equations result;
  Costs costs(options);
  for (int i = 0; i < rays.count; ++i) {
    const Residual r = residual_at(rays, i, x_m);
    const double weight = costs.add(r.square);
    const double range_weight = weight * rays.range_weight[i],
                 bearing_weight = weight * rays.bearing_weight[i];
    result.normal.add_outer(range_weight, r.e);
    add_projection(result.normal, bearing_weight, rays.direction[i]);
    result.gradient += range_weight * r.along_m * r.e + bearing_weight * r.across_m;
  }
  result.cost = costs.value();
  return result;
}

struct Minimum {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  double cost = std::numeric_limits<double>::infinity();
  SolveStatus status = SolveStatus::diverged;
  int iterations = 0;
};

// Levenberg and Marquardt: undamped until a step does not lower the cost.
Minimum descend(const Rays& rays, const RangeBearingOptions& options, const Eigen::Vector3d& start_m) {
  constexpr double kFirstDamping = 1e-3, kLargestDamping = 1e12;
  constexpr double kRounding = 1.0 + 1e-12;  // near the minimum only the gradient still tells where it is
  Minimum minimum{start_m, 0.0, SolveStatus::iteration_limit, 0};
  Equations here = linearise(rays, options, start_m);
  double damping = 0.0;
  while (minimum.iterations < options.max_iterations) {
    ++minimum.iterations;
    Symmetric3 damped = here.normal;
    damped.add_to_diagonal(damping * here.normal.trace());
    const Symmetric3 adjugate = damped.adjugate();
    const Eigen::Vector3d step_m = adjugate * here.gradient / -damped.determinant(adjugate);
    const Eigen::Vector3d next_m = minimum.position_m + step_m;
    const Equations there = linearise(rays, options, next_m);
    if (!std::isfinite(there.cost) && damping >= kLargestDamping) break;
    const bool is_small = step_m.norm() < options.step_tolerance_m;
    if (there.cost <= here.cost * kRounding) {
      minimum.position_m = next_m;
      here = there;
      damping = damping > kFirstDamping ? 0.1 * damping : 0.0;
    } else {
      damping = std::max(kFirstDamping, 10.0 * damping);
    }
    if (is_small || damping > kLargestDamping) {
      minimum.status = SolveStatus::converged;
      break;
    }
  }
  minimum.cost = here.cost;
  if (!std::isfinite(minimum.cost)) minimum.status = SolveStatus::diverged;
  return minimum;
}

RangeProblem ranges_of(const Rays& rays) {
  RangeProblem problem;
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  problem.count = rays.count;
  for (int i = 0; i < rays.count; ++i) {
    problem.sensor_m[i] = rays.sensor_m[i];
    problem.range_m[i] = rays.range_m[i];
    sum_m += rays.point_m[i];
  }
  problem.hint_m = sum_m / rays.count;
  return problem;
}

// Whether a sensor is so far off that the loss bends back: then another minimum may be lower.
bool any_disagrees(const Rays& rays, const RangeBearingOptions& options, const Eigen::Vector3d& x_m) {
  for (int i = 0; i < rays.count; ++i)
    if (!(residual_at(rays, i, x_m).square <= options.loss_scale * options.loss_scale)) return true;
  return false;
}

// The lowest of the minima that the descents find: from the mean and, where ranges count more than bearings,
// from both sides of the ranges' own minimum.
Minimum global_minimum(const Rays& rays, const RangeBearingOptions& options) {
  if (options.start_m) return descend(rays, options, *options.start_m);
  constexpr double kCoarse_m = 1e-4;  // tells whose minimum is the lowest, which then is found exactly
  RangeBearingOptions coarse = options;
  coarse.step_tolerance_m = std::max(kCoarse_m, options.step_tolerance_m);
  const RangeProblem problem = ranges_of(rays);
  Minimum best;
  int iterations = 0;
  const auto try_from = [&](const Eigen::Vector3d& start_m) {
    const Minimum found = descend(rays, coarse, start_m);
    iterations += found.iterations;
    if (found.cost < best.cost) best = found;
  };
  try_from(*problem.hint_m);
  if (options.loss != Loss::squares && any_disagrees(rays, options, best.position_m))  // each may be right
    for (int i = 0; i < rays.count; ++i) try_from(rays.point_m[i]);
  if (rays.count >= 3 && options.sigma.range_m < options.sigma.bearing_m) {
    const SensorPlane plane = plane_of(problem);
    if (!plane.collinear) {
      const Eigen::Vector3d start_m = squared_range_position_m(problem, plane);
      try_from(start_m);
      try_from(plane.mirrored(start_m));
    }
  }
  if (std::isfinite(best.cost)) best = descend(rays, options, best.position_m);
  best.iterations += iterations;
  return best;
}

// Estimate at the minimum. Its covariance weighs each view as the loss does there, so that a dismissed view
// adds no information.
PointEstimate estimate_of(const Rays& rays, const RangeBearingOptions& options, const Minimum& minimum) {
  const Eigen::Vector3d& x_m = minimum.position_m;
  PointEstimate estimate = estimate_at(ranges_of(rays), x_m, minimum.status, minimum.iterations);
  Costs costs(options);
  Symmetric3 information;
  double range_cost = 0.0;
  for (int i = 0; i < rays.count; ++i) {
    const Eigen::Vector3d v = x_m - rays.sensor_m[i];
    const double distance_m = v.norm();
    const Eigen::Vector3d e = v / std::max(distance_m, kOnSensor_m);
    const double weight = costs.add(residual_at(rays, i, x_m).square);
    information.add_outer(weight * rays.range_weight[i], e);
    add_projection(information, weight * rays.bearing_weight[i], e);
    range_cost += std::pow(distance_m - rays.range_m[i], 2);
  }
  estimate.cost_m2 = range_cost;
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
  if (!is_finite(rays)) return failed_estimate(SolveStatus::non_finite_input);
  const Minimum minimum = global_minimum(rays, options);
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
