// SPDX-License-Identifier: MIT
#include "evaluators/alignment/alignment.h"

#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "datasets/base/error.h"

namespace trilat {
namespace {

void solve_rigid(const AlignmentSums& sums, Alignment& result) {
  if (!sums.cross_m2().allFinite() || !sums.mean_estimate_m().allFinite() ||
      !sums.mean_truth_m().allFinite()) {
    result.status = AlignmentStatus::not_finite;
    return;
  }
  const RotationFit fit = fit_rotation(sums.cross_m2().transpose());
  if (!fit.is_determined) {
    result.status = AlignmentStatus::degenerate;
    return;
  }
  const Eigen::Quaterniond rotation(fit.b_from_a);
  result.truth_from_estimate = {rotation, sums.mean_truth_m() - rotation * sums.mean_estimate_m()};
}

}  // namespace

std::optional<AlignmentKind> alignment_from_name(std::string_view name) {
  for (const auto kind : {AlignmentKind::none, AlignmentKind::first, AlignmentKind::mean,
                          AlignmentKind::rigid, AlignmentKind::held_out, AlignmentKind::joint_offset})
    if (name_of(kind) == name) return kind;
  return std::nullopt;
}

std::string_view name_of(AlignmentStatus status) {
  constexpr std::array<std::string_view, 5> kNames{"not_solved", "aligned", "no_pairs", "not_finite",
                                                   "degenerate"};
  return kNames.at(static_cast<std::size_t>(status));
}

void AlignmentSums::merge(const AlignmentSums& later) {
  if (later.count_ == 0) return;
  if (count_ == 0) {
    *this = later;
    return;
  }
  const auto n = static_cast<double>(later.count_);
  const Eigen::Vector3d estimate_shift_m = later.first_estimate_m_ - first_estimate_m_;
  const Eigen::Vector3d truth_shift_m = later.first_truth_m_ - first_truth_m_;
  products_m2_ += later.products_m2_ + later.estimate_m_ * truth_shift_m.transpose() +
                  estimate_shift_m * (later.truth_m_ + n * truth_shift_m).transpose();
  estimate_m_ += later.estimate_m_ + n * estimate_shift_m;
  truth_m_ += later.truth_m_ + n * truth_shift_m;
  count_ += later.count_;
}

Alignment solve_alignment(const AlignmentSums& sums, AlignmentKind kind) {
  Alignment result;
  result.pairs = sums.count();
  if (sums.count() == 0 && kind != AlignmentKind::none && kind != AlignmentKind::held_out) {
    result.status = AlignmentStatus::no_pairs;
    return result;
  }
  result.status = AlignmentStatus::aligned;
  const auto translate = [&](const Eigen::Vector3d& by_m) {
    result.truth_from_estimate = {Eigen::Quaterniond::Identity(), by_m};
    if (!by_m.allFinite())
      result = {AlignmentStatus::not_finite, Alignment{}.truth_from_estimate, sums.count()};
  };
  switch (kind) {
    case AlignmentKind::none:
    case AlignmentKind::held_out:
      translate(Eigen::Vector3d::Zero());
      break;
    case AlignmentKind::first:
      translate(sums.first_truth_m() - sums.first_estimate_m());
      break;
    case AlignmentKind::mean:
      translate(sums.mean_truth_m() - sums.mean_estimate_m());
      break;
    case AlignmentKind::rigid:
      solve_rigid(sums, result);
      break;
    case AlignmentKind::joint_offset:
      TRILAT_CHECK(false, "a joint's offset is not a transform of the world");
  }
  return result;
}

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
  const RotationFit rotation = fit_rotation(cross);
  const auto rms_m = [&](double trace) {
    return std::sqrt(std::max(0.0, spread_a + spread_b - 2.0 * trace));
  };
  fit.b_from_a = {Eigen::Quaterniond(rotation.b_from_a), mean_b - rotation.b_from_a * mean_a};
  fit.scale = rotation.trace / spread_a;
  fit.rms_m = rms_m(rotation.trace);
  fit.mirrored_rms_m = rms_m(rotation.mirrored_trace);
  return fit;
}

PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b) {
  return fit_points(a, b, std::vector<double>(a.size(), 1.0));
}

RotationFit fit_rotation(const Eigen::Matrix3d& cross) {
  constexpr double kDegenerateRatio = 1e-9;
  RotationFit fit;
  if (!cross.allFinite()) return fit;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d& s = svd.singularValues();
  const double sign = u.determinant() * v.determinant() < 0.0 ? -1.0 : 1.0;
  fit.b_from_a = u * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * v.transpose();
  fit.mirrored_b_from_a = u * Eigen::Vector3d(1.0, 1.0, -sign).asDiagonal() * v.transpose();
  fit.trace = s[0] + s[1] + sign * s[2];
  fit.mirrored_trace = s[0] + s[1] - sign * s[2];
  fit.is_determined = 2.0 * (s[1] + sign * s[2]) > kDegenerateRatio * fit.trace;
  return fit;
}

}  // namespace trilat
