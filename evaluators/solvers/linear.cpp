// SPDX-License-Identifier: MIT
#include "evaluators/solvers/linear.h"

#include <cmath>
#include <optional>
#include <utility>

#include "evaluators/solvers/range_equations.h"

namespace trilat {
namespace {

// Columns of [A | b], one row an equation.
struct LinearSystem {
  int rows = 0;
  std::array<std::array<double, kMaxSensors>, 4> column;
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

// Row i: 2 (s_i - o).x' = |s_i - o|^2 - r_i^2, minus the same of the reference, with x' = x - o
// relative to the origin o. Centred on the mean row, the least squares are those of all pairs:
// sum over i < j of (a_i - a_j)(a_i - a_j)^T is n times the sum of (a_i - mean)(a_i - mean)^T.
LinearSystem differences(const RangeProblem& problem, const Eigen::Vector3d& origin_m, int reference) {
  LinearSystem system;
  std::array<double, 4> subtrahend{};
  for (int i = 0; i < problem.count; ++i) {
    const Eigen::Vector3d s = problem.sensor_m[i] - origin_m;
    const std::array<double, 4> row{2.0 * s.x(), 2.0 * s.y(), 2.0 * s.z(),
                                    s.squaredNorm() - problem.range_m[i] * problem.range_m[i]};
    for (int c = 0; c < 4; ++c) {
      system.column[c][i] = row[c];
      if (reference < 0) subtrahend[c] += row[c] / problem.count;
      if (reference == i) subtrahend[c] = row[c];
    }
  }
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < problem.count; ++i) system.column[c][i] -= subtrahend[c];
  system.rows = problem.count;
  return system;
}

double dot(const LinearSystem& system, int a, int b) {
  double sum = 0.0;
  for (int i = 0; i < system.rows; ++i) sum += system.column[a][i] * system.column[b][i];
  return sum;
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

// Least squares by modified Gram-Schmidt on [A | b] with column pivoting (Bjorck 1967: backward
// stable). Nothing when the system is rank deficient.
std::optional<Eigen::Vector3d> least_squares(LinearSystem system, double rank_ratio) {
  std::array<int, 3> order{0, 1, 2};
  UpperRows r{};
  for (int k = 0; k < 3; ++k) {
    r[k][k] = pivot_to(system, r, order, k);
    if (!(r[k][k] > rank_ratio * r[0][0])) return std::nullopt;
    for (int i = 0; i < system.rows; ++i) system.column[k][i] /= r[k][k];
    for (int c = k + 1; c < 4; ++c) {
      r[k][c] = dot(system, k, c);
      for (int i = 0; i < system.rows; ++i) system.column[c][i] -= r[k][c] * system.column[k][i];
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

PointEstimate solve_linear(const RangeProblem& problem, const LinearOptions& options) {
  const SolveStatus refusal = refusal_of(problem);
  if (refusal != SolveStatus::not_solved) return failed_estimate(refusal);
  if (problem.count < 4) return failed_estimate(SolveStatus::rank_deficient);
  const bool one_sensor = options.reference == LinearReference::one_sensor;
  const int reference = one_sensor ? reference_entry(problem, options.reference_sensor) : -1;
  const Eigen::Vector3d origin_m = problem.sensor_m[one_sensor ? reference : 0];
  const auto x = least_squares(differences(problem, origin_m, reference), options.rank_ratio);
  if (!x) return failed_estimate(SolveStatus::rank_deficient);
  if (!x->allFinite()) return failed_estimate(SolveStatus::diverged);
  return estimate_at(problem, origin_m + *x, SolveStatus::closed_form, 0);
}

}  // namespace trilat
