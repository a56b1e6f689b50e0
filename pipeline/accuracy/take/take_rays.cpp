// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_rays.h"

#include <algorithm>

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

RaySigma sigma_of(const PlannedTake& planned, const Rows& rows) {
  return estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster).sigma;
}

// The joints of the plan that are estimated together with this one.
std::vector<Joint> fellows_of(const Plan& plan, Joint joint) {
  std::vector<Joint> fellows;
  std::ranges::copy_if(plan.joints, std::back_inserter(fellows), [&](Joint other) {
    return other == joint || (group_of(joint) && group_of(other) == group_of(joint));
  });
  return fellows;
}

}  // namespace

RayRow rays_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  const Rows rows = rows_of(planned, data, plan.joints, 0, data.time.size());
  const RaySigmaEstimate rays =
      estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster);
  RayRow row{.take = planned.take.id, .rows = rays.instants, .problem = rays.problem};
  if (!row.problem.empty()) return row;
  row.range_m = rays.sigma.range_m;
  row.bearing_m = rays.sigma.bearing_m;
  row.ratio = rays.ratio_of();
  row.ratio_low = rays.ratio.low;
  row.ratio_high = rays.ratio.high;
  const PredictedErrors errors = predicted_errors(rows.observations, planned.world_from_sensor, rays.sigma);
  row.mean_m = errors.mean_m;
  row.ranges_m = errors.ranges_m;
  row.range_bearing_m = errors.range_bearing_m;
  return row;
}

void estimate_sigmas(const Plan& plan, const PlannedTake& planned, TakeData& data) {
  if (std::ranges::none_of(plan.methods, [](const Method& m) { return m.spec.sigma_is_estimated; })) return;
  const std::size_t half = data.time.size() / 2;
  data.sigma.resize(2 * plan.joints.size());
  parallel_for_index(data.sigma.size(), 1, [&](std::size_t k) {
    const std::vector<Joint> joints = fellows_of(plan, plan.joints[k / 2]);
    const bool is_first = k % 2 == 0;  // judged; the other one is looked at
    data.sigma[k] = sigma_of(planned, is_first ? rows_of(planned, data, joints, half, data.time.size())
                                               : rows_of(planned, data, joints, 0, half));
  });
}

}  // namespace trilat
