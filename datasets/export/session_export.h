// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/text_output.h"
#include "datasets/calibration/calibration.h"
#include "datasets/geometry/rigid_transform.h"
#include "datasets/session/session_reader.h"

namespace trilat {

struct ExportOptions {
  std::optional<Calibration> calibration{};  // positions in its world; nothing: in each sensor's own frame
  std::function<void(double)> progress{};    // share done; what it throws ends the export
};

// The transform for a sensor's points; the identity without a calibration, InputError when it lacks the
// sensor.
RigidTransform export_from_sensor(const ExportOptions& options, const SessionReader& session,
                                  std::size_t sensor);

// The body with positions and orientations in the frame of the export.
Body transformed(const Body& body, const RigidTransform& export_from_sensor);

// Device time of a frame since `first`, of a sensor whose tick is `tick_ns` long.
double seconds_between(const FrameStamp& first, const FrameStamp& stamp, std::int64_t tick_ns);

// Calls `visit` with every body frame of a sensor, in blocks.
void for_each_body_frame(const SessionReader& session, std::size_t sensor,
                         const std::function<void(const BodyFrame&)>& visit,
                         const std::function<void(double)>& progress);

struct TrcOptions {
  ExportOptions frame{};
  std::string sensor{};                 // empty: the session's only one
  std::optional<std::uint64_t> body{};  // nothing: each body a file
  bool millimetres = true;              // otherwise metres
  std::function<void(const std::filesystem::path&)> check =
      {};  // is asked about each file before it is written
};

struct TrcFile {
  std::filesystem::path path;
  std::uint64_t tracking_id = 0;
  std::int64_t rows = 0;  // from the body's first frame to its last
};

// Marker files as OpenSim reads them: the 25 joints of a body are the markers, a frame that lacks the body or
// a joint that is not tracked leaves its fields empty. A session with several bodies gives OUTPUT-ID.trc
// each. InputError for a session without bodies, an unknown body or sensor, and for more than 100 bodies.
std::vector<TrcFile> export_session_trc(const SessionReader& session, const std::filesystem::path& output,
                                        const TrcOptions& options);

inline constexpr const char* kSessionCsvHead =
    "sensor,sequence,device_ticks,arrival_ns,time_s,tracking_id,joint,state,x_m,y_m,z_m,qx,qy,qz,qw\n";

// One row a frame, body and joint, all sensors one after the other. Returns the number of rows.
std::int64_t export_session_csv(const SessionReader& session, const std::filesystem::path& output,
                                const ExportOptions& options);

}  // namespace trilat
