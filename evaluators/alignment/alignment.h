// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "datasets/base/words.h"
#include "datasets/rig/rigid_transform.h"
#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// How estimates are laid over the truth before errors are taken. first and mean are kept for each joint by
// itself; rigid is one transform for all joints of a method in a take.
enum class AlignmentKind : std::uint8_t {
  none,
  first,  // movement relative to the first pair
  mean,   // movement relative to the mean: the paper's "relative movement"
  rigid,  // rotation and translation of least squares, no scale (Horn 1987)
  // no change, as with none, on the test part of a take alone, from which joint_offset learns nothing
  held_out,
  // Each joint less what its mean error in the body's own frame was in the training part: what is left when a
  // tracker's joint and the markers' are different points of the body.
  joint_offset,
};
template <>
inline constexpr std::array words<AlignmentKind>{"none",  "first",    "mean",
                                                 "rigid", "held_out", "joint_offset"};
// Whether the alignment leaves the training part of a take out.
constexpr bool is_trained(AlignmentKind kind) {
  return kind == AlignmentKind::held_out || kind == AlignmentKind::joint_offset;
}

enum class AlignmentStatus : std::uint8_t {
  not_solved = 0,
  aligned = 1,
  no_pairs = 2,    // nothing was added
  not_finite = 3,  // a point that was added, or a sum, is NaN or infinite
  // rigid: 2 (s_2 + sign(det) s_3) <= 1e-9 (s_1 + s_2 + sign(det) s_3), s the singular values of the
  // cross-covariance: all points on one line, or one point; the rotation is not determined.
  degenerate = 4,
};
inline std::string name_of(AlignmentKind kind) { return word_of(kind); }
std::optional<AlignmentKind> alignment_from_name(std::string_view name);
std::string_view name_of(AlignmentStatus status);

// All that any alignment needs to know of a stream of pairs. Sums are taken from the first pair, so that
// metres far from the origin lose nothing. The result depends on the order of the pairs only by rounding; for
// equal bytes add and merge in a fixed order.
class AlignmentSums {
 public:
  // Without `products` what is added says nothing of a rotation.
  void add(const Eigen::Vector3d& estimate_m, const Eigen::Vector3d& truth_m, bool products = true) {
    if (count_ == 0) {
      first_estimate_m_ = estimate_m;
      first_truth_m_ = truth_m;
    }
    ++count_;
    const Eigen::Vector3d estimate = estimate_m - first_estimate_m_, truth = truth_m - first_truth_m_;
    estimate_m_ += estimate;
    truth_m_ += truth;
    if (products) products_m2_ += estimate * truth.transpose();
  }
  // Adds the samples of `later`.
  void merge(const AlignmentSums& later);

  std::int64_t count() const { return count_; }
  const Eigen::Vector3d& first_estimate_m() const { return first_estimate_m_; }
  const Eigen::Vector3d& first_truth_m() const { return first_truth_m_; }
  // NaN without pairs.
  Eigen::Vector3d mean_estimate_m() const {
    return first_estimate_m_ + estimate_m_ / static_cast<double>(count_);
  }
  Eigen::Vector3d mean_truth_m() const { return first_truth_m_ + truth_m_ / static_cast<double>(count_); }
  // Sum of (estimate - mean)(truth - mean)^T.
  Eigen::Matrix3d cross_m2() const {
    return products_m2_ - estimate_m_ * truth_m_.transpose() / static_cast<double>(count_);
  }

 private:
  std::int64_t count_ = 0;
  Eigen::Vector3d first_estimate_m_ = Eigen::Vector3d::Constant(kNaN);
  Eigen::Vector3d first_truth_m_ = Eigen::Vector3d::Constant(kNaN);
  // Sums of differences from the first pair.
  Eigen::Vector3d estimate_m_ = Eigen::Vector3d::Zero(), truth_m_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products_m2_ = Eigen::Matrix3d::Zero();
};

struct Alignment {
  AlignmentStatus status = AlignmentStatus::not_solved;
  // To be applied to estimates. NaN unless aligned.
  RigidTransform truth_from_estimate{Eigen::Quaterniond(kNaN, kNaN, kNaN, kNaN),
                                     Eigen::Vector3d::Constant(kNaN)};
  std::int64_t pairs = 0;
};

// none and held_out are the identity, and aligned even without pairs. InternalError for joint_offset, which
// is no transform of the world; see JointOffset.
[[nodiscard]] Alignment solve_alignment(const AlignmentSums& sums, AlignmentKind kind);

// The body's own frame stands upright: x to the body's left, y up, z forward. `heading_rad` turns forward
// from world +z towards +x, as in SkeletonPose.
inline Eigen::Matrix3d world_from_body(double heading_rad) {
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  return (Eigen::Matrix3d() << c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c).finished();
}

// The mean error of one joint in the body's own frame: a tracker's joint and the middle of the markers are
// not the same point of the body, and that difference turns with the body.
class JointOffset {
 public:
  void add(const Eigen::Vector3d& estimate_m, const Eigen::Vector3d& truth_m, double heading_rad) {
    ++count_;
    mean_in_body_m_ += (world_from_body(heading_rad).transpose() * (estimate_m - truth_m) - mean_in_body_m_) /
                       static_cast<double>(count_);
  }
  std::int64_t count() const { return count_; }
  // NaN when nothing was added.
  Eigen::Vector3d in_body_m() const { return count_ > 0 ? mean_in_body_m_ : Eigen::Vector3d::Constant(kNaN); }
  Eigen::Vector3d corrected(const Eigen::Vector3d& estimate_m, double heading_rad) const {
    return estimate_m - world_from_body(heading_rad) * in_body_m();
  }

 private:
  std::int64_t count_ = 0;
  Eigen::Vector3d mean_in_body_m_ = Eigen::Vector3d::Zero();
};

// How two weighted sets of points fit each other: least squares of b - (scale R a + t), Umeyama 1991.
struct PointFit {
  RigidTransform b_from_a;       // without the scale: R, and the t of scale 1
  double scale = kNaN;           // of b over a
  double rms_m = kNaN;           // of what the rotation and translation leave, scale 1
  double mirrored_rms_m = kNaN;  // and of what they leave when one set is mirrored first
};

// Points of equal number, in metres; those that are not finite are left out. NaN for fewer than three.
[[nodiscard]] PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b,
                                  std::span<const double> weight);
[[nodiscard]] PointFit fit_points(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b);

// The rotation that lays one set of points over another by least squares: it maximises trace(R^T C) of their
// cross-covariance C (Kabsch 1976; Umeyama 1991). The sum of squares that is left falls by twice that trace.
struct RotationFit {
  // False where 2 (s_2 + sign(det C) s_3) <= 1e-9 (s_1 + s_2 + sign(det C) s_3), s the singular values: all
  // points on one line, or one point. Also where C is not finite; then all else is NaN.
  bool is_determined = false;
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Constant(kNaN);
  double trace = kNaN;  // of b_from_a^T C
  // The best of the rotations that mirror, and its trace.
  Eigen::Matrix3d mirrored_b_from_a = Eigen::Matrix3d::Constant(kNaN);
  double mirrored_trace = kNaN;
};

// `cross`: the sum of (b - mean)(a - mean)^T, weighted or not, or of b a^T.
[[nodiscard]] RotationFit fit_rotation(const Eigen::Matrix3d& cross);

}  // namespace trilat
