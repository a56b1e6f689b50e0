// SPDX-License-Identifier: MIT
#include "datasets/export/session_export.h"

#include <algorithm>
#include <array>
#include <map>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/markers/joint_files.h"

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

namespace {

constexpr std::size_t kMostBodies = 100;

// The stretch of a body: rows of body_frames.
struct Stretch {
  std::int64_t first = 0, last = 0;
};

std::map<std::uint64_t, Stretch> bodies_of(const SessionReader& session, std::size_t sensor,
                                           const std::optional<std::uint64_t>& wanted) {
  std::map<std::uint64_t, Stretch> bodies;
  std::int64_t row = 0;
  const auto visit = [&](const BodyFrame& frame) {
    for (const Body& body : frame.bodies)
      if (!wanted || body.tracking_id == *wanted) {
        bodies.try_emplace(body.tracking_id, Stretch{row, row}).first->second.last = row;
        if (bodies.size() > kMostBodies)
          throw InputError(session.path().string(),
                           fmt::format("holds more than {} bodies; choose one with --body ID", kMostBodies));
      }
    ++row;
  };
  for_each_body_frame(session, sensor, visit, {});
  return bodies;
}

std::size_t sensor_of(const SessionReader& session, const std::string& name) {
  if (!name.empty()) return session.sensor_index(name);
  if (session.header().sensors.size() > 1)
    throw InputError(session.path().string(),
                     fmt::format("holds {} sensors, and a TRC file is of one; choose with --sensor",
                                 session.header().sensors.size()));
  return 0;
}

void add_markers(TextOutput& text, const Body* body, const RigidTransform& from_sensor, bool millimetres) {
  const Body moved = body ? transformed(*body, from_sensor) : Body{};
  for (std::size_t j = 0; j < kJointCount; ++j) {
    if (moved.tracking_state[j] == 0) {
      text.add("\t\t\t");
      continue;
    }
    for (const float x_m : moved.position_m[j])
      if (millimetres)
        text.add("\t{:.3f}", 1e3 * static_cast<double>(x_m));
      else
        text.add("\t{:.6f}", static_cast<double>(x_m));
  }
}

const Body* body_with(const BodyFrame& frame, std::uint64_t id) {
  for (const Body& body : frame.bodies)
    if (body.tracking_id == id) return &body;
  return nullptr;
}

TrcFile export_body(const SessionReader& session, std::size_t sensor, std::uint64_t id,
                    const Stretch& stretch, const std::filesystem::path& path, const TrcOptions& options) {
  const SensorDescription& description = session.header().sensors[sensor];
  const RigidTransform from_sensor = export_from_sensor(options.frame, session, sensor);
  const std::int64_t rows = stretch.last - stretch.first + 1;
  TextOutput text(path);
  std::vector<std::string> joints;
  for (int j = 0; j < kJointCount; ++j) joints.emplace_back(name_of(static_cast<Joint>(j)));
  text.add_bytes(trc_header(path, joints, description.nominal_rate_hz, rows,
                            options.millimetres ? LengthUnit::millimetre : LengthUnit::metre));
  std::optional<FrameStamp> first;
  std::int64_t row = 0;
  const auto visit = [&](const BodyFrame& frame) {
    const std::int64_t at = row++;
    if (at < stretch.first || at > stretch.last) return;
    if (!first) first = frame.stamp;
    text.add("{}\t{:.6f}", frame.stamp.sequence - first->sequence + 1,
             seconds_between(*first, frame.stamp, description.tick_ns));
    add_markers(text, body_with(frame, id), from_sensor, options.millimetres);
    text.add("\n");
  };
  for_each_body_frame(session, sensor, visit, options.frame.progress);
  text.publish();
  return {path, id, rows};
}

}  // namespace

std::vector<TrcFile> export_session_trc(const SessionReader& session, const std::filesystem::path& output,
                                        const TrcOptions& options) {
  const std::size_t sensor = sensor_of(session, options.sensor);
  const auto bodies = bodies_of(session, sensor, options.body);
  if (bodies.empty())
    throw InputError(session.path().string(), options.body ? fmt::format("holds no body {}", *options.body)
                                                           : std::string("holds no body"));
  const auto path_of = [&](std::uint64_t id) {
    return bodies.size() == 1 ? output
                              : output.parent_path() / fmt::format("{}-{}{}", output.stem().string(), id,
                                                                   output.extension().string());
  };
  if (options.check)
    for (const auto& [id, stretch] : bodies) options.check(path_of(id));
  std::vector<TrcFile> files;
  for (const auto& [id, stretch] : bodies)
    files.push_back(export_body(session, sensor, id, stretch, path_of(id), options));
  return files;
}

namespace {

constexpr std::array kStateNames{"not_tracked", "inferred", "tracked"};

void add_body(TextOutput& text, const std::string& front, const Body& body) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto& p = body.position_m[j];
    const auto& q = body.orientation_xyzw[j];
    const std::size_t state = body.tracking_state[j];
    text.add("{},{},{},{},{},{},{},{},{},{},{}\n", front, body.tracking_id, name_of(static_cast<Joint>(j)),
             state < kStateNames.size() ? kStateNames[state] : "unknown", p[0], p[1], p[2], q[0], q[1], q[2],
             q[3]);
  }
}

}  // namespace

std::int64_t export_session_csv(const SessionReader& session, const std::filesystem::path& output,
                                const ExportOptions& options) {
  TextOutput text(output);
  text.add("{}", kSessionCsvHead);
  std::int64_t rows = 0;
  const std::size_t sensors = session.header().sensors.size();
  for (std::size_t s = 0; s < sensors; ++s) {
    const SensorDescription& sensor = session.header().sensors[s];
    const RigidTransform from_sensor = export_from_sensor(options, session, s);
    std::optional<FrameStamp> first;
    const auto visit = [&](const BodyFrame& frame) {
      if (!first) first = frame.stamp;
      const std::string front = fmt::format(
          "{},{},{},{},{:.7f}", csv_field(sensor.name), frame.stamp.sequence, frame.stamp.device_ticks,
          frame.stamp.arrival_ns, seconds_between(*first, frame.stamp, sensor.tick_ns));
      for (const Body& body : frame.bodies) add_body(text, front, transformed(body, from_sensor));
      rows += static_cast<std::int64_t>(frame.bodies.size()) * kJointCount;
    };
    for_each_body_frame(session, s, visit, [&](double share) {
      if (options.progress) options.progress((static_cast<double>(s) + share) / static_cast<double>(sensors));
    });
  }
  text.publish();
  return rows;
}

}  // namespace trilat
