// SPDX-License-Identifier: MIT
#include "datasets/export/export_frame.h"

#include <algorithm>

#include "datasets/base/error.h"

namespace trilat {

namespace {

constexpr std::uint64_t kBlockFrames = 1024;

}  // namespace

RigidTransform export_from_sensor(const ExportOptions& options, const SessionReader& session,
                                  std::size_t sensor) {
  if (!options.calibration) return {};
  const std::string& name = session.header().sensors.at(sensor).name;
  for (const SensorPose& pose : options.calibration->sensors)
    if (pose.name == name) return pose.world_from_sensor;
  throw InputError("--calibration", "has no pose of the sensor \"" + name + "\"");
}

Body transformed(const Body& body, const RigidTransform& export_from_sensor) {
  Body result = body;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& p = body.position_m[j];
    const Eigen::Vector3d point = export_from_sensor * Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
    for (std::size_t axis = 0; axis < 3; ++axis)
      result.position_m[j][axis] = static_cast<float>(point[static_cast<Eigen::Index>(axis)]);
    const auto& q = body.orientation_xyzw[j];
    const Eigen::Quaterniond turn =
        export_from_sensor.rotation * Eigen::Quaternionf(q[3], q[0], q[1], q[2]).cast<double>();
    result.orientation_xyzw[j] = {static_cast<float>(turn.x()), static_cast<float>(turn.y()),
                                  static_cast<float>(turn.z()), static_cast<float>(turn.w())};
  }
  return result;
}

double seconds_between(const FrameStamp& first, const FrameStamp& stamp, std::int64_t tick_ns) {
  return 1e-9 * (static_cast<double>(stamp.device_ticks) - static_cast<double>(first.device_ticks)) *
         static_cast<double>(tick_ns);
}

void for_each_body_frame(const SessionReader& session, std::size_t sensor,
                         const std::function<void(const BodyFrame&)>& visit,
                         const std::function<void(double)>& progress) {
  const std::uint64_t frames = session.counts(sensor).body_frames;
  for (std::uint64_t first = 0; first < frames; first += kBlockFrames) {
    const std::uint64_t count = std::min(kBlockFrames, frames - first);
    for (const BodyFrame& frame : session.body_frames(sensor, first, count)) visit(frame);
    if (progress) progress(static_cast<double>(first + count) / static_cast<double>(frames));
  }
}

}  // namespace trilat
