// SPDX-License-Identifier: MIT
// What a position costs with our solvers and with those one would take instead: the same problems, the same
// starts and the same accuracy in one process, repetitions in turn. Every contestant gets the stop rule and
// the loosest tolerance with which it is fastest and reaches the accuracy for every problem. Solvers that
// only take steps which lower the cost end about root(rounding of F / curvature) from the minimum, a few
// nanometres here: hence a table for 1 nm and one for 10 nm. Batched, ranges and starts lie in rows already
// and the answers stay in rows; copying the starts is counted. A last table has the undamped settings of
// sweeps. Nothing is compiled for a newer processor than
// x86-64 but our kernel, which chooses at run time.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <functional>
#include <memory>

#include <Eigen/LU>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>
#include <ceres/tiny_solver.h>
#include <fmt/format.h>
#include <hwy/targets.h>

#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "evaluators/solvers/range_lanes.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using Positions = std::vector<Vector3d>;

constexpr std::size_t kProblems = 512;
constexpr double kRangeNoise_m = 0.025;
constexpr int kTolerances = 15;  // 1e-2 down to 1e-16, by tens
constexpr int kTrialRuns = 3, kRepetitions = 200, kMaxIterations = 50;

// What every contestant solves: problem i from start i; all with the same four sensors, weights 1, no hints.
struct Problems {
  std::vector<RangeProblem> problem;
  Positions start_m, optimum_m;
};

// Newton's method on F in long double, from the minimum that the default finds.
Vector3d optimum_of(const RangeProblem& problem) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  using Matrix = Eigen::Matrix<long double, 3, 3>;
  Vector x = solve_nonlinear(problem, {}).position_m.cast<long double>();
  for (int step = 0; step < 5; ++step) {
    Vector gradient = Vector::Zero();
    Matrix hessian = Matrix::Zero();
    for (int i = 0; i < problem.count; ++i) {
      const Vector from_sensor = x - problem.sensor_m[i].cast<long double>();
      const long double distance = from_sensor.norm();
      const Vector u = from_sensor / distance;
      const long double bend = 1.0L - problem.range_m[i] / distance;
      gradient += (distance - problem.range_m[i]) * u;
      hessian += u * u.transpose() + bend * (Matrix::Identity() - u * u.transpose());
    }
    x -= hessian.inverse() * gradient;
  }
  return x.cast<double>();
}

const Problems& problems() {
  static const Problems all = [] {
    Problems made;
    const RandomStream joints{1, Purpose::test, 0};
    for (std::uint32_t i = 0; i < kProblems; ++i) {
      RangeProblem problem = problem_of(well_posed_sensors_m(), random_joint_m(joints, i));
      add_noise(problem, RandomStream{2, Purpose::test, i}, kRangeNoise_m);
      made.start_m.push_back(solve_linear(problem, {}).position_m);
      made.optimum_m.push_back(optimum_of(problem));
      made.problem.push_back(problem);
    }
    return made;
  }();
  return all;
}

// One stop rule of a contestant and its tolerance; the others are switched off.
struct Tolerance {
  int rule = 0;
  double value = 0.0;
};

struct Contestant {
  std::string name;
  std::vector<const char*> stop_rules;
  std::function<void(Tolerance, Positions&)> solve_all;
  std::int64_t vector_target = 0;  // one instruction set of Highway; 0: the best there is
  int rounds = 1;                  // how often solve_all solves everything
};

const std::vector<const char*> kCeresRules{"function", "parameter", "gradient"},
    kOwnRules{"step", "objective"};

// `Solver` is made from a Tolerance and called with a problem and a position, the start and then the end.
template <class Solver>
Contestant one_at_a_time(const char* name, const std::vector<const char*>& stop_rules) {
  return {name, stop_rules, [](Tolerance tolerance, Positions& positions_m) {
            Solver solver(tolerance);
            positions_m = problems().start_m;
            for (std::size_t i = 0; i < kProblems; ++i) solver(problems().problem[i], positions_m[i]);
          }};
}

struct RangeResidual final : ceres::SizedCostFunction<1, 3> {
  Vector3d sensor_m = Vector3d::Zero();
  double range_m = 0.0;

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Vector3d from_sensor = Eigen::Map<const Vector3d>(parameters[0]) - sensor_m;
    const double distance = from_sensor.norm();
    residuals[0] = distance - range_m;
    if (jacobians && jacobians[0]) Eigen::Map<Vector3d>{jacobians[0]} = from_sensor / distance;
    return true;
  }
};

