// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "datasets/import/body_file_reader.h"
#include "datasets/import/frame_numbers.h"
#include "datasets/import/import_types.h"
#include "datasets/session/session_writer.h"

namespace trilat {

// A session that is filled from somebody's recording: stamps the frames, counts them, and writes them.
// Without finish() nothing is left behind.
class ImportSession {
 public:
  ImportSession(const std::filesystem::path& output, const SessionHeader& header,
                ChunkCompression compression);
  ~ImportSession();
  ImportSession(const ImportSession&) = delete;
  ImportSession& operator=(const ImportSession&) = delete;

  void add_bodies(std::size_t sensor, const FileFrame& frame, const std::string& place);
  // `depth_mm` holds kDepthPixels values.
  void add_depth(std::size_t sensor, std::int64_t ticks, std::optional<std::int64_t> sequence,
                 std::span<const std::uint16_t> depth_mm, const std::string& place);
  ImportedSensor& report(std::size_t sensor) { return report_.sensors.at(sensor); }
  // InputError when nothing has been added.
  ImportReport finish();

 private:
  void flush_now_and_then();

  struct Streams {
    FrameNumbers bodies, depth;
  };
  std::filesystem::path output_;
  ChunkCompression compression_;
  std::unique_ptr<SessionWriter> writer_;
  std::vector<Streams> streams_;
  ImportReport report_;
  std::int64_t unflushed_frames_ = 0;
};

}  // namespace trilat
