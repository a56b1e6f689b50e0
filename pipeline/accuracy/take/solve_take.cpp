// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/solve_take.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// Instants that Ceres solves again: it takes a hundred times as long.
constexpr std::uint64_t kCheckedEvery = 8;

constexpr std::uint64_t kBlock = 256;      // instants that are solved together
constexpr std::uint64_t kSideBySide = 16;  // of them by one thread
// Weight of an instant of a windowed method in the progress, where one of all others together counts 1.
constexpr std::uint64_t kBonesWork = 5;

// Observations of the rig during a block, as stated or as corrected: per instant and joint, one a sensor.
struct Observations {
  std::size_t sensors = 0, joints = 0;
  bool is_corrected = false;
  std::vector<JointObservation> values;
  std::span<const JointObservation> of(std::uint64_t instant, std::size_t joint) const {
    return {&values[(instant * joints + joint) * sensors], sensors};
  }
};

void gather(const Plan& plan, const PlannedTake& planned, const PreparedTake& data, const SampleBlock& block,
            Observations& seen) {
  seen.values.resize(block.instants * seen.joints * seen.sensors);
  for (std::uint64_t i = 0; i < block.instants; ++i)
    for (std::size_t j = 0; j < seen.joints; ++j)
      observe_joint(data, planned, seen.is_corrected, block.first_instant + i, plan.joints[j],
                    std::span(seen.values).subspan((i * seen.joints + j) * seen.sensors, seen.sensors));
}

// The instants of a block and their truth.
void begin_block(const Plan& plan, const PreparedTake& data, std::uint64_t first, SampleBlock& block) {
  const std::size_t names = plan.names.size();
  block.reset(first, std::min<std::uint64_t>(kBlock, data.time.size() - first), names, plan.methods.size());
  for (std::uint64_t i = 0; i < block.instants; ++i) {
    block.time_ns[i] = data.time[first + i].ns;
    block.heading_rad[i] = data.heading_rad[first + i];
    for (std::size_t j = 0; j < names; ++j)
      Eigen::Map<Eigen::Vector3d>(&block.truth_m[(i * names + j) * 3]) = data.truth(first + i, j, names);
  }
}

void store(SampleBlock& block, std::size_t slot, const PointEstimate& estimate) {
  for (int axis = 0; axis < 3; ++axis)
    block.estimate_m[slot * 3 + static_cast<std::size_t>(axis)] =
        static_cast<float>(estimate.position_m[axis]);
  block.status[slot] = static_cast<std::uint8_t>(estimate.status);
  block.iterations[slot] = static_cast<std::uint32_t>(std::max(0, estimate.iterations));
  block.cost_m2[slot] = static_cast<float>(estimate.cost_m2);
  block.gdop[slot] = static_cast<float>(estimate.gdop);
  block.sigma_m[slot] = static_cast<float>(std::sqrt(estimate.covariance.trace() / 3.0));
}

// How many sensors see the joint occluded: inferred, or crossed by a limb in front.
std::uint8_t occluded_views(const JointInstant& instant) {
  const auto& crossings = instant.occlusions[static_cast<std::size_t>(OcclusionRule::corrected)];
  std::uint8_t count = 0;
  for (std::size_t s = 0; s < instant.observations.size(); ++s)
    if (instant.observations[s].seen &&
        (instant.observations[s].state == TrackingState::inferred || crossings[s] > 0))
      ++count;
  return count;
}

bool sees(const Observations& seen, const Method& method) {
  return !is_over_time(method) && method.spec.calibration_is_estimated == seen.is_corrected;
}

