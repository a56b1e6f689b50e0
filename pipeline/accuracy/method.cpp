// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/method.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "evaluators/bodies/occlusion.h"
#include "pipeline/accuracy/sensor_sets.h"

namespace trilat {
namespace {

int rig_index(const std::string& sensor, const std::vector<std::string>& rig, const std::string& method) {
  const auto found = std::find(rig.begin(), rig.end(), sensor);
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
  if (spec.kind == MethodKind::geometric && indices.size() == 3)
    method.geometric.sensors = {indices[0], indices[1], indices[2]};
  if (spec.kind == MethodKind::geometric) {
    // nothing of the other sensors, not even through the hint
    method.allowed.reset();
    for (int i : method.geometric.sensors) method.allowed.set(static_cast<std::size_t>(i));
  }
  if (spec.kind == MethodKind::single) {
    if (indices.size() != 1)
      throw InputError("method \"" + spec.name + '"',
                       "of kind single uses one sensor, or names none for each in turn");
    method.single.sensor = indices[0];
  }
  return method;
}

// What an entry of the study stands for: itself, or one method for each set of sensors.
std::vector<MethodSpec> one_a_set(const MethodSpec& spec, const std::vector<std::string>& rig) {
  const bool is_each_single = spec.kind == MethodKind::single && spec.sensors.empty();
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

bool is_iterative(const Method& method) {
  return method.spec.kind == MethodKind::nonlinear || method.spec.kind == MethodKind::newton;
}

RangeProblem ranges_from(const JointInstant& instant, SensorMask sensors) {
  if (sensors == kAllSensors) return instant.ranges;
  return ranges_of(instant.observations, instant.world_from_sensor, sensors);
}

template <class Options>
Options among(Options options, SensorMask sensors) {
  options.allowed = sensors;
  return options;
}

}  // namespace

std::vector<Method> resolve_methods(const StudySpec& spec, const std::vector<std::string>& rig) {
  std::vector<Method> methods;
  for (const MethodSpec& m : spec.methods)
    for (const MethodSpec& one : one_a_set(m, rig)) methods.push_back(resolve(one, rig));
  std::vector<std::string> names;
  for (const Method& method : methods) names.push_back(method.spec.name);
  if (const std::string twice = first_repeated(names); !twice.empty())
    throw InputError("method \"" + twice + '"', "stands twice; give each method its own name");
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
    counts[s] = instant.occlusions[static_cast<std::size_t>(spec.occlusion)][s] +
                (spec.inferred_is_occluded && o.state == TrackingState::inferred ? 1 : 0);
  }
  return select_unoccluded(std::span(counts).first(instant.observations.size()), seen, spec.fewest_sensors);
}

bool is_over_time(const Method& method) {
  const MethodKind kind = method.spec.kind;
  return kind == MethodKind::kalman || kind == MethodKind::rts || kind == MethodKind::window;
}

PointEstimate evaluate(const Method& method, const JointInstant& instant) {
  const auto& seen = instant.observations;
  const SensorMask sensors = sensors_of(method, instant);
  switch (method.spec.kind) {
    case MethodKind::linear:
      return solve_linear(ranges_from(instant, sensors), method.spec.linear);
    case MethodKind::geometric:
      return solve_geometric(ranges_from(instant, sensors), method.geometric);
    case MethodKind::ceres:
      return solve_ceres(ranges_from(instant, sensors), method.spec.ceres);
    case MethodKind::nonlinear:
    case MethodKind::newton:
      return solve_nonlinear(ranges_from(instant, sensors), method.spec.nonlinear);
    case MethodKind::mean:
      return solve_mean(seen, {.allowed = sensors});
    case MethodKind::tracked_mean:
      return solve_mean(seen, {.allowed = sensors, .prefer_tracked = true});
    case MethodKind::single:
      return solve_single_sensor(seen, method.single);
    case MethodKind::weighted_mean:
      return solve_weighted_mean(seen, among(method.spec.weighted, sensors));
    case MethodKind::median:
      return solve_median(seen, {.allowed = sensors});
    case MethodKind::robust_mean:
      return solve_robust_mean(seen, among(method.spec.robust, sensors));
    case MethodKind::kalman:
    case MethodKind::rts:
    case MethodKind::window:
      break;
  }
  TRILAT_CHECK(false, "methods over time need the whole path");
}

void evaluate(const Method& method, std::span<const JointInstant> instants,
              std::span<PointEstimate> estimates) {
  if (is_iterative(method)) {
    std::vector<RangeProblem> problems;
    problems.reserve(instants.size());
    for (const JointInstant& instant : instants)
      problems.push_back(ranges_from(instant, sensors_of(method, instant)));
    solve_nonlinear(problems, method.spec.nonlinear, estimates);
    return;
  }
  for (std::size_t i = 0; i < instants.size(); ++i) estimates[i] = evaluate(method, instants[i]);
}

}  // namespace trilat
