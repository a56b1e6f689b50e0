// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "datasets/base/words.h"
#include "evaluators/bodies/occlusion.h"
#include "evaluators/fusion/bone_smoother.h"
#include "evaluators/fusion/kalman.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

using Sets = std::vector<std::vector<std::size_t>>;

// Empty when there are more than `most`.
Sets all_sets(std::size_t sensors, std::size_t size, std::size_t most) {
  std::vector<bool> chosen(sensors, false);
  std::fill_n(chosen.begin(), size, true);
  Sets sets;
  do {
    if (sets.size() == most) return {};
    sets.emplace_back();
    for (std::size_t s = 0; s < sensors; ++s)
      if (chosen[s]) sets.back().push_back(s);
  } while (std::prev_permutation(chosen.begin(), chosen.end()));
  return sets;
}

// Fisher and Yates' shuffle.
std::vector<std::size_t> random_order(std::size_t sensors, std::uint32_t number) {
  std::vector<std::size_t> order(sensors);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t left = sensors; left > 1; --left) {
    const std::uint32_t bits = philox4x32_10({number, static_cast<std::uint32_t>(left), 0, 0}, {0, 0})[0];
    std::swap(order[left - 1], order[bits % left]);
  }
  return order;
}

}  // namespace

std::vector<std::vector<std::size_t>> sensor_sets(std::size_t sensors, std::size_t size, std::size_t most) {
  Sets sets = all_sets(sensors, size, most);
  if (!sets.empty()) return sets;
  for (std::uint32_t number = 0; sets.size() < most; ++number) {
    std::vector<std::size_t> set = random_order(sensors, number);
    set.resize(size);
    std::ranges::sort(set);
    if (std::ranges::find(sets, set) == sets.end()) sets.push_back(std::move(set));
  }
  return sets;
}

namespace {

int rig_index(const std::string& sensor, const std::vector<std::string>& rig, const std::string& method) {
  const auto found = std::ranges::find(rig, sensor);
  if (found != rig.end()) return static_cast<int>(found - rig.begin());
  std::string known;
  for (const std::string& name : rig) known += (known.empty() ? "" : ", ") + name;
  throw InputError("method \"" + method + '"', "names the sensor \"" + sensor + "\"; the rig has " + known);
}

Method resolve(const MethodSpec& spec, const std::vector<std::string>& rig) {
  Method method;
  method.spec = spec;
  std::vector<int> indices;
  for (const std::string& sensor : spec.sensors) indices.push_back(rig_index(sensor, rig, spec.name));
  if (!indices.empty()) {
    method.allowed.reset();
    for (int i : indices) method.allowed.set(static_cast<std::size_t>(i));
  }
  if (!spec.reference.empty())
    method.spec.linear.reference_sensor = rig_index(spec.reference, rig, spec.name);
  method.sensors = std::move(indices);
  const std::size_t used = spec.kind->sensors;
  if (used == 0) return method;
  if (used == 1 && method.sensors.size() != 1)
    throw InputError(
        "method \"" + spec.name + '"',
        fmt::format("of kind {} uses one sensor, or names none for each in turn", spec.kind->name));
  if (method.sensors.empty())
    for (std::size_t s = 0; s < used; ++s) method.sensors.push_back(static_cast<int>(s));
  method.allowed.reset();  // nothing of the other sensors, not even through the guess
  for (int i : method.sensors) method.allowed.set(static_cast<std::size_t>(i));
  return method;
}

// The methods of one entry of the study: itself, or one for each set of sensors.
std::vector<MethodSpec> expand_sensor_sets(const MethodSpec& spec, const std::vector<std::string>& rig) {
  const bool is_each_single = spec.kind->sensors == 1 && spec.sensors.empty();
  const std::size_t size = is_each_single ? 1 : spec.each;
  if (size == 0) return {spec};
  const std::vector<std::string>& pool = spec.sensors.empty() ? rig : spec.sensors;
  if (size > pool.size())
    throw InputError("method \"" + spec.name + '"',
                     fmt::format("asks for sets of {} of {} sensors", size, pool.size()));
  std::vector<MethodSpec> methods;
  const auto sets = sensor_sets(pool.size(), size, spec.most_sets);
  for (const std::vector<std::size_t>& set : sets) {
    MethodSpec one = spec;
    one.family = spec.name;
    one.sensors.clear();
    std::string names;
    for (const std::size_t s : set) {
      one.sensors.push_back(pool[s]);
      names += (names.empty() ? "" : "+") + pool[s];
    }
    if (sets.size() > 1 || is_each_single) one.name = spec.name + " " + names;
    methods.push_back(std::move(one));
  }
  return methods;
}

}  // namespace

std::vector<Method> resolve_methods(const StudySpec& spec, const std::vector<std::string>& rig) {
  std::vector<Method> methods;
  for (const MethodSpec& m : spec.methods)
    for (const MethodSpec& one : expand_sensor_sets(m, rig)) methods.push_back(resolve(one, rig));
  std::vector<std::string> names;
  for (const Method& method : methods) names.push_back(method.spec.name);
  if (const std::string twice = first_duplicate(names); !twice.empty())
    throw InputError("method \"" + twice + '"', "is there twice; give each method its own name");
  return methods;
}

