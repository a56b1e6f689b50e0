// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "evaluators/solvers/point_estimate.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

enum class Gradient : std::uint8_t {
  // eq. 17 as printed, erratum E7: the step shrinks by about unit / distance, and unless the distances are
  // equal it ends where sum(u f / d) = 0, which is not the minimum of F.
  printed,
  corrected,  // J^T W f
};

enum class Damping : std::uint8_t {
  none,  // eq. 14: the plain step, one descent from the start
  lm,    // Levenberg and Marquardt, on both sides of the sensors' plane; corrected gradient only
};

enum class StopRule : std::uint8_t {
  printed,    // eq. 19, erratum E8: F_k - F_{k-1} < threshold, true as soon as F falls
  objective,  // |F_k - F_{k-1}| < threshold
  step,       // |x_k - x_{k-1}| < step_tolerance
};

// What the step inverts.
enum class Curvature : std::uint8_t {
  gauss_newton,  // J^T W J (eq. 14, which the paper calls Newton iteration: erratum E10)
  // Half the Hessian of F, J^T W J + sum w (1 - r/d) (I - u u^T), once Gauss-Newton predicts F well.
  newton,
};

struct DescentOptions {
  Gradient gradient = Gradient::corrected;
  Damping damping = Damping::lm;
  StopRule stop = StopRule::step;
  Curvature curvature = Curvature::gauss_newton;
  double threshold_m2 = 1e-8;       // of printed and objective; the paper's C is in cm^2
  double step_tolerance_m = 1e-10;  // of step
  int max_iterations = 1000;
  // The length in which the printed gradient counts distances. The paper's figures are in centimetres; in
  // metres its step would be 100 times as long.
  double printed_unit_m = 0.01;
};

// What is wrong with these options together, as a sentence; empty when nothing is.
std::string contradiction_in(const DescentOptions& options);

// Rows of doubles, one lane a problem, each row starting on a boundary of 64 bytes and filled up to a
// multiple of kLaneBlock lanes. Zero at first.
class LaneRows {
 public:
  LaneRows() = default;
  LaneRows(std::size_t rows, std::size_t lanes);
  double* row(std::size_t r) { return data_.get() + r * stride_; }
  const double* row(std::size_t r) const { return data_.get() + r * stride_; }
  std::size_t stride() const { return stride_; }

 private:
  struct Free {
    void operator()(double* p) const;
  };
  std::unique_ptr<double[], Free> data_;
  std::size_t stride_ = 0;
};
inline constexpr std::size_t kLaneBlock = 8;  // lanes of the widest vector

// Descents side by side: each lane is one problem with one start.
struct DescentBatch {
  int sensors = 0;                  // 1 to kMaxSensors
  std::size_t count = 0;            // lanes in use
  bool one_rig = false;             // the sensors stand alike for all lanes: sensor_m has one lane
  LaneRows sensor_m;                // 3 rows a sensor: x, y, z in the world
  LaneRows range_m;                 // a row a sensor
  LaneRows weight;                  // a row a sensor: 1, or 0 when it does not see the joint
  LaneRows position_m;              // x, y, z: the start, then the end
  LaneRows cost_m2;                 // sum of squared residuals at the end
  LaneRows iterations;              // steps tried
  std::vector<SolveStatus> status;  // converged, iteration_limit, rank_deficient or diverged

  // Makes the rows, with every weight 1.
  DescentBatch(int sensor_count, std::size_t lanes, bool shared_rig);
};

// Minimises F = sum w (|x - s| - r)^2 in every lane, by the widest vectors this processor has.
// Every lane gives the same bits whatever the width and whatever the others do. A lane ends with
//   converged        its stop rule held
//   rank_deficient   is_rank_deficient() of J^T W J at an iterate (without damping only)
//   iteration_limit  max_iterations steps were tried
//   diverged         an iterate or its cost is not finite
// InternalError when contradiction_in(options).
void descend(DescentBatch& batch, const DescentOptions& options);

// The same for one problem or its two sides, without allocating: rows of kPairLanes lanes.
inline constexpr std::size_t kPairLanes = 2;
struct DescentPair {
  int sensors = 0;
  alignas(16) double sensor_m[24][kPairLanes];
  alignas(16) double range_m[8][kPairLanes];
  alignas(16) double weight[8][kPairLanes];
  alignas(16) double position_m[3][kPairLanes];
  alignas(16) double cost_m2[kPairLanes];
  alignas(16) double iterations[kPairLanes];
  SolveStatus status[kPairLanes];

  void set_lane(std::size_t lane, const RangeProblem& problem, const Eigen::Vector3d& start_m) {
    sensors = problem.count;
    for (int i = 0; i < problem.count; ++i) {
      for (int axis = 0; axis < 3; ++axis) sensor_m[3 * i + axis][lane] = problem.sensor_m[i][axis];
      range_m[i][lane] = problem.range_m[i];
      weight[i][lane] = 1.0;
    }
    for (int axis = 0; axis < 3; ++axis) position_m[axis][lane] = start_m[axis];
  }
};
void descend(DescentPair& pair, const DescentOptions& options);

}  // namespace trilat
