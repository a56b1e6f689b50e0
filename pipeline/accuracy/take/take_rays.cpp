// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_rays.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "datasets/rig/skeleton.h"
#include "evaluators/fusion/ray_variances.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxRows = 1000;           // instants of single joints that an estimate looks at
constexpr std::size_t kCorrectionInstants = 30;  // that corrections are found from, of all joints
constexpr std::size_t kClusters = 12;            // stretches of time, of equal length

struct Rows {
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> cluster;
};

// Observations of these joints, at instants first to last.
Rows rows_of(const PlannedTake& planned, const PreparedTake& data, std::span<const Joint> joints,
             std::size_t first, std::size_t last, bool is_corrected) {
  Rows rows;
  const std::size_t sensors = planned.world_from_sensor.size(), instants = last - first;
  const std::size_t step = std::max<std::size_t>(1, instants * joints.size() / kMaxRows);
  for (std::size_t i = first; i < last; i += step)
    for (const Joint joint : joints) {
      rows.observations.resize(rows.observations.size() + sensors);
      observe_joint(data, planned, is_corrected, i, joint, std::span(rows.observations).last(sensors));
      rows.cluster.push_back(static_cast<std::uint32_t>((i - first) * kClusters / instants));
    }
  return rows;
}

// The numbers of the joints that are estimated together: those of a group.
std::vector<std::vector<std::size_t>> joints_by_group(const Plan& plan) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t j = 0; j < plan.joints.size(); ++j) groups[table_group(plan.joints[j])].push_back(j);
  std::vector<std::vector<std::size_t>> list;
  for (auto& [name, joints] : groups) list.push_back(std::move(joints));
  return list;
}

// Sigma that the joints with these numbers show from instant `first` to `last`.
RaySigma sigma_of(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                  const std::vector<std::size_t>& numbers, std::size_t first, std::size_t last,
                  bool is_corrected) {
  std::vector<Joint> joints;
  for (const std::size_t j : numbers) joints.push_back(plan.joints[j]);
  const Rows rows = rows_of(planned, data, joints, first, last, is_corrected);
  return estimate_ray_sigma(rows.observations, rig_of(planned, data, is_corrected), rows.cluster).sigma;
}

// Priors as the calibration states them, root mean square over the sensors, where that is less than the
// usual: wide priors would let the whole rig drift.
PosePriors priors_of(const std::vector<SensorPose>& poses) {
  PosePriors priors;
  const auto set = [&](double& prior, double SensorPose::*sigma) {
    double squares = 0.0;
    for (const SensorPose& pose : poses) squares += pose.*sigma * pose.*sigma;
    if (squares > 0.0) prior = std::min(prior, std::sqrt(squares / static_cast<double>(poses.size())));
  };
  set(priors.rotation_rad, &SensorPose::rotation_sigma_rad);
  set(priors.translation_m, &SensorPose::position_sigma_m);
  return priors;
}

}  // namespace

RayNoiseRow estimate_ray_noise(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  const Rows rows = rows_of(planned, data, plan.joints, 0, data.time.size(), false);
  const RaySigmaEstimate rays =
      estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster);
  RayNoiseRow row{.take = planned.take.id, .rows = rays.instants, .problem = rays.problem};
  if (!row.problem.empty()) return row;
  row.range_m = rays.sigma.range_m;
  row.bearing_m = rays.sigma.bearing_m;
  row.ratio = rays.ratio_of();
  row.ratio_low = rays.ratio.low;
  row.ratio_high = rays.ratio.high;
  return row;
}

bool estimates_calibration(const Plan& plan) {
  return std::ranges::any_of(plan.methods, [](const Method& m) { return m.spec.calibration_is_estimated; });
}

void find_corrections(const PlannedTake& planned, PreparedTake& data) {
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> joints;
  const std::size_t sensors = planned.world_from_sensor.size();
  const std::size_t step = std::max<std::size_t>(1, data.time.size() / kCorrectionInstants);
  for (std::size_t i = 0; i < data.time.size(); i += step)
    for (std::uint32_t j = 0; j < kJointCount; ++j) {
      observations.resize(observations.size() + sensors);
      observe_joint(data, i, static_cast<Joint>(j), planned.world_from_sensor,
                    std::span(observations).last(sensors));
      joints.push_back(j);
    }
  data.shown = self_calibrate(observations, planned.world_from_sensor, joints, priors_of(planned.poses));
  data.corrected_rig.clear();
  for (std::size_t s = 0; s < sensors; ++s)
    data.corrected_rig.push_back(corrected_pose(planned.world_from_sensor[s], data.shown.of_sensor[s]));
}

void estimate_sigmas(const Plan& plan, const PlannedTake& planned, PreparedTake& data) {
  const std::size_t half = data.time.size() / 2;
  const std::vector<std::vector<std::size_t>> groups = joints_by_group(plan);
  for (const bool is_corrected : {false, true}) {
    if (std::ranges::none_of(plan.methods, [&](const Method& m) {
          return m.spec.sigma_is_estimated && m.spec.calibration_is_estimated == is_corrected;
        }))
      continue;
    std::vector<RaySigma>& sigmas = data.sigma[is_corrected];
    sigmas.resize(2 * plan.joints.size());
    parallel_for_index(2 * groups.size(), 1, [&](std::size_t k) {
      const std::vector<std::size_t>& joints = groups[k / 2];
      const bool is_first = k % 2 == 0;  // judged; the other one is looked at
      const RaySigma sigma = sigma_of(plan, planned, data, joints, is_first ? half : 0,
                                      is_first ? data.time.size() : half, is_corrected);
      for (const std::size_t j : joints) sigmas[2 * j + k % 2] = sigma;
    });
  }
}

}  // namespace trilat