SensorMask sensors_of(const Method& method, const JointInstant& instant) {
  const MethodSpec& spec = method.spec;
  if (spec.occlusion == OcclusionRule::off) return method.allowed;
  std::array<int, kMaxSensors> counts{};
  SensorMask seen;
  for (std::size_t s = 0; s < instant.observations.size(); ++s) {
    const JointObservation& o = instant.observations[s];
    seen[s] = o.seen && method.allowed[s];
    const bool counts_inferred = spec.inferred_is_occluded || spec.occlusion == OcclusionRule::inferred;
    counts[s] = instant.occlusions[static_cast<std::size_t>(spec.occlusion)][s] +
                (counts_inferred && o.state == TrackingState::inferred ? 1 : 0);
  }
  return select_unoccluded(std::span(counts).first(instant.observations.size()), seen, spec.fewest_sensors);
}

bool is_over_time(const Method& method) { return method.spec.kind->over_time != nullptr; }

PointEstimate evaluate(const Method& method, const JointInstant& instant) {
  TRILAT_CHECK(method.spec.kind->evaluate, "methods over time need the whole path");
  return method.spec.kind->evaluate(method, instant, sensors_of(method, instant));
}

void evaluate(const Method& method, std::span<const JointInstant> instants,
              std::span<PointEstimate> estimates) {
  if (method.spec.kind->evaluate_many) return method.spec.kind->evaluate_many(method, instants, estimates);
  for (std::size_t i = 0; i < instants.size(); ++i) estimates[i] = evaluate(method, instants[i]);
}

std::optional<SolveStatus> status_if_never_solved(const std::vector<RigidTransform>& world_from_sensor,
                                                  const Method& method) {
  if (is_over_time(method)) return std::nullopt;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const RigidTransform& sensor : world_from_sensor)
    middle_m += sensor.translation_m / static_cast<double>(world_from_sensor.size());
  SolveStatus status = SolveStatus::not_solved;
  for (const double up_m : {-0.3, 0.2, 0.5}) {
    const Eigen::Vector3d point_m = middle_m + Eigen::Vector3d(up_m, up_m, 0.4 * up_m);  // no special place
    std::vector<JointObservation> observations;
    for (const RigidTransform& sensor : world_from_sensor)
      observations.push_back(observe(sensor.inverse() * point_m, TrackingState::tracked, sensor));
    status = evaluate(method, {.observations = observations,
                               .world_from_sensor = world_from_sensor,
                               .ranges = ranges_of(observations, world_from_sensor)})
                 .status;
    if (is_usable(status)) return std::nullopt;
  }
  return status;
}

namespace {

// The joints that are asked for, and those that bones join to them. Hands and feet follow their neighbours
// least and are off most: they are left out unless they are asked for.
std::vector<Joint> joints_with_bones(std::span<const Joint> asked) {
  constexpr std::array kEnds{Joint::hand_left,      Joint::hand_right, Joint::hand_tip_left,
                             Joint::hand_tip_right, Joint::thumb_left, Joint::thumb_right,
                             Joint::foot_left,      Joint::foot_right};
  std::vector<Joint> joints(asked.begin(), asked.end());
  for (const Joint joint : kJointsRootFirst)
    if (std::ranges::find(kEnds, joint) == kEnds.end() && std::ranges::find(joints, joint) == joints.end())
      joints.push_back(joint);
  return joints;
}

TrajectoryPoint point_of(const PointEstimate& estimate) {
  return {estimate.position_m, estimate.status, estimate.iterations};
}

}  // namespace

void solve_joints(const Method& method, const TrajectoryInput& seen, const OverTimeCalls&,
                  MethodTrajectories& paths) {
  parallel_for_index(seen.joints.size(), 1, [&](std::size_t j) {
    const JointPath path{seen.time_ns, seen.sensors,
                         [&](std::size_t instant, std::span<JointObservation> observations) {
                           seen.observe(instant, seen.joints[j], observations);
                         }};
    const std::vector<PointEstimate> estimates = solve_kalman(path, method.spec.kalman);
    for (std::size_t i = 0; i < estimates.size(); ++i)
      paths.points[i * paths.joints + j] = point_of(estimates[i]);
  });
}

void solve_bones(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                 MethodTrajectories& paths) {
  const std::vector<Joint> joints = joints_with_bones(seen.joints);
  // How many passes it takes is not known before; an hour of simulated walking takes 134.
  constexpr double kHalfwayPasses = 60.0;
  const auto instants = static_cast<double>(seen.time_ns.size());
  double observed = 0.0;
  std::size_t reported = 0;
  const auto report = [&] {
    if (calls.must_stop && calls.must_stop()) throw Interrupted();
    const double passes = observed / (instants * static_cast<double>(joints.size()));
    const auto done = static_cast<std::size_t>(instants * passes / (passes + kHalfwayPasses));
    if (done > reported && calls.advanced) calls.advanced(done - std::exchange(reported, done));
  };
  const BodyPath path{seen.time_ns, joints, seen.sensors,
                      [&](std::size_t instant, std::size_t joint, std::span<JointObservation> observations) {
                        if (instant % 1024 == 0) report();
                        observed += 1.0;
                        seen.observe(instant, joints[joint], observations);
                      }};
  const SmoothedBody body = smooth_bones(path, method.spec.bones);
  for (std::size_t i = 0; i < seen.time_ns.size(); ++i)
    for (std::size_t j = 0; j < paths.joints; ++j) {  // those asked for come first
      const std::size_t slot = i * joints.size() + j;
      const bool is_answered = body.status[slot] != SolveStatus::no_observation;
      paths.points[i * paths.joints + j] = {body.position_m[slot], body.status[slot],
                                            is_answered ? body.passes : 0};
    }
  if (calls.advanced) calls.advanced(seen.time_ns.size() - reported);
}

}  // namespace trilat
