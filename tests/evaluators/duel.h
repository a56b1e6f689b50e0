// SPDX-License-Identifier: MIT
// Our minimum against the better of two by Ceres, from our start and from its mirror image.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <vector>

#include "evaluators/ceres/ceres_trilateration.h"
#include "tests/evaluators/hard_problems.h"

namespace trilat {

inline constexpr double kDuelRelative = 1e-9;
inline constexpr double kDuelAbsolute_m2 = 1e-15;

struct Duel {
  PointEstimate own;
  Eigen::Vector3d start_m = Eigen::Vector3d::Constant(kNaN);
  std::array<Descent, 2> ceres;  // not_solved when ours refused the problem

  bool fought() const { return ceres[0].status != SolveStatus::not_solved; }
  // How much of the allowance our cost uses up; more than 1 is a loss, and NaN counts as one.
  double allowance_used() const {
    if (!fought()) return 0.0;
    const double theirs_m2 = std::fmin(ceres[0].cost, ceres[1].cost);
    const double used = (own.cost_m2 - theirs_m2) / (theirs_m2 * kDuelRelative + kDuelAbsolute_m2);
    return std::isnan(used) ? std::numeric_limits<double>::infinity() : used;
  }
  bool lost() const { return allowance_used() > 1.0; }
  // A status that says what the numbers are.
  bool honest() const {
    if (!fought()) return own.position_m.array().isNaN().all() && !is_usable(own.status);
    if (!own.position_m.allFinite() || !std::isfinite(own.cost_m2)) return false;
    return !is_usable(own.status) || (std::isfinite(own.gdop) && own.covariance.allFinite());
  }
};

// Both by the full Hessian and by Gauss-Newton, against the same two descents of Ceres.
inline std::array<Duel, 2> duels(const RangeProblem& problem) {
  std::array<Duel, 2> result;
  NonlinearOptions options;
  options.range_sigma_m = 0.0;  // the lower minimum, whichever side is meant
  result[0].own = solve_nonlinear(problem, options);
  options.curvature = Curvature::newton;
  result[1].own = solve_nonlinear(problem, options);
  const SensorPlane plane = plane_of(problem);
  if (validate(problem) != SolveStatus::not_solved || plane.collinear) return result;
  const Eigen::Vector3d wanted_m =
      requested_start_m(problem, plane, options.start, options.start_point_m, options.linear);
  const Eigen::Vector3d start_m = plausible_start(problem, plane, wanted_m);
  for (Duel& duel : result) duel.start_m = start_m;
  result[0].ceres = {descend_by_ceres(problem, {}, start_m),
                     descend_by_ceres(problem, {}, plane.mirrored(start_m))};
  result[1].ceres = result[0].ceres;
  return result;
}

struct DuelTally {
  std::array<std::uint64_t, kSolveStatusCount> statuses{};
  std::vector<std::uint64_t> lost, dishonest;  // indices of problems
  double most_allowance = 0.0;

  void add(std::uint64_t index, const Duel& duel) {
    ++statuses[static_cast<std::size_t>(duel.own.status)];
    if (duel.lost()) lost.push_back(index);
    if (!duel.honest()) dishonest.push_back(index);
    most_allowance = std::max(most_allowance, duel.allowance_used());
  }
  void add(const DuelTally& other) {
    for (std::size_t i = 0; i < statuses.size(); ++i) statuses[i] += other.statuses[i];
    lost.insert(lost.end(), other.lost.begin(), other.lost.end());
    dishonest.insert(dishonest.end(), other.dishonest.begin(), other.dishonest.end());
    most_allowance = std::max(most_allowance, other.most_allowance);
  }
  void print(const char* title) const {
    std::printf("%s: %zu lost, %zu dishonest, at most %.3g of the allowance;", title, lost.size(),
                dishonest.size(), most_allowance);
    for (std::size_t i = 0; i < statuses.size(); ++i)
      if (statuses[i] > 0)
        std::printf(" %s %llu", name_of(static_cast<SolveStatus>(i)).data(),
                    static_cast<unsigned long long>(statuses[i]));
    std::printf("\n");
  }
};

using DuelTallies = std::array<DuelTally, 2>;
inline constexpr std::array<const char*, 2> kDuelNames{"Gauss-Newton", "newton"};

// Problems [first, last) of a seed.
inline DuelTallies tally_duels(std::uint64_t seed, std::uint64_t first, std::uint64_t last) {
  DuelTallies tallies;
  for (std::uint64_t i = first; i < last; ++i) {
    const std::array<Duel, 2> both = duels(hard_problem(seed, i));
    for (std::size_t kind = 0; kind < both.size(); ++kind) tallies[kind].add(i, both[kind]);
  }
  return tallies;
}

}  // namespace trilat
