// SPDX-License-Identifier: MIT
#include "evaluators/fusion/ray_variances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/LU>

#include "datasets/base/error.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

constexpr std::size_t kFewestRayClusters = 5;
constexpr double kUselessFactor = 100.0;  // between the ends of an interval of the ratio

// Sums over one instant's sensors: squared residuals in sigmas, and their degrees of freedom. Of tracked
// joints along the rays and across them, of inferred ones both together.
enum Component { along_rays, across_rays, inferred_joints };
struct Disagreement {
  Eigen::Array3d square = Eigen::Array3d::Zero(), freedom = Eigen::Array3d::Zero();
  void add(const Disagreement& other) {
    square += other.square;
    freedom += other.freedom;
  }
};

struct Instants {
  std::vector<JointObservation> observations;  // inferred ones where they are enough
  std::span<const RigidTransform> rig;
  std::vector<std::uint32_t> cluster;
  std::vector<std::optional<Eigen::Vector3d>> position_m;  // with the sigmas last tried, near the next
  int components = 2;
  std::size_t size() const { return cluster.size(); }
  std::span<const JointObservation> of(std::size_t i) const {
    return std::span(observations).subspan(i * rig.size(), rig.size());
  }
};

Instants useful_instants(std::span<const JointObservation> observations, std::span<const RigidTransform> rig,
                         std::span<const std::uint32_t> cluster) {
  Instants instants{{}, rig, {}, {}};
  const auto inferred = std::ranges::count_if(
      observations, [](const JointObservation& o) { return o.seen && o.state == TrackingState::inferred; });
  if (static_cast<std::size_t>(inferred) >= kFewestInferred) instants.components = 3;
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    std::vector<JointObservation> seen(rig.size());
    std::size_t count = 0;
    for (std::size_t s = 0; s < rig.size(); ++s) {
      const JointObservation& o = observations[i * rig.size() + s];
      if (!o.seen || (o.state != TrackingState::tracked && instants.components == 2)) continue;
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
  std::array<Eigen::Matrix3d, 3> information;
  information.fill(Eigen::Matrix3d::Zero());
  for (std::size_t s = 0; s < rig.size(); ++s) {
    if (!seen[s].seen) continue;
    const Eigen::Vector3d v = estimate.position_m - rig[s].translation_m, e = v.normalized();
    const Eigen::Vector3d u = (seen[s].point_in_world_m - rig[s].translation_m).normalized();
    const Eigen::Vector3d off_m = v - u.dot(v) * u;
    const bool tracked = seen[s].state == TrackingState::tracked;
    const double factor = tracked ? 1.0 : sigma.inferred_factor;
    const double range_m = factor * sigma.range_m, bearing_m = factor * sigma.bearing_m;
    const auto add = [&](Component component, double square, double freedom, const Eigen::Matrix3d& part) {
      const Component where = tracked ? component : inferred_joints;
      result.square[where] += square;
      result.freedom[where] += freedom;
      information[where] += part;
    };
    add(along_rays, std::pow((v.norm() - seen[s].range_m) / range_m, 2), 1.0,
        e * e.transpose() / (range_m * range_m));
    add(across_rays, off_m.squaredNorm() / (bearing_m * bearing_m), 2.0,
        (Eigen::Matrix3d::Identity() - u * u.transpose()) / (bearing_m * bearing_m));
  }
  // what the unknown place takes: 3 in all
  const Eigen::Matrix3d covariance = (information[0] + information[1] + information[2]).inverse();
  for (int c = 0; c < 3; ++c) result.freedom[c] -= (covariance * information[c]).trace();
  return result;
}

// What each component's squares lack of their degrees of freedom, of each cluster: 0 on average at the true
// sigmas.
std::vector<Eigen::Vector3d> scores(Instants& instants, const RaySigma& sigma) {
  std::map<std::uint32_t, Eigen::Vector3d> of_cluster;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const Disagreement d = disagreement_at(instants, i, sigma);
    of_cluster.try_emplace(instants.cluster[i], Eigen::Vector3d::Zero()).first->second +=
        (d.freedom - d.square).matrix();
  }
  std::vector<Eigen::Vector3d> list;
  for (const auto& [cluster, score] : of_cluster) list.push_back(score);
  return list;
}

