// SPDX-License-Identifier: MIT
#include "evaluators/solvers/nonlinear.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "datasets/base/error.h"
#include "evaluators/solvers/range_equations.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

constexpr std::size_t kProblemsAtATime = 512;
constexpr double kFlat = 0.2;  // spread of the sensors across their plane, of the offset of a minimum

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

// Both starts of one problem, without allocating.
std::array<Descent, kPairLanes> descend_pair(const RangeProblem& problem, const NonlinearOptions& options,
                                             const std::array<Eigen::Vector3d, kPairLanes>& start_m) {
  DescentPair pair;
  for (std::size_t lane = 0; lane < kPairLanes; ++lane) pair.set_lane(lane, problem, start_m[lane]);
  descend(pair, options);
  std::array<Descent, kPairLanes> ends;
  for (std::size_t lane = 0; lane < kPairLanes; ++lane)
    ends[lane] = {{pair.position_m[0][lane], pair.position_m[1][lane], pair.position_m[2][lane]},
                  pair.status[lane],
                  static_cast<int>(pair.iterations[lane]),
                  pair.cost_m2[lane]};
  return ends;
}

// Whether the sensors are flat enough for a minimum on the other side of their plane, and no descent found
// it.
bool other_side_unseen(const SensorPlane& plane, int sensors, const Descent& first, const Descent& second) {
  const double here_m = plane.offset_m(first.position_m);
  const double across_m = std::sqrt(plane.scatter_m2[0] / sensors);
  return here_m * plane.offset_m(second.position_m) > 0.0 && across_m < kFlat * std::abs(here_m);
}

PointEstimate finished(const RangeProblem& problem, const SensorPlane& plane, const NonlinearOptions& options,
                       const Prepared& prepared, Descent first, Descent second) {
  if (prepared.starts == 1 && !plane.exact) return estimate_of(problem, first);
  if (plane.exact) second = mirrored(plane, first);
  Descent third;
  if (prepared.starts == 2 && other_side_unseen(plane, problem.count, first, second)) {
    const Eigen::Vector3d image_m = plane.mirrored(first.position_m);
    third = descend_pair(problem, options, {image_m, image_m})[0];
  }
  Descent best = choose_minimum(problem, plane, first, second, options.range_sigma_m);
  if (third.status != SolveStatus::not_solved)
    best = choose_minimum(problem, plane, best, third, options.range_sigma_m);
  return estimate_of(problem, best);
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
    batch.weight.row(row)[lane] = i < problem.count ? 1.0 : 0.0;
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

// A problem of a block, and where its descents are: the second ones come after all first ones, because on the
// wrong side of the sensors' plane they take longer and lanes wait for their neighbours.
struct BlockEntry {
  Prepared prepared;
  std::size_t plane = 0, first_lane = 0, second_lane = 0;
};

struct Block {
  std::vector<BlockEntry> entries;
  std::vector<SensorPlane> planes;  // one for each change of the sensors
  std::size_t lanes = 0;
  int sensors = 1;
};

Block prepared_block(std::span<const RangeProblem> problems, const NonlinearOptions& options) {
  Block block;
  block.entries.resize(problems.size());
  const RangeProblem* before = nullptr;
  for (std::size_t p = 0; p < problems.size(); ++p) {
    BlockEntry& entry = block.entries[p];
    entry.prepared.refusal = refusal_of(problems[p]);
    if (entry.prepared.refusal != SolveStatus::not_solved) continue;
    if (!before || !same_sensors(problems[p], *before)) block.planes.push_back(plane_of(problems[p]));
    before = &problems[p];
    entry.plane = block.planes.size() - 1;
    entry.prepared = prepared(problems[p], block.planes.back(), options);
    if (entry.prepared.starts > 0) entry.first_lane = block.lanes++;
    block.sensors = std::max(block.sensors, problems[p].count);
  }
  for (BlockEntry& entry : block.entries)
    if (entry.prepared.starts == 2) entry.second_lane = block.lanes++;
  return block;
}

void solve_block(std::span<const RangeProblem> problems, const NonlinearOptions& options,
                 std::span<PointEstimate> estimates) {
  const Block block = prepared_block(problems, options);
  DescentBatch batch(block.sensors, block.lanes, false);
  for (std::size_t p = 0; p < problems.size(); ++p) {
    const auto& [start, plane, first_lane, second_lane] = block.entries[p];
    if (start.starts > 0) fill_lane(batch, first_lane, problems[p], start.start_m[0]);
    if (start.starts == 2) fill_lane(batch, second_lane, problems[p], start.start_m[1]);
  }
  descend(batch, options);
  for (std::size_t p = 0; p < problems.size(); ++p) {
    const auto& [start, plane, first_lane, second_lane] = block.entries[p];
    if (start.starts == 0) {
      estimates[p] = failed_estimate(start.refusal);
      continue;
    }
    const Descent first = descent_in(batch, first_lane);
    const Descent second = start.starts == 2 ? descent_in(batch, second_lane) : first;
    estimates[p] = finished(problems[p], block.planes[plane], options, start, first, second);
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
  const auto ends =
      descend_pair(problem, options, {start.start_m[0], start.start_m[start.starts == 2 ? 1 : 0]});
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
