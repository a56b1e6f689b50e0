// SPDX-License-Identifier: MIT
#include "recorders/agent/virtual_sensors.h"

#include "datasets/base/error.h"
#include "recorders/synthetic_source.h"

namespace trilat {
namespace {

constexpr double kDuration_s = 60.0;

}  // namespace

std::unique_ptr<FrameSource> open_virtual_sensors(const std::string& text) {
  const bool known =
      text.size() == 11 && text.starts_with("synthetic:") && text[10] >= '1' && text[10] <= '4';
  if (!known) throw InputError(text, "is no source; there is synthetic:N with 1 to 4 sensors");
  const auto count = static_cast<std::size_t>(text[10] - '0');
  const SensorSpec spec;
  const SimulatedItem item{1, 0, 0};
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0}))
    if (sensors.size() < count) sensors.push_back(draw_sensor(spec, item, sensors.size(), pose));
  return std::make_unique<SyntheticSource>(spec, item, generated_motion(Person{}, Activity::walking),
                                           std::move(sensors), kDuration_s);
}

}  // namespace trilat
