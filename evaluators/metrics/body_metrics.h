// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "evaluators/solvers/point_estimate.h"

namespace trilat {

// Errors of a whole body at one instant: estimates and truths in the same order of joints.
//
// Mean distance of the joints (MPJPE of Ionescu et al. 2014, without any alignment of its own); NaN without
// joints.
double mpjpe_m(std::span<const Eigen::Vector3d> estimate_m, std::span<const Eigen::Vector3d> truth_m);
// The same after the rotation, translation and scale of least squares that lay this instant's estimate over
// its truth, as the field defines it (Umeyama 1991; no mirroring). NaN for fewer than 3 joints, and when
// either lie on a line or in a point: the second singular value of the centred points is not above 1e-6 of
// the first.
double pa_mpjpe_m(std::span<const Eigen::Vector3d> estimate_m, std::span<const Eigen::Vector3d> truth_m);

// Radii of PCK, the share of joints whose error is not above them (Mehta et al. 2017 use 15 cm).
inline constexpr std::array<double, 3> kPckRadii_m{0.05, 0.10, 0.15};

// Standard deviation of a length over time (n - 1), by running means (Welford).
class LengthSpread {
 public:
  void add(double length_m);
  std::int64_t count() const { return count_; }
  double standard_deviation_m() const;  // NaN for fewer than two

 private:
  std::int64_t count_ = 0;
  double mean_m_ = 0.0;
  double squares_m2_ = 0.0;
};

// Jitter is jerk (Flash and Hogan 1985), as Yi et al. (TransPose, 2021) take it: the length of the third
// difference of four positions in a row, times the rate cubed, in m/s^3; its mean over time and joints is
// what is reported. Of the estimate alone: hold it against that of the truth.
double jerk_m_s3(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& c_m,
                 const Eigen::Vector3d& d_m, double rate_hz);

}  // namespace trilat
