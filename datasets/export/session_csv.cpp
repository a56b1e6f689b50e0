// SPDX-License-Identifier: MIT
#include "datasets/export/session_csv.h"

#include <array>

#include "datasets/base/text_output.h"
#include "datasets/export/export_frame.h"

namespace trilat {
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
