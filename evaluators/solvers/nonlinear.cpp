// SPDX-License-Identifier: MIT
#include "evaluators/solvers/nonlinear.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "datasets/base/check.h"
#include "evaluators/solvers/both_sides.h"
#include "evaluators/solvers/squared_ranges.h"

namespace trilat {
namespace {

constexpr std::size_t kProblemsAtATime = 512;

// Where the Hessian is not positive definite its step may be long and end in another valley, so J^T W J
// chooses the valley: newton takes over where steps are shorter than this.
constexpr double kApproach_m = 1e-3;

// A problem before its descents: why there are none, or where they start.
struct Prepared {
  SolveStatus refusal = SolveStatus::not_solved;
  int starts = 0;
  std::array<Eigen::Vector3d, 2> start_m;
};

Prepared prepared(const RangeProblem& problem, const SensorPlane& plane, const NonlinearOptions& options) {
  Prepared result;
  if (options.start == Start::point && !options.start_point_m.allFinite())
    result.refusal = SolveStatus::non_finite_input;
  else if (plane.collinear)
    result.refusal = SolveStatus::rank_deficient;
  if (result.refusal != SolveStatus::not_solved) return result;
  const Eigen::Vector3d wanted_m =
      wanted_start_m(problem, plane, options.start, options.start_point_m, options.linear);
  const bool damped = options.damping == Damping::lm;
  result.start_m[0] = damped || !wanted_m.allFinite() ? safe_start(problem, plane, wanted_m) : wanted_m;
  result.start_m[1] = plane.mirrored(result.start_m[0]);
  // In an exact plane the other minimum is the mirror image of the first.
  result.starts = damped && !plane.exact ? 2 : 1;
  return result;
}

double loss_m2(const NonlinearOptions& options, double residual_m) {
  const double square = residual_m * residual_m;
  const double c = options.loss_scale_m;
  if (options.loss == Loss::cauchy) return c * c * std::log1p(square / (c * c));
  if (options.loss == Loss::huber && std::abs(residual_m) > c) return 2.0 * c * std::abs(residual_m) - c * c;
  return square;
}

// What the chosen loss makes of the point where a descent ended.
double total_loss_m2(const RangeProblem& problem, const NonlinearOptions& options,
                     const Eigen::Vector3d& x_m) {
  double sum = 0.0;
  for (int i = 0; i < problem.count; ++i)
    sum += problem.weight[i] * loss_m2(options, (x_m - problem.sensor_m[i]).norm() - problem.range_m[i]);
  return sum;
}

PointEstimate finished(const RangeProblem& problem, const SensorPlane& plane, const NonlinearOptions& options,
                       const Prepared& prepared, Descent first, Descent second) {
  if (options.loss != Loss::squares) {
    first.cost_m2 = total_loss_m2(problem, options, first.position_m);
    second.cost_m2 = total_loss_m2(problem, options, second.position_m);
  }
  if (prepared.starts == 1 && !plane.exact) return estimate_of(problem, first);
  if (plane.exact) second = mirrored(plane, first);
  return estimate_of(problem, choose_minimum(problem, first, second, options.same_residual_m));
}

// Puts problem and start into one lane; sensors beyond its count weigh nothing.
void fill_lane(DescentBatch& batch, std::size_t lane, const RangeProblem& problem,
               const Eigen::Vector3d& start_m) {
  for (int i = 0; i < batch.sensors; ++i) {
    const int from = i < problem.count ? i : 0;
    const auto row = static_cast<std::size_t>(i);
    for (int axis = 0; axis < 3; ++axis)
      batch.sensor_m.row(3 * row + static_cast<std::size_t>(axis))[lane] = problem.sensor_m[from][axis];
    batch.range_m.row(row)[lane] = problem.range_m[from];
    batch.weight.row(row)[lane] = i < problem.count ? problem.weight[from] : 0.0;
  }
  for (int axis = 0; axis < 3; ++axis)
    batch.position_m.row(static_cast<std::size_t>(axis))[lane] = start_m[axis];
}

Descent descent_in(const DescentBatch& batch, std::size_t lane) {
  return {{batch.position_m.row(0)[lane], batch.position_m.row(1)[lane], batch.position_m.row(2)[lane]},
          batch.status[lane],
          static_cast<int>(batch.iterations.row(0)[lane]),
          batch.cost_m2.row(0)[lane]};
}

// `iterations` are those of the lanes and `before` is room for as many.
template <class Lanes>
void descend_to_minima(Lanes& lanes, const NonlinearOptions& options, std::span<double> iterations,
                       std::span<double> before) {
  if (options.curvature == Curvature::newton) {
    DescentOptions approach = options;
    approach.curvature = Curvature::gauss_newton;
    approach.stop = StopRule::step;
    approach.step_tolerance_m = std::max(options.step_tolerance_m, kApproach_m);
    descend(lanes, approach);
    std::copy(iterations.begin(), iterations.end(), before.begin());
  }
  descend(lanes, options);
  std::transform(iterations.begin(), iterations.end(), before.begin(), iterations.begin(), std::plus());
}

void solve_block(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                 std::span<PointEstimate> estimates) {
  std::vector<Prepared> starts(problems.size());
  std::vector<SensorPlane> planes;  // one for each change of the sensors
  std::vector<std::size_t> plane_of_problem(problems.size());
  std::size_t lanes = 0;
  int sensors = 1;
  for (std::size_t p = 0; p < problems.size(); ++p) {
    starts[p].refusal = refusal_of(problems[p]);
    if (starts[p].refusal != SolveStatus::not_solved) continue;
    if (planes.empty() || p == 0 || !same_sensors(problems[p], problems[p - 1]))
      planes.push_back(plane_of(problems[p]));
    plane_of_problem[p] = planes.size() - 1;
    starts[p] = prepared(problems[p], planes.back(), options);
    lanes += static_cast<std::size_t>(starts[p].starts);
    sensors = std::max(sensors, problems[p].count);
  }
  DescentBatch batch(sensors, lanes, false);
  std::size_t lane = 0;
  for (std::size_t p = 0; p < problems.size(); ++p)
    for (int s = 0; s < starts[p].starts; ++s)
      fill_lane(batch, lane++, problems[p], starts[p].start_m[static_cast<std::size_t>(s)]);
  std::vector<double> approach_iterations(lanes);
  descend_to_minima(batch, options, {batch.iterations.row(0), lanes}, approach_iterations);
  lane = 0;
  for (std::size_t p = 0; p < problems.size(); ++p) {
    if (starts[p].starts == 0) {
      estimates[p] = failed_estimate(starts[p].refusal);
      continue;
    }
    const Descent first = descent_in(batch, lane);
    const Descent second = starts[p].starts == 2 ? descent_in(batch, lane + 1) : first;
    lane += static_cast<std::size_t>(starts[p].starts);
    estimates[p] = finished(problems[p], planes[plane_of_problem[p]], options, starts[p], first, second);
  }
}

}  // namespace

Eigen::Vector3d wanted_start_m(const RangeProblem& problem, const SensorPlane& plane, Start start,
                               const Eigen::Vector3d& start_point_m, const LinearOptions& linear) {
  if (start == Start::point) return start_point_m;
  if (start == Start::hint && problem.hint_m) return *problem.hint_m;
  if (start == Start::linear)
    if (const auto x_m = linear_position_m(problem, linear)) return *x_m;
  return squared_range_position_m(problem, plane);
}

PointEstimate solve_nonlinear(const RangeProblem& problem, const NonlinearOptions& options) {
  TRILAT_CHECK(contradiction_in(options).empty(), "the settings of a descent fit together");
  const SolveStatus refusal = refusal_of(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  const SensorPlane plane = plane_of(problem);
  const Prepared start = prepared(problem, plane, options);
  if (start.starts == 0) return failed_estimate(start.refusal);
  DescentPair pair;
  pair.sensors = problem.count;
  for (int i = 0; i < problem.count; ++i) {
    for (std::size_t lane = 0; lane < kPairLanes; ++lane) {
      for (int axis = 0; axis < 3; ++axis) pair.sensor_m[3 * i + axis][lane] = problem.sensor_m[i][axis];
      pair.range_m[i][lane] = problem.range_m[i];
      pair.weight[i][lane] = problem.weight[i];
    }
  }
  for (std::size_t lane = 0; lane < kPairLanes; ++lane)
    for (int axis = 0; axis < 3; ++axis)
      pair.position_m[axis][lane] = start.start_m[start.starts == 2 ? lane : 0][axis];
  std::array<double, kPairLanes> approach_iterations{};
  descend_to_minima(pair, options, pair.iterations, approach_iterations);
  std::array<Descent, kPairLanes> ends;
  for (std::size_t lane = 0; lane < kPairLanes; ++lane)
    ends[lane] = {{pair.position_m[0][lane], pair.position_m[1][lane], pair.position_m[2][lane]},
                  pair.status[lane],
                  static_cast<int>(pair.iterations[lane]),
                  pair.cost_m2[lane]};
  return finished(problem, plane, options, start, ends[0], ends[1]);
}

void solve_nonlinear(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                     std::span<PointEstimate> estimates) {
  TRILAT_CHECK(problems.size() == estimates.size(), "every problem has a slot");
  for (std::size_t first = 0; first < problems.size(); first += kProblemsAtATime) {
    const std::size_t size = std::min(kProblemsAtATime, problems.size() - first);
    solve_block(problems.subspan(first, size), options, estimates.subspan(first, size));
  }
}

}  // namespace trilat
