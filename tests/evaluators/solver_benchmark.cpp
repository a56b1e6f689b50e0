// SPDX-License-Identifier: MIT
// Nanoseconds a solve of every method on the same problems, in one process: the ratios mean more
// than the numbers.
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "evaluators/ceres/ceres_trilateration.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/evaluators/range_problems.h"

namespace {

using namespace trilat;

constexpr int kProblems = 1000;

struct Timing {
  double ns_per_solve = 0.0;
  double iterations = 0.0;
  double usable = 0.0;
};

std::vector<RangeProblem> problems(const std::vector<Eigen::Vector3d>& sensors_m) {
  std::vector<RangeProblem> result;
  const RandomStream joints{1, Purpose::test, 0};
  for (std::uint32_t i = 0; i < kProblems; ++i) {
    const Eigen::Vector3d joint_m = random_joint_m(joints, i);
    result.push_back(problem_of(sensors_m, joint_m));
    result.back().hint_m = joint_m + Eigen::Vector3d(0.02, -0.01, 0.03);
    add_noise(result.back(), RandomStream{2, Purpose::test, i}, 0.025);
  }
  return result;
}

Timing time_of(const std::vector<RangeProblem>& all, int repeats,
               const std::function<PointEstimate(const RangeProblem&)>& solve) {
  Timing best{1e300, 0.0, 0.0};
  for (int round = 0; round < 5; ++round) {
    double iterations = 0.0;
    double usable = 0.0;
    const auto start = std::chrono::steady_clock::now();
    for (int r = 0; r < repeats; ++r) {
      for (const RangeProblem& problem : all) {
        const PointEstimate estimate = solve(problem);
        iterations += estimate.iterations;
        usable += is_usable(estimate.status) ? 1.0 : 0.0;
      }
    }
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
    const double solves = static_cast<double>(repeats) * static_cast<double>(all.size());
    if (spent.count() / solves < best.ns_per_solve)
      best = {spent.count() / solves, iterations / solves, usable / solves};
  }
  return best;
}

NonlinearOptions undamped(Gradient gradient, double threshold_cm2) {
  NonlinearOptions options;
  options.gradient = gradient;
  options.damping = Damping::none;
  options.stop = StopRule::objective;
  options.threshold_m2 = threshold_cm2 * 1e-4;
  return options;
}

void report(const char* title, const std::vector<RangeProblem>& all) {
  struct Row {
    std::string name;
    int repeats;
    std::function<PointEstimate(const RangeProblem&)> solve;
  };
  const auto nonlinear = [](const NonlinearOptions& options) {
    return [options](const RangeProblem& p) { return solve_nonlinear(p, options); };
  };
  NonlinearOptions to_the_end = undamped(Gradient::corrected, 1e-4);
  to_the_end.stop = StopRule::step;
  const std::vector<Row> rows{
      {"linear", 100, [](const RangeProblem& p) { return solve_linear(p, {}); }},
      {"geometric", 100, [](const RangeProblem& p) { return solve_geometric(p, {}); }},
      {"nonlinear lm, 1e-10 m", 100, nonlinear({})},
      {"nonlinear none, 1e-10 m", 100, nonlinear(to_the_end)},
      {"nonlinear none, C = 1e-4 cm2", 100, nonlinear(undamped(Gradient::corrected, 1e-4))},
      {"nonlinear printed, C = 1e-4 cm2", 5, nonlinear(undamped(Gradient::printed, 1e-4))},
      {"ceres", 1, [](const RangeProblem& p) { return solve_ceres(p, {}); }},
  };
  std::printf("%s\n%-34s %12s %10s %8s %9s\n", title, "method", "ns/solve", "steps", "usable", "x lm");
  double lm_ns = 0.0;
  std::vector<Timing> timings;
  for (const Row& row : rows) timings.push_back(time_of(all, row.repeats, row.solve));
  lm_ns = timings[2].ns_per_solve;
  for (std::size_t i = 0; i < rows.size(); ++i)
    std::printf("%-34s %12.0f %10.2f %8.3f %9.2f\n", rows[i].name.c_str(), timings[i].ns_per_solve,
                timings[i].iterations, timings[i].usable, timings[i].ns_per_solve / lm_ns);
}

}  // namespace

int main() {
  report("four sensors at 0.3 and 2.3 m", problems(well_posed_sensors_m()));
  report("four sensors at 0.9, 0.9, 0.9 and 1.4 m", problems(ring_m(0.9, 0.9, 0.9, 1.4)));
  return 0;
}
