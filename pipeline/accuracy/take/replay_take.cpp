// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/replay_take.h"

#include <algorithm>

namespace trilat {

bool is_replayed(const Plan& plan, std::size_t take) {
  const auto first = std::find_if(plan.takes.begin(), plan.takes.end(), [&](const PlannedTake& other) {
    return other.ok && other.take.activity == plan.takes[take].take.activity;
  });
  return first == plan.takes.begin() + static_cast<std::ptrdiff_t>(take);
}

ReplayTake replay_of(const Plan& plan, std::size_t index, const TakeData& data) {
  const PlannedTake& planned = plan.takes[index];
  ReplayTake replay;
  replay.take = index;
  replay.id = planned.take.id;
  replay.condition = planned.take.activity;
  replay.sensors = plan.rig;
  replay.world_from_sensor = planned.world_from_sensor;
  const auto most = static_cast<std::uint64_t>(kReplay_s * plan.study.rate_hz);
  replay.reset(std::min<std::uint64_t>(most, data.time.size()), plan.rig.size());
  std::size_t slot = 0;
  for (std::uint64_t i = 0; i < replay.instants; ++i)
    for (std::size_t s = 0; s < plan.rig.size(); ++s) {
      const ObservedBody& body = data.bodies.at(i, s);
      for (std::size_t j = 0; j < kJointCount; ++j, ++slot) {
        if (!body.has(j)) continue;
        const Eigen::Vector3d joint_m =
            planned.world_from_sensor[s] * body.joint_in_sensor_m[j].cast<double>();
        for (int axis = 0; axis < 3; ++axis)
          replay.joint_m[slot * 3 + static_cast<std::size_t>(axis)] = static_cast<float>(joint_m[axis]);
        replay.state[slot] = static_cast<std::uint8_t>(body.state[j]);
      }
    }
  return replay;
}

}  // namespace trilat
