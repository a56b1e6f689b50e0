// SPDX-License-Identifier: MIT
// Simulated joints seen by rigs whose sensors stand at more or less equal heights, and how often a method
// puts them on the wrong side of the sensors' plane.
#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {

// Heights are drawn anew for every rig, uniformly within half_m of middle_m; half_m of 0 takes `heights_m`.
struct RigFamily {
  std::string name;
  double middle_m = 0.0, half_m = 0.0;
  std::array<double, 4> heights_m{};
};

inline const std::vector<RigFamily>& rig_families() {
  static const std::vector<RigFamily> families{{"uniform, 0.5 to 2.3 m", 1.4, 0.9, {}},
                                               {"tripods, 1.0 +- 0.3 m", 1.0, 0.3, {}},
                                               {"1.4 +- 0.05 m", 1.4, 0.05, {}},
                                               {"1.4 +- 0.01 m", 1.4, 0.01, {}},
                                               {"0.6 1.2 1.8 0.9 m", 0.0, 0.0, {0.6, 1.2, 1.8, 0.9}},
                                               {"0.6 2.2 0.9 1.9 m", 0.0, 0.0, {0.6, 2.2, 0.9, 1.9}}};
  return families;
}

// The sides matter for joints that are farther than this from the sensors' plane.
inline constexpr double kOffPlane_m = 0.15;
inline constexpr double kBeyond_m = 0.05;     // an answer nearer to the plane is on no side
inline constexpr double kSeenSigma_m = 0.04;  // of the joint as each sensor sees it, an axis

struct SeenJoint {
  Eigen::Vector3d joint_m;
  RangeProblem problem;
};

// Joint number `index` of rig number `rig`, more than kOffPlane_m from the plane, seen by four sensors on a
// circle of 2 m. Every sensor sees it displaced on its own; the guess is the mean of what they see.
inline SeenJoint seen_joint(const RigFamily& family, std::uint64_t rig, std::uint32_t index) {
  const RandomStream heights{21, Purpose::test, rig};
  std::vector<Eigen::Vector3d> sensors_m;
  for (std::uint32_t s = 0; s < 4; ++s) {
    const double angle_rad = std::numbers::pi * (0.25 + 0.5 * s);
    const double height_m = family.half_m > 0.0
                                ? family.middle_m + family.half_m * heights.uniform(s, -1.0, 1.0)
                                : family.heights_m[s];
    sensors_m.emplace_back(2.0 * std::sin(angle_rad), height_m, 2.0 * std::cos(angle_rad));
  }
  SeenJoint seen;
  for (std::uint32_t attempt = 0;; ++attempt) {
    seen.joint_m = random_joint_m({22, Purpose::test, rig}, 64 * index + attempt % 64);
    seen.problem = problem_of(sensors_m, seen.joint_m);
    if (std::abs(plane_of(seen.problem).offset_m(seen.joint_m)) > kOffPlane_m || attempt == 63) break;
  }
  const RandomStream errors{23, Purpose::test, rig * 1'000'000 + index};
  seen.problem.guess_m = Eigen::Vector3d::Zero();
  for (std::uint32_t s = 0; s < 4; ++s) {
    Eigen::Vector3d error_m;
    for (std::uint32_t axis = 0; axis < 3; ++axis) error_m[axis] = kSeenSigma_m * errors.normal(3 * s + axis);
    seen.problem.range_m[s] = (seen.joint_m + error_m - sensors_m[s]).norm();
    *seen.problem.guess_m += (seen.joint_m + error_m) / 4.0;
  }
  return seen;
}

struct SideTally {
  double asked = 0.0, answered = 0.0, wrong = 0.0, error_m = 0.0;

  void add(const SeenJoint& seen, const PointEstimate& estimate) {
    ++asked;
    if (!is_usable(estimate.status)) return;
    ++answered;
    error_m += (estimate.position_m - seen.joint_m).norm();
    const SensorPlane plane = plane_of(seen.problem);
    const double offset_m = plane.offset_m(estimate.position_m);
    wrong += std::abs(offset_m) > kBeyond_m && offset_m * plane.offset_m(seen.joint_m) < 0.0;
  }
  double wrong_share() const { return wrong / answered; }
};

struct SideMethod {
  std::string name;
  std::function<PointEstimate(const RangeProblem&)> solve;
};

inline const std::vector<SideMethod>& side_methods() {
  static const std::vector<SideMethod> methods = [] {
    NonlinearOptions newton, lower_cost;
    newton.curvature = Curvature::newton;
    lower_cost.range_sigma_m = 0.0;
    LinearOptions any_side;
    any_side.range_sigma_m = 0.0;
    return std::vector<SideMethod>{
        {"nonlinear", [](const RangeProblem& p) { return solve_nonlinear(p, {}); }},
        {"newton", [=](const RangeProblem& p) { return solve_nonlinear(p, newton); }},
        {"geometric", [](const RangeProblem& p) { return solve_geometric(p, {}); }},
        {"linear", [](const RangeProblem& p) { return solve_linear(p, {}); }},
        {"nonlinear, lower cost", [=](const RangeProblem& p) { return solve_nonlinear(p, lower_cost); }},
        {"linear, any side", [=](const RangeProblem& p) { return solve_linear(p, any_side); }},
        {"mean", [](const RangeProblem& p) {
           PointEstimate mean;
           mean.position_m = *p.guess_m;
           mean.status = SolveStatus::closed_form;
           return mean;
         }}};
  }();
  return methods;
}

inline SideTally tally_sides(const RigFamily& family, const SideMethod& method, std::uint64_t rigs,
                             std::uint32_t joints) {
  SideTally tally;
  for (std::uint64_t rig = 0; rig < rigs; ++rig)
    for (std::uint32_t i = 0; i < joints; ++i) {
      const SeenJoint seen = seen_joint(family, rig, i);
      tally.add(seen, method.solve(seen.problem));
    }
  return tally;
}

}  // namespace trilat
