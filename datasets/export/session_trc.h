// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/export/export_frame.h"

namespace trilat {

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

// The parts of such a file: its head, and a marker of a frame (null: missing), positions in metres.
void add_trc_header(TextOutput& text, const std::filesystem::path& path, double rate_hz, std::int64_t rows,
                    std::span<const Joint> joints, bool millimetres);
void add_trc_marker(TextOutput& text, const float* position_m, bool millimetres);

// Marker files as OpenSim reads them: the 25 joints of a body are the markers, a frame that lacks the body or
// a joint that is not tracked leaves its fields empty. A session with several bodies gives OUTPUT-ID.trc
// each. InputError for a session without bodies, an unknown body or sensor, and for more than 100 bodies.
std::vector<TrcFile> export_session_trc(const SessionReader& session, const std::filesystem::path& output,
                                        const TrcOptions& options);

}  // namespace trilat
