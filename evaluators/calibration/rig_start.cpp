// SPDX-License-Identifier: MIT
#include "evaluators/calibration/rig_start.h"

#include <algorithm>
#include <optional>

#include <Eigen/Eigenvalues>

#include "datasets/base/philox.h"
#include "evaluators/alignment/alignment.h"

namespace trilat {
namespace {

struct CommonPoint {
  Eigen::Vector3d from_m, to_m;
};

using PointsOfSensor = std::vector<std::vector<std::pair<std::size_t, Eigen::Vector3d>>>;

PointsOfSensor points_by_sensor(const RigProblem& problem) {
  PointsOfSensor points(problem.sensors);
  for (const PointObservation& o : problem.observations)
    points[o.sensor].emplace_back(o.point, o.point_in_sensor_m);
  for (auto& list : points)
    std::ranges::sort(list, [](const auto& a, const auto& b) { return a.first < b.first; });
  return points;
}

std::vector<CommonPoint> correspondences(const PointsOfSensor& points, std::size_t from, std::size_t to) {
  std::vector<CommonPoint> common;
  for (std::size_t i = 0, k = 0; i < points[from].size() && k < points[to].size();) {
    if (points[from][i].first == points[to][k].first)
      common.push_back({points[from][i++].second, points[to][k++].second});
    else if (points[from][i].first < points[to][k].first)
      ++i;
    else
      ++k;
  }
  return common;
}

std::optional<RigidTransform> rigid_fit(const std::vector<CommonPoint>& points) {
  AlignmentSums sums;
  for (const CommonPoint& p : points) sums.add(p.from_m, p.to_m);
  const Alignment fit = solve_alignment(sums, AlignmentKind::rigid);
  if (fit.status != AlignmentStatus::aligned) return std::nullopt;
  return fit.truth_from_estimate;
}

std::vector<CommonPoint> inliers(const std::vector<CommonPoint>& points, const RigidTransform& to_from,
                                 double tolerance_m) {
  std::vector<CommonPoint> result;
  for (const CommonPoint& p : points)
    if ((to_from * p.from_m - p.to_m).norm() <= tolerance_m) result.push_back(p);
  return result;
}

// Root mean square spread in the second widest direction.
double second_extent_m(const std::vector<CommonPoint>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const CommonPoint& p : points) mean += p.from_m / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const CommonPoint& p : points)
    scatter += (p.from_m - mean) * (p.from_m - mean).transpose() / static_cast<double>(points.size());
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()[1]));
}

struct PairFit {
  SensorPlacement placement = SensorPlacement::no_common_view;
  RigidTransform to_from_from;
  std::size_t inlier_count = 0;
};

PairFit fit_pair(const std::vector<CommonPoint>& points, std::uint64_t pair, const RigStartOptions& options) {
  PairFit best;
  if (points.size() < 3) return best;
  best.placement = SensorPlacement::points_on_line;
  if (second_extent_m(points) < options.least_breadth_m) return best;
  best.placement = SensorPlacement::disagrees;
  const RandomStream random{0, Purpose::calibration_trial, pair};
  std::vector<CommonPoint> best_points;
  for (int attempt = 0; attempt < options.tries; ++attempt) {
    std::vector<CommonPoint> triple;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const double draw = random.uniform(static_cast<std::uint32_t>(attempt) * 3 + k);
      triple.push_back(points[static_cast<std::size_t>(draw * static_cast<double>(points.size()))]);
    }
    const auto fit = rigid_fit(triple);
    if (!fit) continue;
    auto inlier_count = inliers(points, *fit, options.tolerance_m);
    if (inlier_count.size() > best_points.size()) best_points = std::move(inlier_count);
  }
  for (int round = 0; round < 3 && best_points.size() >= 3; ++round) {
    const auto fit = rigid_fit(best_points);
    if (!fit) break;
    best.to_from_from = *fit;
    best_points = inliers(points, *fit, options.tolerance_m);
    best.inlier_count = best_points.size();
    best.placement = SensorPlacement::placed;
  }
  if (best.placement == SensorPlacement::placed &&
      (best.inlier_count < 3 || second_extent_m(best_points) < options.least_breadth_m))
    best.placement = best.inlier_count < 3 ? SensorPlacement::disagrees : SensorPlacement::points_on_line;
  return best;
}

}  // namespace

bool RigStart::complete() const {
  return std::ranges::all_of(placement, [](SensorPlacement p) { return p == SensorPlacement::placed; });
}

RigStart initial_poses(const RigProblem& problem, const RigStartOptions& options) {
  const PointsOfSensor points = points_by_sensor(problem);
  RigStart start;
  start.placement.assign(problem.sensors, SensorPlacement::no_common_view);
  start.reference_from_sensor.resize(problem.sensors);
  for (std::size_t s = 0; s < problem.sensors; ++s) {
    if (points[s].empty()) start.placement[s] = SensorPlacement::nothing_seen;
    if (points[s].size() > points[start.reference].size()) start.reference = s;
  }
  if (problem.sensors == 0 || points[start.reference].empty()) return start;
  start.placement[start.reference] = SensorPlacement::placed;
  std::vector<std::vector<PairFit>> fits(problem.sensors, std::vector<PairFit>(problem.sensors));
  for (std::size_t from = 0; from < problem.sensors; ++from)
    for (std::size_t to = 0; to < problem.sensors; ++to)
      if (from != to)
        fits[from][to] = fit_pair(correspondences(points, from, to), from * problem.sensors + to, options);
  for (;;) {
    const PairFit* best = nullptr;
    std::size_t best_from = 0, best_to = 0;
    for (std::size_t from = 0; from < problem.sensors; ++from)
      for (std::size_t to = 0; to < problem.sensors; ++to) {
        if (start.placement[from] == SensorPlacement::placed || points[from].empty() ||
            start.placement[to] != SensorPlacement::placed)
          continue;
        const PairFit& fit = fits[from][to];
        if (fit.placement == SensorPlacement::placed && (!best || fit.inlier_count > best->inlier_count)) {
          best = &fit;
          best_from = from;
          best_to = to;
        } else if (fit.placement > start.placement[from]) {
          start.placement[from] = fit.placement;  // the reason that came closest to a fit
        }
      }
    if (!best) return start;
    start.placement[best_from] = SensorPlacement::placed;
    start.reference_from_sensor[best_from] = start.reference_from_sensor[best_to] * best->to_from_from;
  }
}

}  // namespace trilat
