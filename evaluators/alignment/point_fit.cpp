// SPDX-License-Identifier: MIT
#include "evaluators/alignment/point_fit.h"

#include <cmath>
#include <vector>

#include <Eigen/SVD>

#include "datasets/base/error.h"

namespace trilat {

PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b,
                    std::span<const double> weight) {
  TRILAT_CHECK(a.size() == b.size() && a.size() == weight.size(), "points and weights of equal number");
  double sum = 0.0;
  std::size_t count = 0;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  const auto visit = [&](const auto& see) {
    for (std::size_t k = 0; k < a.size(); ++k)
      if (weight[k] > 0.0 && a[k].allFinite() && b[k].allFinite()) see(weight[k], a[k], b[k]);
  };
  visit([&](double w, const Eigen::Vector3d& pa, const Eigen::Vector3d& pb) {
    sum += w;
    ++count;
    mean_a += w * pa;
    mean_b += w * pb;
  });
  PointFit fit;
  if (count < 3) return fit;
  mean_a /= sum;
  mean_b /= sum;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // of b and a
  double spread_a = 0.0, spread_b = 0.0;
  visit([&](double w, const Eigen::Vector3d& pa, const Eigen::Vector3d& pb) {
    cross += w / sum * (pb - mean_b) * (pa - mean_a).transpose();
    spread_a += w / sum * (pa - mean_a).squaredNorm();
    spread_b += w / sum * (pb - mean_b).squaredNorm();
  });
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& s = svd.singularValues();
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  const Eigen::Matrix3d rotation =
      svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  const auto rms_m = [&](double trace) {
    return std::sqrt(std::max(0.0, spread_a + spread_b - 2.0 * trace));
  };
  const double agreement = s[0] + s[1] + sign * s[2];
  fit.b_from_a = {Eigen::Quaterniond(rotation), mean_b - rotation * mean_a};
  fit.scale = agreement / spread_a;
  fit.rms_m = rms_m(agreement);
  fit.mirrored_rms_m = rms_m(s[0] + s[1] - sign * s[2]);
  return fit;
}

PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b) {
  return fit_points(a, b, std::vector<double>(a.size(), 1.0));
}

}  // namespace trilat
