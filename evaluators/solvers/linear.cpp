// SPDX-License-Identifier: MIT
#include "evaluators/solvers/linear.h"

#include <cmath>
#include <optional>

#include <Eigen/QR>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

constexpr double kThick = 10.0;  // range sigmas

int reference_entry(const RangeProblem& problem, int reference_sensor) {
  int lowest = 0;
  int next = -1;
  for (int i = 0; i < problem.count; ++i) {
    const int number = problem.rig_index[i];
    if (number < problem.rig_index[lowest]) lowest = i;
    if (number >= reference_sensor && (next < 0 || number < problem.rig_index[next])) next = i;
  }
  return next < 0 ? lowest : next;
}

}  // namespace

// Row i: 2 (s_i - o).x' = |s_i - o|^2 - r_i^2, less the reference's, with x' = x - o relative to the origin
// o. Less the mean row, the least squares are those of all pairs: sum over i < j of (a_i - a_j)(a_i - a_j)^T
// is n times the sum of (a_i - mean)(a_i - mean)^T.
std::optional<Eigen::Vector3d> linear_position_m(const RangeProblem& problem, const LinearOptions& options) {
  using Columns3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMaxSensors, 3>;
  if (problem.count < 4) return std::nullopt;
  const bool one_sensor = options.reference == LinearReference::one_sensor;
  const int reference = one_sensor ? reference_entry(problem, options.reference_sensor) : 0;
  const Eigen::Vector3d origin_m = problem.sensor_m[reference];
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::ColMajor, kMaxSensors, 4> rows(problem.count, 4);
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - origin_m;
    rows.row(i) << 2.0 * s.transpose(), s.squaredNorm() - problem.range_m[i] * problem.range_m[i];
  }
  const Eigen::RowVector4d subtrahend =
      one_sensor ? rows.row(reference).eval() : rows.colwise().mean().eval();
  rows.rowwise() -= subtrahend;
  const Eigen::ColPivHouseholderQR<Columns3> qr(rows.leftCols<3>());
  const double largest = std::abs(qr.matrixQR()(0, 0)), smallest = std::abs(qr.matrixQR()(2, 2));
  if (!(smallest > options.rank_ratio * largest)) return std::nullopt;  // NaN too
  return origin_m + qr.solve(rows.col(3));
}

PointEstimate solve_linear(const RangeProblem& problem, const LinearOptions& options) {
  const SolveStatus refusal = validate(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  const auto x_m = linear_position_m(problem, options);
  if (!x_m) return failed_estimate(SolveStatus::rank_deficient);
  if (!x_m->allFinite()) return failed_estimate(SolveStatus::diverged);
  const SensorPlane plane = plane_of(problem);
  if (std::sqrt(plane.scatter_m2[0]) >= kThick * options.range_sigma_m)
    return estimate_at(problem, *x_m, SolveStatus::closed_form, 0);
  const Eigen::Vector3d image_m = plane.mirrored(*x_m);
  const MirrorChoice choice = choose_mirror(*x_m, image_m, problem.guess_m);
  return estimate_at(problem, choice.first ? *x_m : image_m,
                     choice.decided ? SolveStatus::closed_form : SolveStatus::mirror_ambiguous, 0);
}

}  // namespace trilat
