// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method.h"

#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "evaluators/bodies/occlusion.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/methods/sensor_sets.h"

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
  method.sensors = std::move(indices);
  const std::size_t used = spec.kind->sensors;
  if (used == 0) return method;
  if (used == 1 && method.sensors.size() != 1)
    throw InputError(
        "method \"" + spec.name + '"',
        fmt::format("of kind {} uses one sensor, or names none for each in turn", spec.kind->name));
  if (method.sensors.empty())
    for (std::size_t s = 0; s < used; ++s) method.sensors.push_back(static_cast<int>(s));
  method.allowed.reset();  // nothing of the other sensors, not even through the hint
  for (int i : method.sensors) method.allowed.set(static_cast<std::size_t>(i));
  return method;
}

// What an entry of the study stands for: itself, or one method for each set of sensors.
std::vector<MethodSpec> one_a_set(const MethodSpec& spec, const std::vector<std::string>& rig) {
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

}  // namespace trilat
