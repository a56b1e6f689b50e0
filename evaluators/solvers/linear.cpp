// SPDX-License-Identifier: MIT
#include "evaluators/solvers/linear.h"

#include <cmath>
#include <optional>
#include <utility>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

constexpr double kThick = 10.0;  // range sigmas

// Columns of [A | b], one row an equation, two rows at a time; rows beyond the last are zero.
struct LinearSystem {
  int pairs = 0;
  std::array<std::array<Eigen::Array2d, kMaxSensors / 2>, 4> column;
};

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

// Row i: 2 (s_i - o).x' = |s_i - o|^2 - r_i^2, minus the same of the reference, with x' = x - o relative to
// the origin o. Centred on the mean row, the least squares are those of all pairs:
// sum over i < j of (a_i - a_j)(a_i - a_j)^T is n times the sum of (a_i - mean)(a_i - mean)^T.
LinearSystem differences(const RangeProblem& problem, const Eigen::Vector3d& origin_m, int reference) {
  std::array<std::array<double, 4>, kMaxSensors> row;
  std::array<double, 4> subtrahend{};
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - origin_m;
    row[i] = {2.0 * s.x(), 2.0 * s.y(), 2.0 * s.z(),
              s.squaredNorm() - problem.range_m[i] * problem.range_m[i]};
    for (int c = 0; c < 4 && reference < 0; ++c) subtrahend[c] += row[i][c] / problem.count;
  }
  if (reference >= 0) subtrahend = row[reference];
  LinearSystem system;
  system.pairs = (problem.count + 1) / 2;
  for (int c = 0; c < 4; ++c) {
    for (int i = 0; i < problem.count; ++i) system.column[c][i / 2][i % 2] = row[i][c] - subtrahend[c];
    if (problem.count % 2 == 1) system.column[c][problem.count / 2][1] = 0.0;
  }
  return system;
}

double dot(const LinearSystem& system, int a, int b) {
  Eigen::Array2d sum = Eigen::Array2d::Zero();
  for (int p = 0; p < system.pairs; ++p) sum += system.column[a][p] * system.column[b][p];
  return sum.sum();
}

using UpperRows = std::array<std::array<double, 4>, 3>;

// Brings the longest of the columns k … 2 to place k, and returns its length.
double pivot_to(LinearSystem& system, UpperRows& r, std::array<int, 3>& order, int k) {
  int pivot = k;
  double largest = -1.0;
  for (int c = k; c < 3; ++c) {
    const double square = dot(system, c, c);
    if (square > largest) {
      largest = square;
      pivot = c;
    }
  }
  std::swap(system.column[k], system.column[pivot]);
  std::swap(order[k], order[pivot]);
  for (int row = 0; row < k; ++row) std::swap(r[row][k], r[row][pivot]);
  return std::sqrt(largest);
}

// Least squares by modified Gram-Schmidt on [A | b] with column pivoting (Bjorck 1967: backward stable).
// Nothing when the system is rank deficient.
std::optional<Eigen::Vector3d> least_squares(LinearSystem system, double rank_ratio) {
  std::array<int, 3> order{0, 1, 2};
  UpperRows r{};
  for (int k = 0; k < 3; ++k) {
    r[k][k] = pivot_to(system, r, order, k);
    if (!(r[k][k] > rank_ratio * r[0][0])) return std::nullopt;
    const double inverse = 1.0 / r[k][k];
    for (int p = 0; p < system.pairs; ++p) system.column[k][p] *= inverse;
    for (int c = k + 1; c < 4; ++c) {
      r[k][c] = dot(system, k, c);
      for (int p = 0; p < system.pairs; ++p) system.column[c][p] -= r[k][c] * system.column[k][p];
    }
  }
  Eigen::Vector3d x;
  const double x2 = r[2][3] / r[2][2];
  const double x1 = (r[1][3] - r[1][2] * x2) / r[1][1];
  x[order[2]] = x2;
  x[order[1]] = x1;
  x[order[0]] = (r[0][3] - r[0][1] * x1 - r[0][2] * x2) / r[0][0];
  return x;
}

}  // namespace

std::optional<Eigen::Vector3d> linear_position_m(const RangeProblem& problem, const LinearOptions& options) {
  if (problem.count < 4) return std::nullopt;
  const bool one_sensor = options.reference == LinearReference::one_sensor;
  const int reference = one_sensor ? reference_entry(problem, options.reference_sensor) : -1;
  const Eigen::Vector3d origin_m = problem.sensor_m[one_sensor ? reference : 0];
  const auto x = least_squares(differences(problem, origin_m, reference), options.rank_ratio);
  if (!x) return std::nullopt;
  return origin_m + *x;
}

PointEstimate solve_linear(const RangeProblem& problem, const LinearOptions& options) {
  const SolveStatus refusal = refusal_of(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  const auto x_m = linear_position_m(problem, options);
  if (!x_m) return failed_estimate(SolveStatus::rank_deficient);
  if (!x_m->allFinite()) return failed_estimate(SolveStatus::diverged);
  const SensorPlane plane = plane_of(problem);
  if (std::sqrt(plane.scatter_m2[0]) >= kThick * options.range_sigma_m)
    return estimate_at(problem, *x_m, SolveStatus::closed_form, 0);
  const Eigen::Vector3d image_m = plane.mirrored(*x_m);
  const MirrorChoice choice = choose_mirror(*x_m, image_m, problem.hint_m);
  return estimate_at(problem, choice.first ? *x_m : image_m,
                     choice.decided ? SolveStatus::closed_form : SolveStatus::mirror_ambiguous, 0);
}

}  // namespace trilat
