// SPDX-License-Identifier: MIT
#include "evaluators/metrics/body_metrics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "datasets/base/error.h"
#include "evaluators/alignment/alignment.h"

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
  constexpr double kMinValue = 1e-12;
  return sum > 0.0 && pairs > kMinValue * sum * sum;
}

bool spans_plane(std::span<const Eigen::Vector3d> points_m) {
  const Eigen::Vector3d mean_m = mean_of(points_m);
  Eigen::Matrix3d scatter_m2 = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points_m) scatter_m2 += (p - mean_m) * (p - mean_m).transpose();
  return points_m.size() >= 3 && spans_plane(scatter_m2);
}

}  // namespace

ProcrustesTruth::ProcrustesTruth(std::span<const Eigen::Vector3d> truth_m)
    : centred_m_(truth_m.begin(), truth_m.end()), spans_plane_(spans_plane(truth_m)) {
  const Eigen::Vector3d mean_m = mean_of(truth_m);
  for (Eigen::Vector3d& t : centred_m_) t -= mean_m;
}

double ProcrustesTruth::pa_mpjpe_m(std::span<const Eigen::Vector3d> estimate_m) const {
  TRILAT_CHECK(estimate_m.size() == centred_m_.size(), "every joint has an estimate and a truth");
  if (!spans_plane_) return kNaN;
  const auto n = static_cast<double>(estimate_m.size());
  // The truths' sum is 0, so that their products with estimates need no mean of these.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), x = sum, y = sum, z = sum;
  double squares_m2 = 0.0;
  for (std::size_t j = 0; j < estimate_m.size(); ++j) {
    const Eigen::Vector3d e = estimate_m[j] - estimate_m[0];
    sum += e;
    squares_m2 += e.squaredNorm();
    x += e.x() * centred_m_[j];
    y += e.y() * centred_m_[j];
    z += e.z() * centred_m_[j];
  }
  const Eigen::Matrix3d cross_m2 = (Eigen::Matrix3d() << x, y, z).finished();
  if (!cross_m2.allFinite()) return kNaN;
  if (!spans_plane(estimate_m)) return kNaN;
  const RotationFit fit = fit_rotation(cross_m2);
  const double scale = fit.trace / (squares_m2 - sum.squaredNorm() / n);
  const Eigen::Matrix3d turned_and_scaled = scale * fit.b_from_a;
  const Eigen::Vector3d shift_m = turned_and_scaled * (estimate_m[0] + sum / n);
  double sum_m = 0.0;
  for (std::size_t j = 0; j < estimate_m.size(); ++j)
    sum_m += (turned_and_scaled * estimate_m[j] - shift_m - centred_m_[j]).norm();
  return sum_m / n;
}

double LengthSpread::standard_deviation_m() const {
  const auto n = static_cast<double>(count_);
  return count_ < 2 ? kNaN : std::sqrt(std::max(0.0, squares_m2_ - sum_m_ * sum_m_ / n) / (n - 1.0));
}

namespace {

// The angle by atan2, which stays exact for nearly parallel vectors; NaN when one of them is zero.
double angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double across = a.cross(b).norm(), along = a.dot(b);
  return across == 0.0 && along == 0.0 ? std::nan("") : std::atan2(across, along);
}

}  // namespace

double flexion_rad(const Eigen::Vector3d& upper_end, const Eigen::Vector3d& joint,
                   const Eigen::Vector3d& lower_end) {
  return std::numbers::pi - angle_rad(upper_end - joint, lower_end - joint);
}

double inclination_rad(const Eigen::Vector3d& below, const Eigen::Vector3d& above) {
  return angle_rad(above - below, Eigen::Vector3d::UnitY());
}

}  // namespace trilat
