// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace trilat {

// Where a point was over time: times rise, positions are NaN where it was not seen.
struct PointPath {
  std::vector<double> time_s;
  std::vector<Eigen::Vector3d> position_m;
};

struct LocalMotion {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
};

// The straight line of weighted least squares through the samples about `time_s`, with weights of a Gaussian
// of `sigma_s` that ends at three sigma: the same smoothing in seconds whatever the rate of the path. Nothing
// where the samples do not cover the time: fewer than three, none on one side, or a hole wider than
// `longest_gap_s` or, if that is more, 1.5 sigma.
std::optional<LocalMotion> local_motion(const PointPath& path, double time_s, double sigma_s,
                                        double longest_gap_s);

}  // namespace trilat
