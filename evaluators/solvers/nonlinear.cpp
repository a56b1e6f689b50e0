// SPDX-License-Identifier: MIT
#include "evaluators/solvers/nonlinear.h"

#include <algorithm>
#include <vector>

#include "datasets/base/error.h"
#include "evaluators/solvers/range_lanes.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

// Why a problem has no descent; not_solved where it has.
SolveStatus validate(const SensorPlane& plane, const NonlinearOptions& options) {
  if (options.start == Start::point && !options.start_point_m.allFinite())
    return SolveStatus::non_finite_input;
  return plane.collinear ? SolveStatus::rank_deficient : SolveStatus::not_solved;
}

Vector3d start_of(const RangeProblem& problem, const SensorPlane& plane, const NonlinearOptions& options) {
  const Vector3d wanted_m =
      requested_start_m(problem, plane, options.start, options.start_point_m, options.linear);
  const bool is_safe = options.damping == Damping::none && wanted_m.allFinite();
  return is_safe ? wanted_m : plausible_start(problem, plane, wanted_m);
}

// The estimate without damping: the one descent, or where the sensors are exactly in one plane its mirror
// image.
PointEstimate undamped_estimate(const RangeProblem& problem, const SensorPlane& plane, const Descent& descent,
                                double range_sigma_m) {
  if (!plane.exact) return estimate_of(problem, descent);
  return estimate_of(problem,
                     choose_minimum(problem, plane, descent, mirrored(plane, descent), range_sigma_m));
}

// By vectors, for problems that all have the sensors of the first.
void descend_together(std::span<const RangeProblem> problems, std::span<const std::size_t> members,
                      const NonlinearOptions& options, std::span<Descent> descents) {
  const RangeProblem& first = problems[members[0]];
  const auto sensors = static_cast<std::size_t>(first.count);
  RangeLanes lanes({first.sensor_m.data(), sensors}, members.size());
  for (std::size_t lane = 0; lane < members.size(); ++lane) {
    for (std::size_t i = 0; i < sensors; ++i) lanes.range_m.row(i)[lane] = problems[members[lane]].range_m[i];
    lanes.position_m.set_position(lane, descents[members[lane]].position_m);
  }
  descend(lanes, options);
  for (std::size_t lane = 0; lane < members.size(); ++lane) {
    Descent& descent = descents[members[lane]];
    descent.position_m = lanes.position_m.position(lane);
    descent.status = lanes.status[lane];
    descent.iterations = static_cast<int>(lanes.iterations.row(0)[lane]);
    descent.cost = linearise(problems[members[lane]], descent.position_m).cost;
  }
}

void solve_undamped(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                    std::span<PointEstimate> estimates) {
  std::vector<std::size_t> order;
  for (std::size_t p = 0; p < problems.size(); ++p) {
    estimates[p] = failed_estimate(validate(problems[p]));
    if (estimates[p].status == SolveStatus::not_solved) order.push_back(p);
  }
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return sensors_before(problems[a], problems[b]); });
  std::vector<Descent> descents(problems.size());
  for (auto first = order.begin(); first != order.end();) {
    const auto last = std::find_if(
        first, order.end(), [&](std::size_t p) { return !same_sensors(problems[p], problems[*first]); });
    const SensorPlane plane = plane_of(problems[*first]);
    const std::span<const std::size_t> members{first, last};
    const SolveStatus refusal = validate(plane, options);
    for (const std::size_t p : members) {
      estimates[p].status = refusal;
      if (refusal == SolveStatus::not_solved) descents[p].position_m = start_of(problems[p], plane, options);
    }
    first = last;
    if (refusal != SolveStatus::not_solved) continue;
    descend_together(problems, members, options, descents);
    for (const std::size_t p : members)
      estimates[p] = undamped_estimate(problems[p], plane, descents[p], options.range_sigma_m);
  }
}

// Solves a problem that validate() does not refuse; `plane` is its own.
PointEstimate solve(const RangeProblem& problem, const SensorPlane& plane, const NonlinearOptions& options) {
  const SolveStatus refusal = validate(plane, options);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  const Vector3d start_m = start_of(problem, plane, options);
  const auto descend_from = [&](const Vector3d& from_m) { return descend(problem, from_m, options); };
  if (options.damping == Damping::none)
    return undamped_estimate(problem, plane, descend_from(start_m), options.range_sigma_m);
  return estimate_of(problem,
                     descend_on_both_sides(problem, plane, start_m, options.range_sigma_m, descend_from));
}

}  // namespace

Vector3d requested_start_m(const RangeProblem& problem, const SensorPlane& plane, Start start,
                           const Vector3d& start_point_m, const LinearOptions& linear) {
  if (start == Start::point) return start_point_m;
  if (start == Start::guess && problem.guess_m) return *problem.guess_m;
  if (start == Start::linear)
    if (const auto x_m = linear_position_m(problem, linear)) return *x_m;
  return solve_squared_ranges(problem, plane);
}

PointEstimate solve_nonlinear(const RangeProblem& problem, const NonlinearOptions& options) {
  const SolveStatus refusal = validate(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  return solve(problem, plane_of(problem), options);
}

void solve_nonlinear(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                     std::span<PointEstimate> estimates) {
  TRILAT_CHECK(problems.size() == estimates.size(), "every problem has a slot");
  if (options.damping == Damping::none) return solve_undamped(problems, options, estimates);
  SensorPlane plane;
  const RangeProblem* before = nullptr;  // whose plane that is
  for (std::size_t p = 0; p < problems.size(); ++p) {
    const SolveStatus refusal = validate(problems[p]);
    estimates[p] = failed_estimate(refusal);
    if (refusal != SolveStatus::not_solved) continue;
    if (!before || !same_sensors(problems[p], *before)) plane = plane_of(problems[p]);
    before = &problems[p];
    estimates[p] = solve(problems[p], plane, options);
  }
}

}  // namespace trilat
