// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "evaluators/fusion/baselines.h"
#include "evaluators/fusion/joint_observation.h"
#include "pipeline/accuracy/methods/study_spec.h"

namespace trilat {

// Sets of `size` of `sensors` sensors, each in rising order: all of them, in lexicographic order, when they
// are `most` or fewer. Otherwise `most` different ones, which are the first sensors of random orders of all:
// order n is the same for every size, so that a set of one size lies within one of the next. Both numbers are
// at least 1, `size` at most `sensors`.
std::vector<std::vector<std::size_t>> sensor_sets(std::size_t sensors, std::size_t size, std::size_t most);

// A method whose sensors are numbers of the rig: ready to be asked.
struct Method {
  MethodSpec spec;
  SensorMask allowed = kAllSensors;
  std::vector<int> sensors;  // that the entry names, in its order; where the kind uses just so many, those
};

// An entry that names a size of sets (`single` without sensors: one) becomes one method a set. InputError
// naming a sensor that the rig does not have.
std::vector<Method> resolve_methods(const StudySpec& spec, const std::vector<std::string>& rig);

// How often each sensor's view of a joint is occluded, by each rule.
using JointOcclusions = std::array<std::array<std::uint8_t, kMaxSensors>, kOcclusionRules>;

// One joint at one instant, as the whole rig sees it. `ranges` is made from all sensors.
struct JointInstant {
  std::span<const JointObservation> observations;
  std::span<const RigidTransform> world_from_sensor;
  JointOcclusions occlusions{};
  RangeProblem ranges;
  RaySigma sigma{kNaN, kNaN};  // of methods whose sigma is estimated; NaN when that failed
};

// The sensors that the method uses for this joint at this instant.
SensorMask sensors_of(const Method& method, const JointInstant& instant);

// How a method ends that answers nothing on this rig, even where every sensor sees a joint without any error;
// nothing when it answers, or works over time.
std::optional<SolveStatus> status_if_never_solved(const std::vector<RigidTransform>& world_from_sensor,
                                                  const Method& method);

// Methods that need whole paths; the others take every instant by itself.
bool is_over_time(const Method& method);

[[nodiscard]] PointEstimate evaluate(const Method& method, const JointInstant& instant);

// Evaluates many instants: iterative methods solve them side by side. `estimates` has one slot an instant.
// InternalError for a method over time.
void evaluate(const Method& method, std::span<const JointInstant> instants,
              std::span<PointEstimate> estimates);

struct TrajectoryPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Constant(kNaN);
  SolveStatus status = SolveStatus::not_solved;
  int iterations = 0;
};

// The answers of one method over time for one take, by instant and joint.
struct MethodTrajectories {
  std::size_t method = 0;
  std::size_t joints = 0;
  std::vector<TrajectoryPoint> points;
  const TrajectoryPoint& at(std::size_t instant, std::size_t joint) const {
    return points[instant * joints + joint];
  }
};

// Both are called from any thread. `advanced` counts how many instants more of one windowed method are done.
struct OverTimeCalls {
  std::function<void(std::size_t)> advanced;
  std::function<bool()> must_stop;
};

// A take as a method over time sees it.
struct TrajectoryInput {
  std::span<const std::int64_t> time_ns;  // of the instants
  std::size_t sensors = 0;
  std::span<const Joint> joints;  // that are asked for
  // One joint at one instant, as the method's sensors see it; from any thread.
  std::function<void(std::size_t instant, Joint joint, std::span<JointObservation> observations)> observe;
};

using OverTimeSolver = void (*)(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                                MethodTrajectories& paths);
// Each joint by itself.
void solve_joints(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                  MethodTrajectories& paths);
// All joints together, which takes long. Throws Interrupted when asked to stop.
void solve_bones(const Method& method, const TrajectoryInput& seen, const OverTimeCalls& calls,
                 MethodTrajectories& paths);

}  // namespace trilat
