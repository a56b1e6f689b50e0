// SPDX-License-Identifier: MIT
// Whether solve_range_bearing() finds the lowest minimum, against descents from many random starts.
#pragma once

#include <algorithm>

#include "tests/evaluators/seen_joints.h"

namespace trilat {

struct GlobalCheck {
  std::size_t problems = 0, missed = 0;
  double worst_m = 0.0;  // distance from the better minimum, of those that were missed
};

// Gauss-Newton with halved steps: nothing of the solver's own.
inline Eigen::Vector3d plain_descent(const std::vector<JointObservation>& seen,
                                     const std::vector<RigidTransform>& rig,
                                     const RangeBearingOptions& options, Eigen::Vector3d x_m) {
  const auto cost = [&](const Eigen::Vector3d& at_m) { return range_bearing_cost(seen, rig, options, at_m); };
  double here = cost(x_m);
  for (int k = 0; k < 200; ++k) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < rig.size(); ++i) {
      const Eigen::Vector3d v = x_m - rig[i].translation_m, e = v.normalized();
      const Eigen::Vector3d u = (seen[i].point_in_world_m - rig[i].translation_m).normalized();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - u * u.transpose();
      double wr = std::pow(options.sigma.range_m, -2), wb = std::pow(options.sigma.bearing_m, -2);
      const double square = wr * std::pow(v.norm() - seen[i].range_m, 2) + wb * (across * v).squaredNorm();
      const double scaled = square / (options.loss_scale * options.loss_scale);
      const double weight = options.loss == Loss::cauchy ? 1.0 / (1.0 + scaled) : 1.0;
      wr *= weight;
      wb *= weight;
      normal += wr * e * e.transpose() + wb * across;
      gradient += wr * (v.norm() - seen[i].range_m) * e + wb * across * v;
    }
    Eigen::Vector3d step_m = -(normal.inverse() * gradient);
    double there = cost(x_m + step_m);
    while (!(there <= here) && step_m.norm() > 1e-12) {
      step_m *= 0.5;
      there = cost(x_m + step_m);
    }
    if (!(there <= here) || step_m.norm() < 1e-10) break;
    x_m += step_m;
    here = there;
  }
  return x_m;
}

// On ten rigs of 3 to 8 sensors: circles and arcs, heights apart and nearly equal. An estimate misses when a
// minimum more than 1 mm away is lower by more than rounding.
inline GlobalCheck check_global_minima(std::size_t problems_per_rig, std::size_t starts,
                                       Loss loss = Loss::squares) {
  const std::vector<std::vector<RigidTransform>> rigs{circle_rig({0.6, 2.2, 0.9, 1.9}),
                                                      circle_rig({1.4, 1.4, 1.4, 1.4}),
                                                      circle_rig({1.38, 1.42, 1.36, 1.44}),
                                                      circle_rig({1.3, 0.7, 1.1, 0.9}),
                                                      circle_rig({0.6, 2.2, 0.9, 1.9}, 2, 90),
                                                      circle_rig({1.0, 1.0, 1.0}, 2, 180),
                                                      circle_rig({0.5, 2.0, 1.0}),
                                                      circle_rig({1.0, 1.2, 1.0, 1.2, 1.0, 1.2}, 3),
                                                      circle_rig({1, 1, 1, 1, 1, 1, 1, 1}, 3),
                                                      circle_rig({0.6, 1.2, 1.8, 0.9}, 1.2)};
  GlobalCheck check;
  for (std::size_t r = 0; r < rigs.size(); ++r)
    for (std::size_t k = 0; k < problems_per_rig; ++k) {
      const RandomStream random{18, Purpose::test, r * 1'000'000 + k};
      const double ratio = 0.05 * std::pow(400.0, random.uniform(3)), total_m = 0.3 * random.uniform(4);
      const RaySigma sigma = sigmas_of(ratio, total_m);
      const Eigen::Vector3d joint_m = some_joint_m(random);
      auto seen = seen_from(rigs[r], joint_m, sigma, random);
      if (loss != Loss::squares) {  // one sensor sees something else, behind the joint
        Eigen::Vector3d error = 15.0 * normal_vector_of(random, 90);
        error[0] = std::abs(error[0]);
        seen[0] = seen_from(rigs[r][0], joint_m, sigma, error);
      }
      const RangeBearingOptions options{.sigma = sigma, .loss = loss};
      const Eigen::Vector3d found_m = solve_range_bearing(seen, rigs[r], options).position_m;
      const double found = range_bearing_cost(seen, rigs[r], options, found_m);
      ++check.problems;
      double worst_m = 0.0;
      for (std::size_t s = 0; s < starts; ++s) {
        const auto n = static_cast<std::uint32_t>(100 + 3 * s);
        const Eigen::Vector3d start_m(6.0 * random.uniform(n) - 3.0, 6.0 * random.uniform(n + 1) - 2.0,
                                      6.0 * random.uniform(n + 2) - 3.0);
        const Eigen::Vector3d x_m = plain_descent(seen, rigs[r], options, start_m);
        if (range_bearing_cost(seen, rigs[r], options, x_m) < found * (1.0 - 1e-9) - 1e-9)
          worst_m = std::max(worst_m, (x_m - found_m).norm());
      }
      if (worst_m > 1e-3) ++check.missed;
      check.worst_m = std::max(check.worst_m, worst_m);
    }
  return check;
}

}  // namespace trilat
