// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "evaluators/fusion/baselines.h"
#include "evaluators/fusion/joint_observation.h"
#include "pipeline/study_spec.h"

namespace trilat {

// A method whose sensors are numbers of the rig: ready to be asked.
struct Method {
  MethodSpec spec;
  SensorMask allowed = kAllSensors;
  GeometricOptions geometric;
  SingleSensorOptions single;
};

// `single` without sensors becomes one method a sensor. InputError naming a sensor that the rig does not
// have.
std::vector<Method> resolve_methods(const StudySpec& spec, const std::vector<std::string>& rig);

// One joint at one instant, as the whole rig sees it. `ranges` is made from all sensors.
struct JointInstant {
  std::span<const JointObservation> observations;
  std::span<const RigidTransform> world_from_sensor;
  RangeProblem ranges;
};

[[nodiscard]] PointEstimate evaluate(const Method& method, const JointInstant& instant);

// The same for many: iterative methods solve them side by side. `estimates` has one slot an instant.
void evaluate(const Method& method, std::span<const JointInstant> instants,
              std::span<PointEstimate> estimates);

}  // namespace trilat
