// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// A whole body's truth at one instant, which estimates of the same joints, in the same order, are laid over:
// by the rotation, translation and scale of least squares, as the field defines PA-MPJPE (Umeyama 1991; no
// mirroring).
class ProcrustesTruth {
 public:
  explicit ProcrustesTruth(std::span<const Eigen::Vector3d> truth_m);
  // The mean distance of the joints then. NaN for fewer than 3 joints, and when either lie on a line or in a
  // point: the second singular value of the centred points is not above 1e-6 of the first.
  double pa_mpjpe_m(std::span<const Eigen::Vector3d> estimate_m) const;

 private:
  std::vector<Eigen::Vector3d> centred_m_;
  bool spans_plane_ = false;
};

// Radii of PCK, the share of joints whose error is not above them (Mehta et al. 2017 use 15 cm).
inline constexpr std::array<double, 3> kPckRadii_m{0.05, 0.10, 0.15};

// Standard deviation of a length over time (n - 1). Sums are taken from the first length.
class LengthSpread {
 public:
  void add(double length_m) {
    if (count_++ == 0) first_m_ = length_m;
    const double off_m = length_m - first_m_;
    sum_m_ += off_m;
    squares_m2_ += off_m * off_m;
  }
  std::int64_t count() const { return count_; }
  double standard_deviation_m() const;  // NaN for fewer than two

 private:
  std::int64_t count_ = 0;
  double first_m_ = 0.0, sum_m_ = 0.0, squares_m2_ = 0.0;
};

// Jitter is jerk (Flash and Hogan 1985), as Yi et al. (TransPose, 2021) take it: the length of the third
// difference of four positions in a row, times the rate cubed, in m/s^3; its mean over time and joints is
// what is reported. Of the estimate alone: hold it against that of the truth.
inline double jerk_m_s3(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& c_m,
                        const Eigen::Vector3d& d_m, double rate_hz) {
  return (d_m - 3.0 * c_m + 3.0 * b_m - a_m).norm() * rate_hz * rate_hz * rate_hz;
}

// How far a joint is bent, in radians from 0 (straight) to pi: the angle between the two segments that meet
// in `joint`, with their outer ends, taken from pi. NaN where a point is missing or two coincide.
double flexion_rad(const Eigen::Vector3d& upper_end, const Eigen::Vector3d& joint,
                   const Eigen::Vector3d& lower_end);

// How far the line from `below` to `above` leans from y, in radians from 0 (upright) to pi.
double inclination_rad(const Eigen::Vector3d& below, const Eigen::Vector3d& above);

}  // namespace trilat
