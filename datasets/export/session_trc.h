// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
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

// Marker files as OpenSim reads them: the 25 joints of a body are the markers, a frame that lacks the body or
// a joint that is not tracked leaves its fields empty. A session with several bodies gives OUTPUT-ID.trc
// each. InputError for a session without bodies, an unknown body or sensor, and for more than 100 bodies.
std::vector<TrcFile> export_session_trc(const SessionReader& session, const std::filesystem::path& output,
                                        const TrcOptions& options);

}  // namespace trilat