// Every method that takes instants by themselves, and the rig as it is seen, on a few of them, which are few
// enough to stay in the cache.
void solve_instants(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                    const Observations& seen, std::uint64_t first, std::uint64_t last, SampleBlock& block) {
  const std::vector<RigidTransform>& rig = rig_of(planned, data, seen.is_corrected);
  std::vector<JointInstant> instants;
  instants.reserve((last - first) * plan.joints.size());
  const std::uint64_t first_row = first * plan.joints.size();
  for (std::uint64_t i = first; i < last; ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const auto observations = seen.of(i, j);
      instants.push_back({observations, rig, occlusions_of(data, block.first_instant + i, plan.joints[j]),
                          ranges_of(observations, rig),
                          sigma_at(data, seen.is_corrected, block.first_instant + i, j)});
      const std::uint64_t row = first_row + instants.size() - 1;
      block.ranges[row] = static_cast<std::uint8_t>(instants.back().ranges.count);
      block.occluded[row] = occluded_views(instants.back());
    }
  std::vector<PointEstimate> estimates(instants.size());
  for (std::size_t m = 0; m < plan.methods.size(); ++m) {
    if (!sees(seen, plan.methods[m])) continue;
    evaluate(plan.methods[m], instants, estimates);
    for (std::size_t k = 0; k < estimates.size(); ++k)
      store(block, (first_row + k) * plan.methods.size() + m, estimates[k]);
  }
}

// Beyond this allowance for rounding a lower objective of Ceres counts as one that ours lost.
constexpr double kSameCost = 1.0 + 1e-9, kSameCost_m2 = 1e-15;

TakeCheck cross_check_instant(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                              const Observations& seen, std::uint64_t i, const Method& method,
                              std::uint64_t number) {
  TakeCheck check;
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    const auto observations = seen.of(i, j);
    const SensorMask sensors = sensors_of(
        method, {observations, planned.world_from_sensor, occlusions_of(data, number, plan.joints[j]), {}});
    const RangeProblem ranges = ranges_of(observations, planned.world_from_sensor, sensors);
    const PointEstimate ours = solve_nonlinear(ranges, method.spec.nonlinear);
    CeresOptions same = method.spec.ceres;
    same.range_sigma_m = method.spec.nonlinear.range_sigma_m;
    const PointEstimate theirs = solve_ceres(ranges, same);
    TakeCheck one;
    one.worst_at = fmt::format("{} instant {} {}", planned.take.id, number, name_of(plan.joints[j]));
    if (is_usable(ours.status) && is_usable(theirs.status)) {
      one.samples = 1;
      one.worst_m = (ours.position_m - theirs.position_m).norm();
      one.lost = ours.cost_m2 > theirs.cost_m2 * kSameCost + kSameCost_m2 ? 1 : 0;
    } else if (is_usable(ours.status) != is_usable(theirs.status)) {
      one.disagreements = 1;
      one.disagreed_at = one.worst_at;
    }
    check.merge(one);
  }
  return check;
}

// Puts the part of a path that a block is of into it.
void store_path(const Plan& plan, const MethodTrajectories& paths, SampleBlock& block) {
  for (std::uint64_t i = 0; i < block.instants; ++i)
    for (std::size_t j = 0; j < paths.joints; ++j) {
      const TrajectoryPoint& point = paths.at(block.first_instant + i, j);
      PointEstimate estimate = failed_estimate(point.status);
      estimate.position_m = point.position_m;
      estimate.iterations = point.iterations;
      store(block, (i * paths.joints + j) * plan.methods.size() + paths.method, estimate);
    }
}

// Adds how Ceres compares to `sums`, by checked method.
void solve_block(const Plan& plan, const PlannedTake& planned, const PreparedTake& data, bool cross_check,
                 SampleBlock& block, std::vector<TakeCheck>& sums) {
  const auto checked = cross_check ? checked_methods(plan) : std::vector<const Method*>{};
  const std::uint64_t count = block.instants;
  std::vector<Observations> rigs;
  for (const bool is_corrected : {false, true}) {
    Observations seen{plan.rig.size(), plan.joints.size(), is_corrected, {}};
    if (is_corrected && std::ranges::none_of(plan.methods, [&](const Method& m) { return sees(seen, m); }))
      continue;
    gather(plan, planned, data, block, seen);
    rigs.push_back(std::move(seen));
  }
  std::vector<TakeCheck> checks(checked.size() * count);  // by method and instant
  parallel_for_index((count + kSideBySide - 1) / kSideBySide, 1, [&](std::size_t part) {
    const std::uint64_t from = part * kSideBySide, to = std::min(count, from + kSideBySide);
    for (const Observations& seen : rigs) solve_instants(plan, planned, data, seen, from, to, block);
    for (std::uint64_t i = from; i < to; ++i) {
      if ((block.first_instant + i) % kCheckedEvery != 0) continue;
      for (std::size_t m = 0; m < checked.size(); ++m)
        checks[m * count + i] =
            cross_check_instant(plan, planned, data, rigs.front(), i, *checked[m], block.first_instant + i);
    }
  });
  for (std::size_t k = 0; k < checks.size(); ++k) sums[k / count].merge(checks[k]);
}

