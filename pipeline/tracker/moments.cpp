// SPDX-License-Identifier: MIT
#include "pipeline/tracker/moments.h"

#include <cmath>
#include <vector>

#include <Eigen/Dense>

namespace trilat {
namespace {

constexpr double kSingular = 1e-4;

// Which of the columns the data tell apart from the others; what hardly moved tells no wander.
std::array<bool, kVariances> told_apart(const Sums& sums, std::size_t path, int first, int last) {
  constexpr double kLeast = 0.04;
  const Normal& normal = sums.normal[path];
  std::array<bool, kVariances> told{};
  for (int k = first; k < last; ++k)
    told[static_cast<std::size_t>(k)] =
        normal(k, k) > 0.0 && (k < kParts || normal(k, k) > kLeast * sums.apart[k]);
  Row scale = normal.diagonal().cwiseSqrt().array().max(1e-300).matrix();
  const Eigen::SelfAdjointEigenSolver<Normal> eigen(scale.cwiseInverse().asDiagonal() * normal *
                                                    scale.cwiseInverse().asDiagonal());
  for (int k = first; k < last; ++k) {
    double blurred = 0.0;
    for (int e = 0; e < kVariances; ++e)
      if (eigen.eigenvalues()[e] < kSingular) blurred += std::pow(eigen.eigenvectors()(k, e), 2);
    if (blurred > 0.05) told[static_cast<std::size_t>(k)] = false;
  }
  return told;
}

// Least squares of the columns [first, last), whose variances are not negative: the most negative is set to 0
// until none is left. What the other columns explain is taken off first.
void solve_columns(const Normal& normal, const Row& right, int first, int last, Row& variance_m2) {
  for (int k = first; k < last; ++k) variance_m2[k] = 0.0;
  const Row wanted = right - normal * variance_m2;
  std::vector<int> free;
  for (int k = first; k < last; ++k)
    if (normal(k, k) > 1e-12 * normal.diagonal().maxCoeff()) free.push_back(k);
  while (!free.empty()) {
    const auto n = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd a(n, n);
    Eigen::VectorXd b(n), scale(n);
    for (Eigen::Index i = 0; i < n; ++i)
      scale[i] = std::sqrt(normal(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(i)]));
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = wanted[free[static_cast<std::size_t>(i)]] / scale[i];
      for (Eigen::Index k = 0; k < n; ++k)
        a(i, k) = normal(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(k)]) /
                  (scale[i] * scale[k]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(a);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    for (Eigen::Index e = 0; e < n; ++e)
      if (eigen.eigenvalues()[e] > kSingular)
        x += eigen.eigenvectors().col(e) * eigen.eigenvectors().col(e).dot(b) / eigen.eigenvalues()[e];
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0.0) {
      for (Eigen::Index i = 0; i < n; ++i) variance_m2[free[static_cast<std::size_t>(i)]] = x[i] / scale[i];
      return;
    }
    free.erase(free.begin() + worst);
  }
}

// The wander from increments (with the bias by direction of view, which changes as a body turns).
Row wander_of(const Sums& increments, std::size_t path) {
  Row variance_m2 = Row::Zero();
  solve_columns(increments.normal[path], increments.right[path], view, kVariances, variance_m2);
  return variance_m2;
}

}  // namespace

void Sums::add(const Eigen::Vector3d& bias, const Eigen::Vector3d& still, const Eigen::Vector3d& moving,
               double path_m, double y) {
  for (std::size_t p = 0; p < kPaths; ++p) {
    Row row;
    row << bias, still + std::exp(-path_m / kPaths_m[p]) * moving;
    normal[p].noalias() += row * row.transpose();
    right[p] += y * row;
  }
  apart += (Row() << bias, still).finished().cwiseAbs2();
  squares += y * y;
  count += 1.0;
}

Solution solve(const Sums& products, const Sums& increments, std::size_t path) {
  Solution solution;
  solution.variance_m2 = wander_of(increments, path);
  const auto wander = told_apart(increments, path, kParts, kVariances);
  solve_columns(products.normal[path], products.right[path], 0, kParts, solution.variance_m2);
  solution.told = told_apart(products, path, 0, kParts);
  for (std::size_t k = kParts; k < kVariances; ++k) solution.told[k] = wander[k];
  return solution;
}

double misfit_of(const Sums& sums, std::size_t path) {
  const Row v = wander_of(sums, path);
  return sums.squares - 2.0 * v.dot(sums.right[path]) + v.dot(sums.normal[path] * v);
}

double information_of(const Normal& normal, int column, int first, int last) {
  std::vector<int> columns;
  for (int k = first; k < last; ++k)
    if (normal(k, k) > 1e-12 * normal.diagonal().maxCoeff()) columns.push_back(k);
  Eigen::MatrixXd block(columns.size(), columns.size());
  for (std::size_t a = 0; a < columns.size(); ++a)
    for (std::size_t b = 0; b < columns.size(); ++b)
      block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) =
          normal(columns[a], columns[b]) + (a == b ? 1e-9 * normal(columns[a], columns[a]) : 0.0);
  const Eigen::MatrixXd inverse = block.inverse();
  for (std::size_t a = 0; a < columns.size(); ++a)
    if (columns[a] == column)
      return 1.0 / inverse(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(a));
  return 0.0;
}

}  // namespace trilat
