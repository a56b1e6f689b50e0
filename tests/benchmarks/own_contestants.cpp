// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>
#include <thread>

#include <hwy/targets.h>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/benchmarks/contestants.h"

namespace trilat {
namespace {

struct Kind {
  const char* name;
  Damping damping;
  Curvature curvature;
};
constexpr Kind kUndamped{"Gauss-Newton", Damping::none, Curvature::gauss_newton};
constexpr Kind kDamped{"lm Gauss-Newton", Damping::lm, Curvature::gauss_newton};
constexpr Kind kNewton{"lm newton", Damping::lm, Curvature::newton};

const std::vector<std::string> kStopRules{"step", "objective"};

NonlinearOptions options_of(const Kind& kind, Tolerance tolerance) {
  NonlinearOptions options;
  options.damping = kind.damping;
  options.curvature = kind.curvature;
  options.stop = tolerance.rule == 0 ? StopRule::step : StopRule::objective;
  options.step_tolerance_m = tolerance.value;
  options.threshold_m2 = tolerance.value;
  options.max_iterations = kMostIterations;
  return options;
}

// One problem a call: both lanes of the pair hold it, and one of them is thrown away.
template <const Kind& kind>
struct OneDescent {
  NonlinearOptions options;
  DescentPair pair;

  explicit OneDescent(Tolerance tolerance) : options(options_of(kind, tolerance)) {}
  double operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) {
    pair.sensors = problem.count;
    for (std::size_t lane = 0; lane < kPairLanes; ++lane) {
      for (int i = 0; i < problem.count; ++i) {
        for (int axis = 0; axis < 3; ++axis) pair.sensor_m[3 * i + axis][lane] = problem.sensor_m[i][axis];
        pair.range_m[i][lane] = problem.range_m[i];
        pair.weight[i][lane] = problem.weight[i];
      }
      for (int axis = 0; axis < 3; ++axis) pair.position_m[axis][lane] = x_m[axis];
    }
    descend(pair, options);
    x_m = {pair.position_m[0][0], pair.position_m[1][0], pair.position_m[2][0]};
    return pair.iterations[0];
  }
};

// The whole method from the given start: both sides, choice, GDOP and covariance.
struct WholeSolve {
  NonlinearOptions options;

  explicit WholeSolve(Tolerance tolerance) : options(options_of(kDamped, tolerance)) {
    options.start = Start::point;
  }
  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) {
    options.start_point_m = x_m;
    const PointEstimate estimate = solve_nonlinear(problem, options);
    x_m = estimate.position_m;
    return estimate.iterations;
  }
};

Contestant whole_span() {
  return {"trilat solve_nonlinear(span), own start, both sides, GDOP", kStopRules,
          [estimates = std::vector<PointEstimate>()](const ComparisonProblems& problems, Tolerance tolerance,
                                                     Positions& positions_m) mutable {
            estimates.resize(problems.problem.size());
            solve_nonlinear(problems.problem, options_of(kDamped, tolerance), estimates);
            double iterations = 0.0;
            for (std::size_t i = 0; i < estimates.size(); ++i) {
              positions_m[i] = estimates[i].position_m;
              iterations += estimates[i].iterations;
            }
            return iterations;
          }};
}

// Problems [first, first + count) laid out for vectors, solved again and again from their starts.
struct Block {
  DescentBatch batch;
  LaneRows start_m;
  std::size_t first;

  Block(const ComparisonProblems& problems, std::size_t begin, std::size_t count)
      : batch(problems.problem[0].count, count, true), start_m(3, count), first(begin) {
    for (std::size_t row = 0; row < 3 * static_cast<std::size_t>(batch.sensors); ++row)
      batch.sensor_m.row(row)[0] = problems.problem[0].sensor_m[row / 3][static_cast<Eigen::Index>(row % 3)];
    for (std::size_t lane = 0; lane < count; ++lane) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(batch.sensors); ++i)
        batch.range_m.row(i)[lane] = problems.problem[first + lane].range_m[i];
      for (std::size_t axis = 0; axis < 3; ++axis)
        start_m.row(axis)[lane] = problems.start_m[first + lane][static_cast<Eigen::Index>(axis)];
    }
  }

  void solve(const DescentOptions& options, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      std::copy_n(start_m.row(0), 3 * start_m.stride(), batch.position_m.row(0));
      descend(batch, options);
    }
  }

  double collect(Positions& positions_m) const {
    double iterations = 0.0;
    for (std::size_t lane = 0; lane < batch.count; ++lane) {
      positions_m[first + lane] = {batch.position_m.row(0)[lane], batch.position_m.row(1)[lane],
                                   batch.position_m.row(2)[lane]};
      iterations += batch.iterations.row(0)[lane];
    }
    return iterations;
  }
};

Contestant batched(const ComparisonProblems& problems, const Kind& kind, std::int64_t target, int threads,
                   int rounds) {
  auto blocks = std::make_shared<std::vector<Block>>();
  const std::size_t share = problems.problem.size() / static_cast<std::size_t>(threads);
  for (std::size_t t = 0; t < static_cast<std::size_t>(threads); ++t)
    blocks->emplace_back(problems, t * share, share);
  std::string name = std::string("trilat batched ") + kind.name + ", " + hwy::TargetName(target);
  if (threads > 1) name += ", " + std::to_string(threads) + " threads";
  const auto solve_all = [=](const ComparisonProblems&, Tolerance tolerance, Positions& positions_m) {
    const NonlinearOptions options = options_of(kind, tolerance);
    std::vector<std::jthread> workers;
    for (std::size_t t = 1; t < blocks->size(); ++t)
      workers.emplace_back([&, t] { (*blocks)[t].solve(options, rounds); });
    (*blocks)[0].solve(options, rounds);
    workers.clear();
    double iterations = 0.0;
    for (const Block& block : *blocks) iterations += block.collect(positions_m);
    return iterations;
  };
  return {name, kStopRules, solve_all, target, rounds, threads};
}

}  // namespace

std::vector<Contestant> own_contestants(const ComparisonProblems& problems) {
  constexpr int kRounds = 20;
  std::vector<Contestant> all{
      one_at_a_time<OneDescent<kUndamped>>("trilat one at a time, Gauss-Newton", kStopRules),
      one_at_a_time<OneDescent<kDamped>>("trilat one at a time, lm Gauss-Newton", kStopRules),
      one_at_a_time<WholeSolve>("trilat solve_nonlinear, given start, both sides, GDOP", kStopRules),
      whole_span()};
  std::int64_t best = 0;
  for (const std::int64_t target : {HWY_SSE4, HWY_AVX2, HWY_AVX3}) {
    if ((hwy::SupportedTargets() & target) == 0) continue;
    best = target;
    for (const Kind& kind : {kUndamped, kDamped, kNewton})
      all.push_back(batched(problems, kind, target, 1, kRounds));
  }
  if (best == 0) return all;
  // Long enough that starting a thread does not count.
  all.push_back(batched(problems, kUndamped, best, 2, 8 * kRounds));
  return all;
}

}  // namespace trilat
