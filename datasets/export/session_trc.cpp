// SPDX-License-Identifier: MIT
#include "datasets/export/session_trc.h"

#include <map>

#include "datasets/base/error.h"
#include "datasets/export/export_frame.h"

namespace trilat {
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

std::vector<Joint> every_joint() {
  std::vector<Joint> joints;
  for (int j = 0; j < kJointCount; ++j) joints.push_back(static_cast<Joint>(j));
  return joints;
}

void add_markers(TextOutput& text, const Body* body, const RigidTransform& from_sensor, bool millimetres) {
  const Body moved = body ? transformed(*body, from_sensor) : Body{};
  for (std::size_t j = 0; j < kJointCount; ++j)
    add_trc_marker(text, moved.tracking_state[j] == 0 ? nullptr : moved.position_m[j].data(), millimetres);
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
  add_trc_header(text, path, description.nominal_rate_hz, rows, every_joint(), options.millimetres);
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

void add_trc_header(TextOutput& text, const std::filesystem::path& path, double rate_hz, std::int64_t rows,
                    std::span<const Joint> joints, bool millimetres) {
  text.add("PathFileType\t4\t(X/Y/Z)\t{}\n", path.filename().string());
  text.add(
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"
      "\n");
  text.add("{:g}\t{:g}\t{}\t{}\t{}\t{:g}\t1\t{}\n", rate_hz, rate_hz, rows, joints.size(),
           millimetres ? "mm" : "m", rate_hz, rows);
  text.add("Frame#\tTime");
  for (const Joint joint : joints) text.add("\t{}\t\t", name_of(joint));
  text.add("\n\t");
  for (std::size_t j = 1; j <= joints.size(); ++j) text.add("\tX{}\tY{}\tZ{}", j, j, j);
  text.add("\n\n");
}

void add_trc_marker(TextOutput& text, const float* position_m, bool millimetres) {
  for (int axis = 0; axis < 3; ++axis)
    if (!position_m)
      text.add("\t");
    else if (millimetres)
      text.add("\t{:.3f}", 1e3 * static_cast<double>(position_m[axis]));
    else
      text.add("\t{:.6f}", static_cast<double>(position_m[axis]));
}

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

}  // namespace trilat