// With `reuse` the problem is built once, and a solve changes what its cost functions hold.
template <bool reuse>
struct CeresSolve {
  ceres::Solver::Options options;
  Vector3d x;
  std::array<RangeResidual, 4> residuals;
  std::unique_ptr<ceres::Problem> least_squares = built();

  explicit CeresSolve(Tolerance tolerance) {
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = kMaxIterations;
    options.function_tolerance = tolerance.rule == 0 ? tolerance.value : 0.0;
    options.parameter_tolerance = tolerance.rule == 1 ? tolerance.value : 0.0;
    options.gradient_tolerance = tolerance.rule == 2 ? tolerance.value : 0.0;
  }
  std::unique_ptr<ceres::Problem> built() {
    ceres::Problem::Options borrowing;
    borrowing.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    auto problem = std::make_unique<ceres::Problem>(borrowing);
    for (RangeResidual& residual : residuals) problem->AddResidualBlock(&residual, nullptr, x.data());
    return problem;
  }
  void operator()(const RangeProblem& problem, Vector3d& x_m) {
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      residuals[i].sensor_m = problem.sensor_m[i];
      residuals[i].range_m = problem.range_m[i];
    }
    if (!reuse) least_squares = built();
    x = x_m;
    ceres::Solver::Summary summary;
    ceres::Solve(options, least_squares.get(), &summary);
    x_m = x;
  }
};

struct FourRanges {
  using Scalar = double;
  enum { NUM_RESIDUALS = 4, NUM_PARAMETERS = 3 };
  const RangeProblem* problem;

  bool operator()(const double* parameters, double* residuals, double* jacobian) const {
    const Eigen::Map<const Vector3d> x(parameters);
    for (int i = 0; i < NUM_RESIDUALS; ++i) {
      const Vector3d from_sensor = x - problem->sensor_m[i];
      const double distance = from_sensor.norm();
      residuals[i] = distance - problem->range_m[i];
      if (jacobian) Eigen::Map<Eigen::Matrix<double, 4, 3>>(jacobian).row(i) = from_sensor / distance;
    }
    return true;
  }
};

struct Tiny {
  ceres::TinySolver<FourRanges> solver;

  explicit Tiny(Tolerance tolerance) {
    solver.options.max_num_iterations = kMaxIterations;
    solver.options.cost_threshold = 0.0;
    solver.options.function_tolerance = tolerance.rule == 0 ? tolerance.value : 0.0;
    solver.options.parameter_tolerance = tolerance.rule == 1 ? tolerance.value : 0.0;
    solver.options.gradient_tolerance = tolerance.rule == 2 ? tolerance.value : 0.0;
  }
  void operator()(const RangeProblem& problem, Vector3d& x_m) { solver.Solve(FourRanges{&problem}, &x_m); }
};

struct Kind {
  const char* name;
  Damping damping;
  Curvature curvature;
};
constexpr Kind kUndamped{"Gauss-Newton", Damping::none, Curvature::gauss_newton};
constexpr Kind kDamped{"lm Gauss-Newton", Damping::lm, Curvature::gauss_newton};
constexpr Kind kNewton{"lm newton", Damping::lm, Curvature::newton};

// Undamped settings as a sweep over C uses them: long descents with the printed gradient, short ones
// without. C in m2; no accuracy is asked.
struct SweptSetting {
  const char* name;
  Gradient gradient;
  StopRule stop;
  double threshold_m2;
};
constexpr SweptSetting kSwept[] = {
    {"printed gradient, |change of F| < 1e-4 cm2", Gradient::printed, StopRule::objective, 1e-8},
    {"printed gradient, |change of F| < 1e-6 cm2", Gradient::printed, StopRule::objective, 1e-10},
    {"as printed, C = 1e-4 cm2", Gradient::printed, StopRule::printed, 1e-8},
    {"corrected gradient, |change of F| < 1e-4 cm2", Gradient::corrected, StopRule::objective, 1e-8},
};

NonlinearOptions options_of(const Kind& kind, Tolerance tolerance) {
  NonlinearOptions options;
  options.damping = kind.damping;
  options.curvature = kind.curvature;
  options.stop = tolerance.rule == 0 ? StopRule::step : StopRule::objective;
  options.step_tolerance_m = options.threshold_m2 = tolerance.value;
  options.max_iterations = kMaxIterations;
  return options;
}

