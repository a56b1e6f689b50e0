// SPDX-License-Identifier: MIT
#include "evaluators/fusion/ray_variances.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/LU>

#include "datasets/base/error.h"
#include "evaluators/metrics/statistics.h"
#include "evaluators/solvers/descent.h"

namespace trilat {
namespace {

constexpr std::size_t kMinRayClusters = 5;
constexpr double kUselessFactor = 100.0;  // between the ends of an interval of the ratio
constexpr double kMinSigma_m = 1e-4;

// Components of variance: tracked joints along and across the rays, inferred ones in both together.
enum Component { along_rays, across_rays, inferred_joints };

// Sums over sensors: squared residuals in sigmas, and their degrees of freedom.
struct VarianceSums {
  Eigen::Array3d square = Eigen::Array3d::Zero(), freedom = Eigen::Array3d::Zero();
};

Eigen::Vector3d ray_of(const RayViews& row, const RigidTransform& pose) {
  const Eigen::Vector3d v = row.position_m - pose.translation_m;
  return v / std::max(v.norm(), kOnSensor_m);
}

double range_variance(const RaySigma& sigma, bool inferred) {
  return std::pow((inferred ? sigma.inferred_factor : 1.0) * sigma.range_m, 2);
}
double bearing_variance(const RaySigma& sigma, bool inferred) {
  return std::pow((inferred ? sigma.inferred_factor : 1.0) * sigma.bearing_m, 2);
}

// Adds the disagreement of one placed row. Its unknown place takes 3 degrees of freedom in all.
void add_disagreement(const RayViews& row, std::span<const RigidTransform> rig, const RaySigma& sigma,
                      VarianceSums& sum) {
  const double trace = row.covariance.trace();
  for (const RayView& view : row.views) {
    const Eigen::Vector3d u = ray_of(row, rig[view.sensor]), e = view.linearised_point_m - row.position_m;
    const double range2 = range_variance(sigma, view.inferred);
    const double bearing2 = bearing_variance(sigma, view.inferred);
    const double along2 = std::pow(e.dot(u), 2), across2 = std::max(0.0, e.squaredNorm() - along2);
    const double place_along2 = u.dot(row.covariance * u);
    const Component along = view.inferred ? inferred_joints : along_rays;
    const Component across = view.inferred ? inferred_joints : across_rays;
    sum.square[along] += along2 / range2;
    sum.square[across] += across2 / bearing2;
    sum.freedom[along] += 1.0 - place_along2 / range2;
    sum.freedom[across] += 2.0 - (trace - place_along2) / bearing2;
  }
}

// Score of each variance component by cluster: degrees of freedom less squares, 0 on average at the true
// sigmas.
std::vector<Eigen::Vector3d> scores(RayRows& rows, std::span<const RigidTransform> rig,
                                    const RaySigma& sigma) {
  constexpr int kPlacings = 3;
  std::map<std::uint32_t, VarianceSums> of_cluster;
  for (RayViews& row : rows.rows) {
    for (int k = 0; k < kPlacings; ++k) place(row, rig, sigma);
    add_disagreement(row, rig, sigma, of_cluster[row.cluster]);
  }
  std::vector<Eigen::Vector3d> list;
  for (const auto& [cluster, d] : of_cluster) list.emplace_back((d.freedom - d.square).matrix());
  return list;
}

Eigen::Vector3d sum_of(const std::vector<Eigen::Vector3d>& list) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& one : list) sum += one;
  return sum;
}

// Moves one log sigma and leaves the others where they are.
RaySigma moved(RaySigma sigma, int component, double step) {
  if (component == along_rays) sigma.range_m *= std::exp(step);
  if (component == across_rays) sigma.bearing_m *= std::exp(step);
  if (component == inferred_joints) sigma.inferred_factor *= std::exp(step);
  return sigma;
}

// Covariance of log sigma, robust against correlation within clusters.
Eigen::Matrix2d sandwich(RayRows& rows, std::span<const RigidTransform> rig, const RaySigma& sigma) {
  constexpr double kStep = 0.01;
  const int count = rows.with_inferred ? 3 : 2;
  Eigen::MatrixXd slope(count, count);
  for (int c = 0; c < count; ++c) {
    const Eigen::Vector3d change = sum_of(scores(rows, rig, moved(sigma, c, kStep))) -
                                   sum_of(scores(rows, rig, moved(sigma, c, -kStep)));
    slope.col(c) = change.head(count) / (2.0 * kStep);
  }
  const std::vector<Eigen::Vector3d> list = scores(rows, rig, sigma);
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

std::size_t clusters_of(const RayRows& rows) {
  std::vector<std::uint32_t> clusters;
  for (const RayViews& row : rows.rows) clusters.push_back(row.cluster);
  std::ranges::sort(clusters);
  return static_cast<std::size_t>(std::unique(clusters.begin(), clusters.end()) - clusters.begin());
}

}  // namespace

