// SPDX-License-Identifier: MIT
#include "evaluators/fusion/ray_variances.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/LU>

#include "datasets/base/error.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

constexpr std::size_t kFewestClusters = 5;
constexpr double kUselessFactor = 100.0;  // between the ends of an interval of the ratio

// Sums over one instant's sensors, along the rays and across: squared residuals in sigmas, and their degrees
// of freedom.
struct Disagreement {
  Eigen::Array2d square = Eigen::Array2d::Zero(), freedom = Eigen::Array2d::Zero();
};

struct Instants {
  std::vector<JointObservation> observations;  // tracked ones only
  std::span<const RigidTransform> rig;
  std::vector<std::uint32_t> cluster;
  std::vector<std::optional<Eigen::Vector3d>> position_m;  // with the sigmas last tried, near the next
  std::size_t size() const { return cluster.size(); }
  std::span<const JointObservation> of(std::size_t i) const {
    return std::span(observations).subspan(i * rig.size(), rig.size());
  }
};

Instants useful_instants(std::span<const JointObservation> observations, std::span<const RigidTransform> rig,
                         std::span<const std::uint32_t> cluster) {
  Instants instants{{}, rig, {}, {}};
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    std::vector<JointObservation> seen(rig.size());
    std::size_t count = 0;
    for (std::size_t s = 0; s < rig.size(); ++s) {
      const JointObservation& o = observations[i * rig.size() + s];
      if (!o.seen || o.state != TrackingState::tracked) continue;
      seen[s] = o;
      ++count;
    }
    if (count < 2) continue;
    instants.observations.insert(instants.observations.end(), seen.begin(), seen.end());
    instants.cluster.push_back(cluster[i]);
  }
  instants.position_m.resize(instants.size());
  return instants;
}

Disagreement disagreement_at(Instants& instants, std::size_t i, const RaySigma& sigma) {
  constexpr double kTolerance_m = 1e-6;  // changes squares of centimetres by less than a part in a million
  const std::span<const JointObservation> seen = instants.of(i);
  const std::span<const RigidTransform> rig = instants.rig;
  const PointEstimate estimate = solve_range_bearing(
      seen, rig, {.sigma = sigma, .step_tolerance_m = kTolerance_m, .start_m = instants.position_m[i]});
  Disagreement result;
  if (!is_usable(estimate.status)) return result;
  instants.position_m[i] = estimate.position_m;
  Eigen::Matrix3d along = Eigen::Matrix3d::Zero(), across = along;
  for (std::size_t s = 0; s < rig.size(); ++s) {
    if (!seen[s].seen) continue;
    const Eigen::Vector3d v = estimate.position_m - rig[s].translation_m, e = v.normalized();
    const Eigen::Vector3d u = (seen[s].point_in_world_m - rig[s].translation_m).normalized();
    const Eigen::Vector3d off_m = v - u.dot(v) * u;
    result.square += Eigen::Array2d(std::pow((v.norm() - seen[s].range_m) / sigma.range_m, 2),
                                    off_m.squaredNorm() / (sigma.bearing_m * sigma.bearing_m));
    result.freedom += Eigen::Array2d(1.0, 2.0);
    along += e * e.transpose() / (sigma.range_m * sigma.range_m);
    across += (Eigen::Matrix3d::Identity() - u * u.transpose()) / (sigma.bearing_m * sigma.bearing_m);
  }
  // what the unknown place takes: 3 in all
  const double taken = ((along + across).inverse() * along).trace();
  result.freedom -= Eigen::Array2d(taken, 3.0 - taken);
  return result;
}

// The derivatives of -log likelihood by log sigma, of each cluster.
std::vector<Eigen::Vector2d> scores(Instants& instants, const RaySigma& sigma) {
  std::map<std::uint32_t, Eigen::Vector2d> of_cluster;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const Disagreement d = disagreement_at(instants, i, sigma);
    of_cluster.try_emplace(instants.cluster[i], Eigen::Vector2d::Zero()).first->second +=
        (d.freedom - d.square).matrix();
  }
  std::vector<Eigen::Vector2d> list;
  for (const auto& [cluster, score] : of_cluster) list.push_back(score);
  return list;
}

Eigen::Vector2d sum_of(const std::vector<Eigen::Vector2d>& list) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& one : list) sum += one;
  return sum;
}

RaySigma scaled(const RaySigma& sigma, const Eigen::Array2d& factor) {
  return {sigma.range_m * factor[0], sigma.bearing_m * factor[1]};
}