template <const Kind& kind>
struct OneDescent {
  NonlinearOptions options;

  explicit OneDescent(Tolerance tolerance) : options(options_of(kind, tolerance)) {}
  void operator()(const RangeProblem& problem, Vector3d& x_m) {
    x_m = descend(problem, x_m, options).position_m;
  }
};

// The whole method from the given start: both sides, choice, GDOP and covariance.
struct WholeSolve {
  NonlinearOptions options;

  explicit WholeSolve(Tolerance tolerance) : options(options_of(kDamped, tolerance)) {
    options.start = Start::point;
  }
  void operator()(const RangeProblem& problem, Vector3d& x_m) {
    options.start_point_m = x_m;
    x_m = solve_nonlinear(problem, options).position_m;
  }
};

Contestant whole_span() {
  return {"trilat solve_nonlinear(span), own start, both sides, GDOP", kOwnRules,
          [](Tolerance tolerance, Positions& positions_m) {
            static std::vector<PointEstimate> estimates(kProblems);
            solve_nonlinear(problems().problem, options_of(kDamped, tolerance), estimates);
            for (std::size_t i = 0; i < kProblems; ++i) positions_m[i] = estimates[i].position_m;
          }};
}

// The problems in rows, with their starts.
struct Rows {
  RangeLanes lanes{{problems().problem[0].sensor_m.data(), 4}, kProblems};
  AlignedRows start_m{3, kProblems};

  Rows() {
    for (std::size_t lane = 0; lane < kProblems; ++lane) {
      for (std::size_t i = 0; i < 4; ++i) lanes.range_m.row(i)[lane] = problems().problem[lane].range_m[i];
      start_m.set_position(lane, problems().start_m[lane]);
    }
  }
  void solve(const DescentOptions& options) {
    std::copy_n(start_m.row(0), 3 * start_m.stride(), lanes.position_m.row(0));
    descend(lanes, options);
  }
};

Contestant batched(std::int64_t target) {
  constexpr int kRounds = 20;
  const auto solve_all = [rows = std::make_shared<Rows>()](Tolerance tolerance, Positions& positions_m) {
    for (int round = 0; round < kRounds; ++round) rows->solve(options_of(kUndamped, tolerance));
    for (std::size_t lane = 0; lane < kProblems; ++lane)
      positions_m[lane] = rows->lanes.position_m.position(lane);
  };
  return {fmt::format("trilat batched {}, {}", kUndamped.name, hwy::TargetName(target)), kOwnRules, solve_all,
          target, kRounds};
}

std::vector<Contestant> contestants() {
  std::vector<Contestant> all{
      one_at_a_time<CeresSolve<false>>("ceres::Solve", kCeresRules),
      one_at_a_time<CeresSolve<true>>("ceres::Solve, problem reused", kCeresRules),
      one_at_a_time<Tiny>("ceres::TinySolver", kCeresRules),
      one_at_a_time<OneDescent<kUndamped>>("trilat one at a time, Gauss-Newton", kOwnRules),
      one_at_a_time<OneDescent<kDamped>>("trilat one at a time, lm Gauss-Newton", kOwnRules),
      one_at_a_time<OneDescent<kNewton>>("trilat one at a time, lm newton", kOwnRules),
      one_at_a_time<WholeSolve>("trilat solve_nonlinear, given start, both sides, GDOP", kOwnRules),
      whole_span()};
  for (const std::int64_t target : {HWY_SSE4, HWY_AVX2, HWY_AVX3})
    if (hwy::SupportedTargets() & target) all.push_back(batched(target));
  return all;
}

// Processor time of one solve.
double solve_ns(const Contestant& contestant, Tolerance tolerance, Positions& positions_m) {
  hwy::SetSupportedTargetsForTest(contestant.vector_target);
  const std::clock_t start = std::clock();
  contestant.solve_all(tolerance, positions_m);
  const double spent_s = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  hwy::SetSupportedTargetsForTest(0);
  return 1e9 * spent_s / (static_cast<double>(kProblems) * contestant.rounds);
}

struct Entry {
  Contestant contestant;
  Tolerance tolerance{};
  std::size_t not_reached = kProblems + 1;
  double worst_m = 0.0, lowest_ns = 1e300;

  void time(int runs) {
    Positions positions_m(kProblems);
    for (int run = 0; run < runs; ++run)
      lowest_ns = std::min(lowest_ns, solve_ns(contestant, tolerance, positions_m));
  }
};

