// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/files.h"
#include "datasets/import/import_formats.h"
#include "datasets/session/session_reader.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace trilat {

// A person 2.5 m in front of the sensor who goes aside by 1 cm a frame: joint j of frame i.
inline std::array<double, 3> made_up_joint_m(int frame, int j) {
  return {0.01 * frame + 0.05 * (j % 5) - 0.1, 0.06 * (j / 5) - 0.15, 2.5 + 0.01 * j};
}

inline std::filesystem::path text_file(const ScratchFolder& folder, const std::string& name,
                                       const std::string& text) {
  write_file(folder / name, text);
  return folder / name;
}

// The session that an import made, read back.
struct Imported {
  ImportReport report;
  SessionReader session;
  std::vector<BodyFrame> frames(std::size_t sensor = 0) const {
    return session.body_frames(sensor, 0, session.counts(sensor).body_frames);
  }
};

inline Imported imported(const ScratchFolder& folder, const std::string& format,
                         const std::vector<std::filesystem::path>& files, const ImportOptions& options = {}) {
  ImportReport report = import_recording(format, files, folder / "session.h5", options);
  return {std::move(report), SessionReader(folder / "session.h5")};
}

// What import says of files that it refuses; that nothing is left behind is checked on the way.
inline std::string import_refusal(const ScratchFolder& folder, const std::string& format,
                                  const std::vector<std::filesystem::path>& files,
                                  const ImportOptions& options = {}) {
  const std::string message =
      message_of([&] { import_recording(format, files, folder / "refused.h5", options); });
  EXPECT_FALSE(std::filesystem::exists(folder / "refused.h5"));
  EXPECT_FALSE(std::filesystem::exists(partial_name(folder / "refused.h5")));
  return message;
}

// Sequence numbers of the frames.
inline std::vector<std::int64_t> sequences(const std::vector<BodyFrame>& frames) {
  std::vector<std::int64_t> result;
  for (const BodyFrame& frame : frames) result.push_back(frame.stamp.sequence);
  return result;
}

inline std::filesystem::path shared_recordings() {
  return std::filesystem::path(kSourceDir) / ".." / "shared" / "data" / "kinect-bodies";
}

}  // namespace trilat
