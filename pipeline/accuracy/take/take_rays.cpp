// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_rays.h"

#include <algorithm>
#include <map>

#include "datasets/skeleton/skeleton.h"
#include "evaluators/fusion/ray_variances.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kMostRows = 1000;  // instants of single joints that an estimate looks at
constexpr std::size_t kClusters = 12;    // stretches of time, of equal length

struct Rows {
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> cluster;
};

// Of these joints, at instants first to last.
Rows rows_of(const PlannedTake& planned, const TakeData& data, std::span<const Joint> joints,
             std::size_t first, std::size_t last) {
  Rows rows;
  const std::size_t sensors = planned.world_from_sensor.size(), instants = last - first;
  const std::size_t step = std::max<std::size_t>(1, instants * joints.size() / kMostRows);
  for (std::size_t i = first; i < last; i += step)
    for (const Joint joint : joints) {
      rows.observations.resize(rows.observations.size() + sensors);
      observe_joint(data, i, joint, planned.world_from_sensor, std::span(rows.observations).last(sensors));
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

// Of the joints with these numbers, as they show from instant `first` to `last`.
RaySigma sigma_of(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                  const std::vector<std::size_t>& numbers, std::size_t first, std::size_t last) {
  std::vector<Joint> joints;
  for (const std::size_t j : numbers) joints.push_back(plan.joints[j]);
  const Rows rows = rows_of(planned, data, joints, first, last);
  return estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster).sigma;
}

}  // namespace

RayRow rays_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  const Rows rows = rows_of(planned, data, plan.joints, 0, data.time.size());
  const RaySigmaEstimate rays =
      estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster);
  RayRow row{.take = recorded_id(planned.take), .rows = rays.instants, .problem = rays.problem};
  if (!row.problem.empty()) return row;
  row.range_m = rays.sigma.range_m;
  row.bearing_m = rays.sigma.bearing_m;
  row.ratio = rays.ratio_of();
  row.ratio_low = rays.ratio.low;
  row.ratio_high = rays.ratio.high;
  return row;
}

void estimate_sigmas(const Plan& plan, const PlannedTake& planned, TakeData& data) {
  if (std::ranges::none_of(plan.methods, [](const Method& m) { return m.spec.sigma_is_estimated; })) return;
  const std::size_t half = data.time.size() / 2;
  data.sigma.resize(2 * plan.joints.size());
  const std::vector<std::vector<std::size_t>> groups = joints_by_group(plan);
  parallel_for_index(2 * groups.size(), 1, [&](std::size_t k) {
    const std::vector<std::size_t>& joints = groups[k / 2];
    const bool is_first = k % 2 == 0;  // judged; the other one is looked at
    const RaySigma sigma = is_first ? sigma_of(plan, planned, data, joints, half, data.time.size())
                                    : sigma_of(plan, planned, data, joints, 0, half);
    for (const std::size_t j : joints) data.sigma[2 * j + k % 2] = sigma;
  });
}

}  // namespace trilat