// The loosest tolerance of a stop rule that reaches the accuracy, or the one that comes nearest.
Entry with_rule(const Contestant& contestant, double wanted_m, int rule) {
  Entry best{contestant};
  Positions positions_m(kProblems);
  for (int k = 0; k < kTolerances && best.not_reached > 0; ++k) {
    Entry entry{contestant, {rule, 1e-2 * std::pow(10.0, -k)}, 0};
    contestant.solve_all(entry.tolerance, positions_m);
    for (std::size_t i = 0; i < kProblems; ++i) {
      const double off_m = (positions_m[i] - problems().optimum_m[i]).norm();
      if (!(off_m <= wanted_m)) ++entry.not_reached;
      if (!(off_m <= entry.worst_m)) entry.worst_m = off_m;
    }
    if (entry.not_reached < best.not_reached) best = entry;
  }
  best.time(kTrialRuns);
  return best;
}

Entry with_best_rule(const Contestant& contestant, double wanted_m) {
  Entry best{contestant};
  for (std::size_t rule = 0; rule < contestant.stop_rules.size(); ++rule) {
    const Entry entry = with_rule(contestant, wanted_m, static_cast<int>(rule));
    if (std::tie(entry.not_reached, entry.lowest_ns) < std::tie(best.not_reached, best.lowest_ns))
      best = entry;
  }
  return best;
}

// Ratios are those of the lowest times: others on the machine slow a solver down, but never speed it up.
void compare(double wanted_m) {
  std::vector<Entry> entries;
  for (const Contestant& contestant : contestants()) entries.push_back(with_best_rule(contestant, wanted_m));
  for (int repetition = 0; repetition < kRepetitions; ++repetition)
    for (Entry& entry : entries) entry.time(1);
  fmt::print(
      "\nTo {:.0e} m:\n\n| solver | stop rule | ns/solve | worst error (m) | not reached | x ceres::Solve | "
      "x TinySolver |\n|---|---|---:|---:|---:|---:|---:|\n",
      wanted_m);
  for (const Entry& e : entries)
    fmt::print("| {} | {} {:.0e} | {:.1f} | {:.1e} | {} | {:.1f} | {:.2f} |\n", e.contestant.name,
               e.contestant.stop_rules[static_cast<std::size_t>(e.tolerance.rule)], e.tolerance.value,
               e.lowest_ns, e.worst_m, e.not_reached, entries[0].lowest_ns / e.lowest_ns,
               entries[2].lowest_ns / e.lowest_ns);
}

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The vector kernel beside the scalar descent, by the settings of sweeps.
void compare_swept() {
  fmt::print("\n| setting | steps | scalar, ns a solve | by vectors | ratio |\n|---|---:|---:|---:|---:|\n");
  Rows rows;
  for (const SweptSetting& setting : kSwept) {
    DescentOptions options;
    options.gradient = setting.gradient;
    options.damping = Damping::none;
    options.stop = setting.stop;
    options.threshold_m2 = setting.threshold_m2;
    options.max_iterations = 20'000;
    double scalar_s = 1e300, vector_s = 1e300, steps = 0.0;
    for (int repetition = 0; repetition < 5; ++repetition) {
      const int rounds = steps > 0.0 && steps < 50.0 * kProblems ? 100 : 1;
      steps = 0.0;
      double start_s = cpu_s();
      for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < kProblems; ++i)
          steps += descend(problems().problem[i], problems().start_m[i], options).iterations;
      steps /= rounds;
      scalar_s = std::min(scalar_s, (cpu_s() - start_s) / rounds);
      start_s = cpu_s();
      for (int round = 0; round < rounds; ++round) rows.solve(options);
      vector_s = std::min(vector_s, (cpu_s() - start_s) / rounds);
    }
    fmt::print("| {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", setting.name, steps / kProblems,
               1e9 * scalar_s / kProblems, 1e9 * vector_s / kProblems, scalar_s / vector_s);
  }
}

}  // namespace
}  // namespace trilat

int main() {
  using namespace trilat;
  fmt::print(
      "{} problems, 4 sensors at 0.3 and 2.3 m, range noise {} cm, start solve_linear(); lowest of {} "
      "repetitions in turn, time of the processor\n",
      kProblems, 100.0 * kRangeNoise_m, kRepetitions);
  for (const double wanted_m : {1e-9, 1e-8}) compare(wanted_m);
  compare_swept();
}