bool has_bones(const Method& method) { return method.spec.kind->over_time == solve_bones; }

// All methods that need whole paths, one after the other; those with bones take most memory, so that they
// come before there are paths.
std::vector<MethodTrajectories> solve_over_time(const Plan& plan, const PlannedTake& planned,
                                                const PreparedTake& data, const OverTimeCalls& calls) {
  std::vector<std::int64_t> time_ns;
  for (const HostTime t : data.time) time_ns.push_back(t.ns);
  std::vector<std::size_t> methods;
  for (std::size_t m = 0; m < first_external(plan); ++m)
    if (is_over_time(plan.methods[m])) methods.push_back(m);
  std::ranges::stable_partition(methods, has_bones,
                                [&](std::size_t m) -> const Method& { return plan.methods[m]; });
  std::vector<MethodTrajectories> all;
  for (const std::size_t m : methods) {
    const Method& method = plan.methods[m];
    MethodTrajectories& paths = all.emplace_back(
        m, plan.joints.size(), std::vector<TrajectoryPoint>(time_ns.size() * plan.joints.size()));
    const auto observe = [&](std::size_t instant, Joint joint, std::span<JointObservation> observations) {
      observe_joint(data, planned, method.spec.calibration_is_estimated, instant, joint, observations);
      const SensorMask used = sensors_of(
          method, {observations, planned.world_from_sensor, occlusions_of(data, instant, joint), {}});
      for (std::size_t s = 0; s < observations.size(); ++s)
        if (!used[s]) observations[s] = {};
    };
    method.spec.kind->over_time(method, {time_ns, planned.world_from_sensor.size(), plan.joints, observe},
                                calls, paths);
  }
  return all;
}

}  // namespace

std::vector<const Method*> checked_methods(const Plan& plan) {
  std::vector<const Method*> checked;
  for (const Method& m : plan.methods)
    if ((m.spec.kind->name == "nonlinear" || m.spec.kind->name == "newton") &&
        m.spec.nonlinear.damping == Damping::lm && m.spec.nonlinear.stop == StopRule::step &&
        !m.spec.calibration_is_estimated)
      checked.push_back(&m);
  return checked;
}

std::vector<TakeCheck> solve_take(const Plan& plan, const PlannedTake& planned, const PreparedTake& data,
                                  std::span<const MethodTrajectories> external, bool cross_check,
                                  const RunControl& control,
                                  const std::function<void(const SampleBlock&)>& each) {
  const auto with_bones = static_cast<std::uint64_t>(std::ranges::count_if(plan.methods, has_bones));
  const std::uint64_t total = data.time.size() * (1 + kBonesWork * with_bones);
  std::atomic<std::uint64_t> done{0};
  const auto advance = [&](std::uint64_t work) {
    control.report(static_cast<double>(done += work) / static_cast<double>(total));
  };
  const std::vector<MethodTrajectories> paths = solve_over_time(
      plan, planned, data,
      {[&](std::size_t instants) { advance(kBonesWork * instants); }, [&] { return control.stopped(); }});
  std::vector<TakeCheck> checks(cross_check ? checked_methods(plan).size() : 0);
  SampleBlock block;
  for (std::uint64_t first = 0; first < data.time.size(); first += kBlock) {
    control.check();
    begin_block(plan, data, first, block);
    solve_block(plan, planned, data, cross_check, block, checks);
    for (const MethodTrajectories& path : paths) store_path(plan, path, block);
    for (const MethodTrajectories& path : external) store_path(plan, path, block);
    each(block);
    advance(block.instants);
  }
  return checks;
}

}  // namespace trilat
