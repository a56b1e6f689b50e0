// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

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

}  // namespace trilat