Eigen::Vector3d sum_of(const std::vector<Eigen::Vector3d>& list) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& one : list) sum += one;
  return sum;
}

// Of inferred joints one factor stands for both of their sigmas, which move with those of tracked ones.
RaySigma scaled(const RaySigma& sigma, const Eigen::Array3d& factor) {
  const double tracked = std::sqrt(factor[along_rays] * factor[across_rays]);
  return {sigma.range_m * factor[along_rays], sigma.bearing_m * factor[across_rays],
          sigma.inferred_factor * factor[inferred_joints] / tracked};
}

// Each variance is scaled by its squares over their freedom until both agree. False without an end.
bool converge(Instants& instants, RaySigma& sigma) {
  constexpr int kMostIterations = 200;
  constexpr double kTolerance = 1e-5;
  for (int k = 0; k < kMostIterations; ++k) {
    Disagreement sum;
    for (std::size_t i = 0; i < instants.size(); ++i) {
      sum.add(disagreement_at(instants, i, sigma));
    }
    const auto used = Eigen::seqN(0, instants.components);
    if (!(sum.square(used).minCoeff() > 0.0) || !(sum.freedom(used).minCoeff() > 0.0)) return false;
    Eigen::Array3d factor = (sum.square / sum.freedom).sqrt();
    if (instants.components == 2) factor[inferred_joints] = std::sqrt(factor[0] * factor[1]);
    sigma = scaled(sigma, factor);
    if ((factor - 1.0).abs().maxCoeff() < kTolerance) return true;
  }
  return false;
}

// Moves one log sigma and leaves the others where they are.
RaySigma moved(RaySigma sigma, int component, double step) {
  if (component == along_rays) sigma.range_m *= std::exp(step);
  if (component == across_rays) sigma.bearing_m *= std::exp(step);
  if (component == inferred_joints) sigma.inferred_factor *= std::exp(step);
  return sigma;
}

// Covariance of log sigma, robust against correlation within clusters.
Eigen::Matrix2d sandwich(Instants& instants, const RaySigma& sigma) {
  constexpr double kStep = 0.01;
  const int count = instants.components;
  Eigen::MatrixXd slope(count, count);
  for (int c = 0; c < count; ++c) {
    const Eigen::Vector3d change =
        sum_of(scores(instants, moved(sigma, c, kStep))) - sum_of(scores(instants, moved(sigma, c, -kStep)));
    slope.col(c) = change.head(count) / (2.0 * kStep);
  }
  const std::vector<Eigen::Vector3d> list = scores(instants, sigma);
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(count, count);
  for (const Eigen::Vector3d& score : list) spread += score.head(count) * score.head(count).transpose();
  const auto clusters = static_cast<double>(list.size());
  const Eigen::MatrixXd inverse = slope.inverse();
  const Eigen::MatrixXd covariance = clusters / (clusters - 1.0) * inverse * spread * inverse.transpose();
  return covariance.topLeftCorner<2, 2>();
}

RayInterval interval(double value, double log_variance, std::size_t clusters) {
  const double reach = student_quantile(clusters - 1) * std::sqrt(log_variance);
  return {value * std::exp(-reach), value * std::exp(reach)};
}

std::size_t clusters_of(std::vector<std::uint32_t> cluster) {
  std::ranges::sort(cluster);
  return static_cast<std::size_t>(std::unique(cluster.begin(), cluster.end()) - cluster.begin());
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
  if (result.clusters < kFewestRayClusters) {
    result.problem = "fewer than " + std::to_string(kFewestRayClusters) +
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

}  // namespace trilat
