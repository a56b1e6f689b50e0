// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "evaluators/solvers/descent.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

// How a problem's sensors stand: their middle, the plane that fits them best, and their scatter along and
// across it. A point and its mirror image in a plane that holds every sensor have the same ranges, so no
// method can tell them apart.
struct SensorPlane {
  Eigen::Vector3d centroid_m = Eigen::Vector3d::Zero();
  // Columns: the eigenvectors of sum (s - centroid)(s - centroid)^T, and its eigenvalues, ascending.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d scatter_m2 = Eigen::Vector3d::Zero();
  // Second eigenvalue of the scatter <= 1e-12 of the largest: on one line within 1e-6 of their spread.
  // The solutions are a circle around the line.
  bool collinear = false;
  // Three sensors; or none farther from the plane than 1e-12 of the root of the largest eigenvalue. Then the
  // ranges on both sides agree to rounding.
  bool exact = false;

  Eigen::Vector3d normal() const { return axes.col(0); }
  double offset_m(const Eigen::Vector3d& x_m) const { return normal().dot(x_m - centroid_m); }
  Eigen::Vector3d mirrored(const Eigen::Vector3d& x_m) const { return x_m - 2.0 * offset_m(x_m) * normal(); }
};

SensorPlane plane_of(const RangeProblem& problem);

// Whether both problems have the same sensors in the same order, and so the same plane.
bool same_sensors(const RangeProblem& a, const RangeProblem& b);
// An order of problems by their sensors, in which those with the same follow each other.
bool sensors_before(const RangeProblem& a, const RangeProblem& b);

// Standard deviation of a range where nothing better is known: joints of a Kinect v2 are 5
// to 10 cm off in all (Wang et al. 2015, arXiv 1512.04134), which is 3 to 6 cm along a ray.
inline constexpr double kUsualRangeSigma_m = 0.05;

// Whether ranges tell two solutions apart whose costs, sum (|x - s| - r)^2, differ by this much: one has to
// be 100 times as likely as the other, for normal errors of standard deviation range_sigma_m.
inline bool ranges_decide(double cost_difference_m2, double range_sigma_m) {
  constexpr double kTwiceLogOdds = 9.210340371976184;  // 2 ln 100
  return cost_difference_m2 > kTwiceLogOdds * range_sigma_m * range_sigma_m;
}

// Two solutions that fit equally well, and which of them is meant. A guess decides when it is less than half
// as far from one as from the other; otherwise the choice is ambiguous, and `first` tells the nearer one (the
// first, without a guess).
struct MirrorChoice {
  bool first = true;
  bool decided = false;
};

inline MirrorChoice choose_mirror(const Eigen::Vector3d& first_m, const Eigen::Vector3d& second_m,
                                  const std::optional<Eigen::Vector3d>& guess_m) {
  if (!guess_m) return {};
  const double to_first_m = (*guess_m - first_m).norm();
  const double to_second_m = (*guess_m - second_m).norm();
  return {to_first_m <= to_second_m, to_first_m < 0.5 * to_second_m || to_second_m < 0.5 * to_first_m};
}

// Minima nearer than this are one.
inline constexpr double kSameMinimum_m = 1e-6;

// A start for a descent of full rank: finite and no farther from the sensors' middle than twice their mean
// range and spread, else solve_squared_ranges(); and at least a tenth of the mean range off the plane,
// where the derivative across it vanishes.
Eigen::Vector3d plausible_start(const RangeProblem& problem, const SensorPlane& plane,
                                const Eigen::Vector3d& wanted_m);

// Chooses between two descents. When ranges_decide(), or both ended on one side of the sensors' plane, the
// lower cost wins, else choose_mirror() decides, and without a decision the status is mirror_ambiguous, of
// the lower one. A range_sigma_m of 0 leaves to the guess only costs that are equal but for rounding. The
// iterations of both are added.
Descent choose_minimum(const RangeProblem& problem, const SensorPlane& plane, const Descent& first,
                       const Descent& second, double range_sigma_m);

// The other minimum of a problem whose sensors are exactly in one plane.
inline Descent mirrored(const SensorPlane& plane, Descent descent) {
  descent.position_m = plane.mirrored(descent.position_m);
  descent.iterations = 0;
  return descent;
}

// Descends on both sides of the sensors' plane. `descend(start_m)` returns a Descent.
template <class Descend>
Descent descend_on_both_sides(const RangeProblem& problem, const SensorPlane& plane,
                              const Eigen::Vector3d& start_m, double range_sigma_m, const Descend& descend) {
  const Descent first = descend(start_m);
  const Descent second = plane.exact ? mirrored(plane, first) : descend(plane.mirrored(start_m));
  return choose_minimum(problem, plane, first, second, range_sigma_m);
}

// The exact global minimum of sum (|x - s|^2 - r^2)^2, for any number of sensors from three on and also when
// they stand in one plane (Beck, Stoica and Li, "Exact and approximate solutions of source localization
// problems", IEEE Trans. Signal Processing 56(5), 2008: a quadratic problem with one quadratic constraint,
// whose multiplier is the one root of a decreasing function). With x = centroid + axes y and multiplier mu it
// is y_j = c_j / (4 scatter_j + mu). When the sensors stand in one plane there are two, mirror images of each
// other; this is the one on the side of the plane's normal. `plane` is that of the
// problem, not collinear.
Eigen::Vector3d solve_squared_ranges(const RangeProblem& problem, const SensorPlane& plane);

}  // namespace trilat