// Each variance is scaled by its squares over their freedom until both agree. False without an end.
bool converge(Instants& instants, RaySigma& sigma) {
  constexpr int kMostIterations = 200;
  constexpr double kTolerance = 1e-5;
  for (int k = 0; k < kMostIterations; ++k) {
    Disagreement sum;
    for (std::size_t i = 0; i < instants.size(); ++i) {
      const Disagreement d = disagreement_at(instants, i, sigma);
      sum.square += d.square;
      sum.freedom += d.freedom;
    }
    if (!(sum.square.minCoeff() > 0.0) || !(sum.freedom.minCoeff() > 0.0)) return false;
    const Eigen::Array2d factor = (sum.square / sum.freedom).sqrt();
    sigma = scaled(sigma, factor);
    if ((factor - 1.0).abs().maxCoeff() < kTolerance) return true;
  }
  return false;
}

// Covariance of log sigma, robust against correlation within clusters.
Eigen::Matrix2d sandwich(Instants& instants, const RaySigma& sigma) {
  constexpr double kStep = 0.01;
  Eigen::Matrix2d slope;
  for (int c = 0; c < 2; ++c) {
    Eigen::Array2d up = Eigen::Array2d::Ones();
    up[c] = std::exp(kStep);
    slope.col(c) = (sum_of(scores(instants, scaled(sigma, up))) -
                    sum_of(scores(instants, scaled(sigma, up.inverse())))) /
                   (2.0 * kStep);
  }
  const std::vector<Eigen::Vector2d> list = scores(instants, sigma);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& score : list) spread += score * score.transpose();
  const auto clusters = static_cast<double>(list.size());
  const Eigen::Matrix2d inverse = slope.inverse();
  return clusters / (clusters - 1.0) * inverse * spread * inverse.transpose();
}

RayInterval interval(double value, double log_variance, std::size_t clusters) {
  const double reach = student_quantile(clusters - 1) * std::sqrt(log_variance);
  return {value * std::exp(-reach), value * std::exp(reach)};
}

std::size_t clusters_of(std::vector<std::uint32_t> cluster) {
  std::ranges::sort(cluster);
  return static_cast<std::size_t>(std::ranges::unique(cluster).begin() - cluster.begin());
}

}  // namespace

RaySigmaEstimate estimate_ray_sigma(std::span<const JointObservation> observations,
                                    std::span<const RigidTransform> world_from_sensor,
                                    std::span<const std::uint32_t> cluster) {
  TRILAT_CHECK(observations.size() == world_from_sensor.size() * cluster.size(),
               "every instant has an observation of every sensor");
  Instants instants = useful_instants(observations, world_from_sensor, cluster);
  RaySigmaEstimate result;
  result.instants = instants.size();
  result.clusters = clusters_of(instants.cluster);
  if (result.clusters < kFewestClusters) {
    result.problem = "fewer than " + std::to_string(kFewestClusters) +
                     " stretches of time in which two sensors track the joint";
    return result;
  }
  RaySigma sigma;
  if (!converge(instants, sigma)) {
    result.problem =
        "the disagreement of these sensors does not tell errors along their rays from those across";
    return result;
  }
  const Eigen::Matrix2d covariance = sandwich(instants, sigma);
  const double ratio_variance = covariance(0, 0) + covariance(1, 1) - 2.0 * covariance(0, 1);
  const RayInterval ratio = interval(sigma.range_m / sigma.bearing_m, ratio_variance, result.clusters);
  if (!(ratio.high < kUselessFactor * ratio.low)) {
    result.problem = "the ratio could lie anywhere: too little was seen";
    return result;
  }
  result.sigma = sigma;
  result.ratio = ratio;
  result.range_m = interval(sigma.range_m, covariance(0, 0), result.clusters);
  result.bearing_m = interval(sigma.bearing_m, covariance(1, 1), result.clusters);
  return result;
}

PredictedErrors predicted_errors(std::span<const JointObservation> observations,
                                 std::span<const RigidTransform> world_from_sensor, const RaySigma& sigma) {
  const std::size_t sensors = world_from_sensor.size();
  const double range_variance = sigma.range_m * sigma.range_m,
               bearing_variance = sigma.bearing_m * sigma.bearing_m;
  double mean = 0.0, ranges = 0.0, both = 0.0;
  std::size_t instants = 0;
  for (std::size_t i = 0; i + sensors <= observations.size(); i += sensors) {
    const auto seen = observations.subspan(i, sensors);
    const RangeProblem problem = ranges_of(seen, world_from_sensor);
    if (problem.count < 3) continue;
    Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
    for (int s = 0; s < problem.count; ++s) {
      const Eigen::Vector3d e = (*problem.hint_m - problem.sensor_m[s]).normalized();
      directions += e * e.transpose();
    }
    const Eigen::Matrix3d across = problem.count * Eigen::Matrix3d::Identity() - directions;
    mean += (range_variance + 2.0 * bearing_variance) / problem.count;
    ranges += range_variance * directions.inverse().trace();
    both += (directions / range_variance + across / bearing_variance).inverse().trace();
    ++instants;
  }
  if (instants == 0) return {};
  const auto rms_m = [&](double sum) { return std::sqrt(sum / static_cast<double>(instants)); };
  return {rms_m(mean), rms_m(ranges), rms_m(both)};
}

}  // namespace trilat
