// SPDX-License-Identifier: MIT
// Takes of one joint as sensors see it, with errors along and across the rays that may be correlated in time.
#pragma once

#include <cstdint>
#include <vector>

#include "evaluators/fusion/ray_variances.h"
#include "tests/evaluators/seen_joints.h"

namespace trilat {

inline constexpr double kTotal_m = 0.087;

struct RayDataSpec {
  double ratio = 1.0;
  std::size_t instants = 3000;
  double total_m = kTotal_m;
  double correlation = 0.0;      // of an error with that an instant before
  double shared_m = 0.0;         // standard deviation in all of an error that all sensors have in common
  std::size_t clusters = 20;     // of equal length
  double inferred_share = 0.0;   // of views …
  double inferred_factor = 1.0;  // … whose errors are so much larger
  std::vector<RigidTransform> rig = circle_rig({0.6, 2.2, 0.9, 1.9});
};

struct RayData {
  std::vector<RigidTransform> rig;
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> cluster;
  std::vector<Eigen::Vector3d> truth_m;
  RaySigmaEstimate estimate() const { return estimate_ray_sigma(observations, rig, cluster); }
};

inline RayData ray_data(const RayDataSpec& spec, std::uint64_t seed) {
  RayData data;
  data.rig = spec.rig;
  const RaySigma sigma = sigmas_of(spec.ratio, spec.total_m);
  const double fresh = std::sqrt(1.0 - spec.correlation * spec.correlation);
  std::vector<Eigen::Vector3d> error(spec.rig.size());
  for (std::size_t i = 0; i < spec.instants; ++i) {
    const RandomStream random{seed, Purpose::test, i};
    const Eigen::Vector3d joint_m = some_joint_m(random);
    const Eigen::Vector3d shared_m = spec.shared_m / std::sqrt(3.0) * normal_vector_of(random, 8);
    for (std::size_t s = 0; s < spec.rig.size(); ++s) {
      const Eigen::Vector3d next = normal_vector_of(random, static_cast<std::uint32_t>(16 + 3 * s));
      error[s] = i == 0 ? next : Eigen::Vector3d(spec.correlation * error[s] + fresh * next);
      const bool inferred = random.uniform(static_cast<std::uint32_t>(64 + s)) < spec.inferred_share;
      data.observations.push_back(seen_from(spec.rig[s], joint_m + shared_m, sigma,
                                            (inferred ? spec.inferred_factor : 1.0) * error[s]));
      if (inferred) data.observations.back().state = TrackingState::inferred;
    }
    data.cluster.push_back(static_cast<std::uint32_t>(i * spec.clusters / spec.instants));
    data.truth_m.push_back(joint_m);
  }
  return data;
}

struct Coverage {
  std::size_t estimated = 0;
  double ratio = 0.0, range = 0.0, bearing = 0.0;  // shares of the intervals that hold the true value
};

inline Coverage coverage_of_intervals(const RayDataSpec& spec, std::size_t data_sets) {
  Coverage coverage;
  const RaySigma truth = sigmas_of(spec.ratio, spec.total_m);
  const auto holds = [](const RayInterval& interval, double value) {
    return interval.low <= value && value <= interval.high ? 1.0 : 0.0;
  };
  for (std::size_t k = 0; k < data_sets; ++k) {
    const RaySigmaEstimate estimate = ray_data(spec, 1000 + k).estimate();
    if (!estimate.problem.empty()) continue;
    ++coverage.estimated;
    coverage.ratio += holds(estimate.ratio, spec.ratio);
    coverage.range += holds(estimate.range_m, truth.range_m);
    coverage.bearing += holds(estimate.bearing_m, truth.bearing_m);
  }
  const auto n = static_cast<double>(coverage.estimated);
  return {coverage.estimated, coverage.ratio / n, coverage.range / n, coverage.bearing / n};
}

}  // namespace trilat
