// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "evaluators/solvers/range_problem.h"

namespace trilat {

using Positions = std::vector<Eigen::Vector3d>;

// What every contestant solves: problem i from start i.
struct ComparisonProblems {
  std::vector<RangeProblem> problem;  // all with the same four sensors, weights 1, no hints
  Positions start_m;                  // solve_linear()
  Positions optimum_m;                // Newton's method in long double
};

// One stop rule of a contestant and its tolerance; the others are switched off.
struct Tolerance {
  int rule = 0;
  double value = 0.0;
};

inline constexpr int kMostIterations = 50;

struct Contestant {
  std::string name;
  std::vector<std::string> stop_rules;
  // Fills in the positions and returns the iterations of all problems together, NaN when not told.
  std::function<double(const ComparisonProblems&, Tolerance, Positions&)> solve_all;
  std::int64_t vector_target = 0;  // one instruction set of Highway; 0: the best there is
  int rounds = 1;                  // how often solve_all solves everything
  int threads = 1;
};

// `Solver` is made from a Tolerance and called with a problem and a position, the start and then the end;
// it returns its iterations.
template <class Solver>
Contestant one_at_a_time(std::string name, std::vector<std::string> stop_rules) {
  return {std::move(name), std::move(stop_rules),
          [](const ComparisonProblems& problems, Tolerance tolerance, Positions& positions_m) {
            Solver solver(tolerance);
            double iterations = 0.0;
            for (std::size_t i = 0; i < positions_m.size(); ++i) {
              positions_m[i] = problems.start_m[i];
              iterations += solver(problems.problem[i], positions_m[i]);
            }
            return iterations;
          }};
}

std::vector<Contestant> own_contestants(const ComparisonProblems& problems);
std::vector<Contestant> ceres_contestants();  // ceres::Solve first, then the same problem reused, TinySolver

}  // namespace trilat
