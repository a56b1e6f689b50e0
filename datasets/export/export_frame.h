// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

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

// A text file of any length that is written aside and gets its name by publish(); without that nothing is
// left. OutputError with the path when the disk does not let us.
class TextOutput {
 public:
  explicit TextOutput(const std::filesystem::path& path);
  ~TextOutput();
  TextOutput(const TextOutput&) = delete;
  TextOutput& operator=(const TextOutput&) = delete;

  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
    if (text_.size() > kBlockBytes) write_block();
  }
  void publish();

 private:
  static constexpr std::size_t kBlockBytes = 1u << 16;
  void write_block();

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::string text_;
};

}  // namespace trilat
