// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/units.h"

namespace trilat {

// Every way in which any method ends. Results are born not_solved. Stored as numbers: a new way goes to the
// end.
enum class SolveStatus : std::uint8_t {
  not_solved = 0,
  converged = 1,         // the method's own stop rule held before max_iterations
  closed_form = 2,       // an exact formula, no iteration
  clamped = 3,           // geometric: h^2 < -1e-10 r^2, so the spheres do not meet; h^2 := 0
  iteration_limit = 4,   // iterations = max_iterations and the stop rule never held
  mirror_ambiguous = 5,  // two solutions fit equally well and no guess is < 1/2 as far from one
  rank_deficient = 6,    // directions do not span space; each method states its inequality
  too_few_ranges = 7,    // fewer than 3 ranges, or not all of the sensors the setting names
  non_finite_input = 8,  // a sensor, range, guess or start is NaN or infinite
  invalid_input = 9,     // range < 0
  diverged = 10,         // an iterate or its cost is not finite
  no_observation = 11,   // a baseline: no allowed sensor sees the joint; or nothing is given for it
  given = 12,            // by another method or system
};
inline constexpr int kSolveStatusCount = 13;

std::string_view name_of(SolveStatus status);          // "not_solved", …
const std::vector<std::string>& solve_status_names();  // by number

// Whether the position may be used as an answer: converged, closed_form, clamped or given.
constexpr bool is_usable(SolveStatus status) {
  return status == SolveStatus::converged || status == SolveStatus::closed_form ||
         status == SolveStatus::clamped || status == SolveStatus::given;
}

// Estimate of a joint's position in the world. Ask is_usable(status) before using the position: it is also
// filled for iteration_limit (the last iterate), mirror_ambiguous (one of the two) and for rank_deficient
// when a descent ended there, so that a failure can be looked at, and NaN for every other failure.
struct PointEstimate {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;     // steps tried, of all starts together
  double cost_m2 = kNaN;  // sum of (|x - sensor| - range)^2
  // Geometric dilution of precision at the position, whatever the method: sqrt(trace((U^T U)^-1)), U's rows
  // the unit vectors from the sensors; infinite when they do not span space, NaN without ranges.
  double gdop = kNaN;
  // (U^T U)^-1: times the variance of a range it is the Cramer-Rao bound of unbiased normal ranges. The
  // methods that know variances give the bound itself, in m^2. NaN when gdop is not finite.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Constant(kNaN);
};

inline PointEstimate failed_estimate(SolveStatus status) {
  PointEstimate result;
  result.status = status;
  return result;
}

}  // namespace trilat
