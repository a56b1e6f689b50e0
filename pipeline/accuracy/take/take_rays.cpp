// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_rays.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/skeleton/skeleton.h"
#include "evaluators/fusion/ray_variances.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kMostRows = 1000;          // instants of single joints that an estimate looks at
constexpr std::size_t kCorrectionInstants = 30;  // that corrections are found from, of all joints
// Corrections that a user is told: their interval lies beyond these and beyond what the calibration states.
constexpr double kNoticedTurn_rad = 0.0175, kNoticed_m = 0.02, kStatedSigmas = 3.0;
constexpr std::size_t kClusters = 12;  // stretches of time, of equal length

struct Rows {
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> cluster;
};

// Of these joints, at instants first to last.
Rows rows_of(const PlannedTake& planned, const TakeData& data, std::span<const Joint> joints,
             std::size_t first, std::size_t last, bool is_corrected) {
  Rows rows;
  const std::size_t sensors = planned.world_from_sensor.size(), instants = last - first;
  const std::size_t step = std::max<std::size_t>(1, instants * joints.size() / kMostRows);
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

// Of the joints with these numbers, as they show from instant `first` to `last`.
RaySigma sigma_of(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                  const std::vector<std::size_t>& numbers, std::size_t first, std::size_t last,
                  bool is_corrected) {
  std::vector<Joint> joints;
  for (const std::size_t j : numbers) joints.push_back(plan.joints[j]);
  const Rows rows = rows_of(planned, data, joints, first, last, is_corrected);
  return estimate_ray_sigma(rows.observations, rig_of(planned, data, is_corrected), rows.cluster).sigma;
}

// What the calibration states, as root mean square over the sensors, where that is less than the usual: wide
// priors would let the whole rig drift.
CorrectionPriors priors_of(const std::vector<SensorPose>& poses) {
  CorrectionPriors priors;
  const auto set = [&](double& prior, double SensorPose::*sigma) {
    double squares = 0.0;
    for (const SensorPose& pose : poses) squares += pose.*sigma * pose.*sigma;
    if (squares > 0.0) prior = std::min(prior, std::sqrt(squares / static_cast<double>(poses.size())));
  };
  set(priors.turn_rad, &SensorPose::rotation_sigma_rad);
  set(priors.shift_m, &SensorPose::position_sigma_m);
  return priors;
}

}  // namespace

RayRow rays_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  const Rows rows = rows_of(planned, data, plan.joints, 0, data.time.size(), false);
  const RaySigmaEstimate rays =
      estimate_ray_sigma(rows.observations, planned.world_from_sensor, rows.cluster);
  RayRow row{.take = planned.take.id, .rows = rays.instants, .problem = rays.problem};
  if (!row.problem.empty()) return row;
  row.range_m = rays.sigma.range_m;
  row.bearing_m = rays.sigma.bearing_m;
  row.ratio = rays.ratio_of();
  row.ratio_low = rays.ratio.low;
  row.ratio_high = rays.ratio.high;
  return row;
}

void find_corrections(const Plan& plan, const PlannedTake& planned, TakeData& data) {
  if (std::ranges::none_of(plan.methods, [](const Method& m) { return m.spec.calibration_is_estimated; }))
    return;
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

std::vector<CorrectionRow> correction_rows(const Plan& plan, const PlannedTake& planned,
                                           const TakeData& data) {
  std::vector<CorrectionRow> rows;
  for (std::size_t s = 0; s < data.shown.of_sensor.size(); ++s) {
    const CorrectionMagnitudes m = magnitudes_of(data.shown, s);
    rows.push_back({planned.take.id, plan.rig[s], data.shown.problem, m.turn_rad.value, m.turn_rad.low,
                    m.turn_rad.high, m.shift_m.value, m.shift_m.low, m.shift_m.high, m.range_m.value,
                    m.range_m.low, m.range_m.high, planned.poses[s].rotation_sigma_rad,
                    planned.poses[s].position_sigma_m});
  }
  return rows;
}

std::vector<TakeNote> correction_notes(const PlannedTake& planned, const std::vector<CorrectionRow>& rows) {
  std::vector<TakeNote> notes;
  const auto note = [&](std::string text) {
    notes.push_back({planned.take.id, false, planned.take.calibration.string(), std::move(text)});
  };
  if (!rows.empty() && !rows.front().problem.empty())
    note("is taken as it is: the bodies tell nothing of it, since " + rows.front().problem);
  for (const CorrectionRow& row : rows) {
    const auto said = [](double value, const char* unit) {
      return value > 0.0 ? fmt::format("{:.1f} {}", value, unit) : std::string("no uncertainty");
    };
    const auto is_beyond = [](double low, double least, double stated) {
      return low > std::max(least, kStatedSigmas * stated);
    };
    if (is_beyond(row.turned_low_rad, kNoticedTurn_rad, row.stated_turn_rad))
      note(fmt::format(
          "{} is turned by {:.1f} degrees ({:.1f} to {:.1f}) according to the bodies; the calibration states "
          "{}",
          row.sensor, row.turned_rad / kRadPerDegree, row.turned_low_rad / kRadPerDegree,
          row.turned_high_rad / kRadPerDegree, said(row.stated_turn_rad / kRadPerDegree, "degrees")));
    if (is_beyond(row.shifted_low_m, kNoticed_m, row.stated_shift_m))
      note(fmt::format(
          "{} is {:.1f} cm away ({:.1f} to {:.1f}) according to the bodies; the calibration states {}",
          row.sensor, 100.0 * row.shifted_m, 100.0 * row.shifted_low_m, 100.0 * row.shifted_high_m,
          said(100.0 * row.stated_shift_m, "cm")));
    const double too_long_m = row.too_long_m > 0.0 ? row.too_long_low_m : -row.too_long_high_m;
    if (is_beyond(too_long_m, kNoticed_m, 0.0))
      note(fmt::format("{} measures {:.1f} cm too {} ({:.1f} to {:.1f}) by the bodies", row.sensor,
                       100.0 * std::abs(row.too_long_m), row.too_long_m > 0.0 ? "far" : "near",
                       100.0 * too_long_m,
                       100.0 * std::max(std::abs(row.too_long_low_m), std::abs(row.too_long_high_m))));
  }
  return notes;
}

void estimate_sigmas(const Plan& plan, const PlannedTake& planned, TakeData& data) {
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
