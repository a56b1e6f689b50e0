// SPDX-License-Identifier: MIT
#include "evaluators/metrics/body_metrics.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "datasets/base/error.h"

namespace trilat {
namespace {

Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points_m) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points_m) sum += p;
  return sum / static_cast<double>(points_m.size());
}

// Points that span a plane at least have two eigenvalues of their scatter that are not 0.
bool spans_plane(const Eigen::Matrix3d& scatter_m2) {
  // the second elementary symmetric function is s1 s2 + s1 s3 + s2 s3 of the eigenvalues, squares of the
  // singular values
  const double sum = scatter_m2.trace();
  const double pairs = 0.5 * (sum * sum - scatter_m2.squaredNorm());
  constexpr double kLeast = 1e-12;
  return sum > 0.0 && pairs > kLeast * sum * sum;
}

// The rotation R with the largest trace(R^T m), from the singular values.
Eigen::Matrix3d rotation_by_svd(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// The same; where m has full rank and turns no left hand into a right one it is the factor of m's polar
// decomposition, which Newton's iteration finds in a tenth of the time (Higham 1986).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m) {
  constexpr int kMost = 30;
  constexpr double kFullRank = 1e-7, kNear = 0.1, kSettled = 1e-12;
  const double size = m.norm();
  if (!(m.determinant() > kFullRank * size * size * size)) return rotation_by_svd(m);
  Eigen::Matrix3d x = m / size;
  double step = 1.0;
  for (int i = 0; i < kMost; ++i) {
    const Eigen::Matrix3d inverse = x.inverse();
    const double scale = step < kNear ? 1.0 : std::sqrt(inverse.norm() / x.norm());
    const Eigen::Matrix3d next = 0.5 * (scale * x + inverse.transpose() / scale);
    step = (next - x).norm();
    x = next;
    if (step < kSettled) return x;
  }
  return rotation_by_svd(m);
}

}  // namespace

ProcrustesTruth::ProcrustesTruth(std::span<const Eigen::Vector3d> truth_m)
    : centred_m_(truth_m.begin(), truth_m.end()) {
  const Eigen::Vector3d mean_m = mean_of(truth_m);
  Eigen::Matrix3d scatter_m2 = Eigen::Matrix3d::Zero();
  for (Eigen::Vector3d& t : centred_m_) {
    t -= mean_m;
    scatter_m2 += t * t.transpose();
  }
  spans_plane_ = truth_m.size() >= 3 && spans_plane(scatter_m2);
}

double ProcrustesTruth::pa_mpjpe_m(std::span<const Eigen::Vector3d> estimate_m) const {
  TRILAT_CHECK(estimate_m.size() == centred_m_.size(), "every joint has an estimate and a truth");
  if (!spans_plane_) return kNaN;
  const Eigen::Vector3d mean_m = mean_of(estimate_m);
  Eigen::Matrix3d cross_m2 = Eigen::Matrix3d::Zero(), scatter_m2 = cross_m2;
  for (std::size_t j = 0; j < estimate_m.size(); ++j) {
    const Eigen::Vector3d e = estimate_m[j] - mean_m;
    cross_m2 += centred_m_[j] * e.transpose();
    scatter_m2 += e * e.transpose();
  }
  if (!cross_m2.allFinite() || !spans_plane(scatter_m2)) return kNaN;
  const Eigen::Matrix3d rotation = nearest_rotation(cross_m2);
  const double scale = rotation.cwiseProduct(cross_m2).sum() / scatter_m2.trace();
  const Eigen::Matrix3d turned_and_scaled = scale * rotation;
  double sum_m = 0.0;
  for (std::size_t j = 0; j < estimate_m.size(); ++j)
    sum_m += (turned_and_scaled * (estimate_m[j] - mean_m) - centred_m_[j]).norm();
  return sum_m / static_cast<double>(estimate_m.size());
}

double LengthSpread::standard_deviation_m() const {
  const auto n = static_cast<double>(count_);
  return count_ < 2 ? kNaN : std::sqrt(std::max(0.0, squares_m2_ - sum_m_ * sum_m_ / n) / (n - 1.0));
}

}  // namespace trilat