RayRows ray_rows(std::span<const JointObservation> observations, std::size_t sensors,
                 std::span<const std::uint32_t> cluster) {
  TRILAT_CHECK(observations.size() == sensors * cluster.size() && sensors <= kMaxSensors,
               "every row has an observation of every sensor");
  const auto inferred = std::ranges::count_if(
      observations, [](const JointObservation& o) { return o.seen && o.state == TrackingState::inferred; });
  RayRows result{{}, static_cast<std::size_t>(inferred) >= kMinInferred};
  for (std::size_t i = 0; i < cluster.size(); ++i) {
    RayViews row{.cluster = cluster[i], .views = {}};
    for (std::size_t s = 0; s < sensors; ++s) {
      const JointObservation& o = observations[i * sensors + s];
      const bool is_inferred = o.state == TrackingState::inferred;
      if (!o.seen || !(o.range_m > kOnSensor_m) || (is_inferred && !result.with_inferred)) continue;
      row.views.push_back({s, is_inferred, o.point_in_world_m, o.point_in_world_m, {}});
      row.position_m += o.point_in_world_m;
    }
    if (row.views.size() < 2) continue;
    row.position_m /= static_cast<double>(row.views.size());
    result.rows.push_back(std::move(row));
  }
  return result;
}

void place(RayViews& row, std::span<const RigidTransform> rig, const RaySigma& sigma) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (RayView& view : row.views) {
    const Eigen::Vector3d u = ray_of(row, rig[view.sensor]);
    const double along = 1.0 / range_variance(sigma, view.inferred);
    const double across = 1.0 / bearing_variance(sigma, view.inferred);
    view.weight = across * Eigen::Matrix3d::Identity() + (along - across) * u * u.transpose();
    const Eigen::Vector3d v = view.point_m - rig[view.sensor].translation_m;
    view.linearised_point_m = view.point_m + (v.norm() - v.dot(u)) * u;
    information += view.weight;
    right += view.weight * view.linearised_point_m;
  }
  row.covariance = information.inverse();
  row.position_m = row.covariance * right;
}

// Inferred joints have the tracked sigmas times one factor.
bool converge(RayRows& rows, std::span<const RigidTransform> rig, double tolerance, int most_rounds,
              RaySigma& sigma) {
  for (int k = 0; k < most_rounds; ++k) {
    VarianceSums sum;
    for (RayViews& row : rows.rows) {
      place(row, rig, sigma);
      add_disagreement(row, rig, sigma, sum);
    }
    Eigen::Array3d factor = (sum.square / sum.freedom.max(1e-9)).sqrt();
    const double tracked = std::sqrt(factor[along_rays] * factor[across_rays]);
    if (!rows.with_inferred) factor[inferred_joints] = tracked;
    sigma.range_m = std::max(kMinSigma_m, sigma.range_m * factor[along_rays]);
    sigma.bearing_m = std::max(kMinSigma_m, sigma.bearing_m * factor[across_rays]);
    sigma.inferred_factor =
        std::clamp(sigma.inferred_factor * factor[inferred_joints] / std::max(tracked, 1e-9), 0.2, 50.0);
    if ((factor - 1.0).abs().maxCoeff() < tolerance) return true;
  }
  return false;
}

RaySigmaEstimate estimate_ray_sigma(std::span<const JointObservation> observations,
                                    std::span<const RigidTransform> world_from_sensor,
                                    std::span<const std::uint32_t> cluster) {
  constexpr double kTolerance = 1e-4;  // of sigma, whose interval is a hundred times as wide
  constexpr int kMaxRounds = 200;
  RayRows rows = ray_rows(observations, world_from_sensor.size(), cluster);
  RaySigmaEstimate result;
  result.instants = rows.rows.size();
  result.clusters = clusters_of(rows);
  if (result.clusters < kMinRayClusters) {
    result.problem = "fewer than " + std::to_string(kMinRayClusters) +
                     " stretches of time in which two sensors track the joint";
    return result;
  }
  RaySigma sigma;
  if (!converge(rows, world_from_sensor, kTolerance, kMaxRounds, sigma)) {
    result.problem =
        "the disagreement of these sensors does not tell errors along their rays from those across";
    return result;
  }
  const Eigen::Matrix2d covariance = sandwich(rows, world_from_sensor, sigma);
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
