// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

namespace trilat {

// The method of moments behind measure_tracker(): variances of a tracker's errors by least squares.

constexpr double kPaths_m[] = {0.06, 0.08, 0.11, 0.14, 0.18, 0.23, 0.3, 0.39,
                               0.5,  0.65, 0.85, 1.1,  1.4,  1.8,  2.4};
constexpr std::size_t kPaths = std::size(kPaths_m);

enum Part { common, view, own, kParts };
constexpr int kVariances = 2 * kParts;  // of the bias, then of the wander
using Row = Eigen::Matrix<double, kVariances, 1>;
using Normal = Eigen::Matrix<double, kVariances, kVariances>;

// Sums of least squares, for each candidate of the wander's path.
struct Sums {
  std::array<Normal, kPaths> normal;
  std::array<Row, kPaths> right;
  Row apart = Row::Zero();  // squares of the rows if nothing of the wander were kept
  double squares = 0.0, count = 0.0;

  Sums() {
    normal.fill(Normal::Zero());
    right.fill(Row::Zero());
  }
  Sums& operator+=(const Sums& other) {
    for (std::size_t p = 0; p < kPaths; ++p) {
      normal[p] += other.normal[p];
      right[p] += other.right[p];
    }
    apart += other.apart;
    squares += other.squares;
    count += other.count;
    return *this;
  }
  // y is expected to be bias . (the bias' variances) + (still + exp(-path / wander path) moving) . (the
  // wander's).
  void add(const Eigen::Vector3d& bias, const Eigen::Vector3d& still, const Eigen::Vector3d& moving,
           double path_m, double y);
};

// What least squares find at one candidate of the path: the wander from increments, then the bias from
// products.
struct Solution {
  Row variance_m2 = Row::Zero();
  std::array<bool, kVariances> told{};
};
Solution solve(const Sums& products, const Sums& increments, std::size_t path);

// The squares that the wander at one candidate of the path leaves of the increments.
double misfit_of(const Sums& increments, std::size_t path);

// How much the data say of one variance beside the other columns of [first, last): the reciprocal of what
// least squares leave of it, up to a factor.
double information_of(const Normal& normal, int column, int first, int last);

}  // namespace trilat
