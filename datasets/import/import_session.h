// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/import/body_file_reader.h"
#include "datasets/import/import_types.h"
#include "datasets/session/session_types.h"
#include "datasets/session/session_writer.h"

namespace trilat {

// Gives the frames of one stream their stamps, and leaves out those whose time does not go on.
class FrameNumbers {
 public:
  FrameNumbers(double rate_hz, std::int64_t tick_ns) : rate_hz_(rate_hz), tick_ns_(tick_ns) {}

  // Nothing when the frame must be left out; then it has been counted in `left_out` with its place. A
  // sequence number that does not rise is not believed; without one the time says how many frames lie
  // between.
  std::optional<FrameStamp> stamp(std::int64_t ticks, std::optional<std::int64_t> sequence,
                                  const std::string& place, LeftOut& left_out);
  std::int64_t gap_frames() const { return gap_frames_; }

 private:
  double rate_hz_;
  std::int64_t tick_ns_;
  std::optional<FrameStamp> last_{};
  std::int64_t gap_frames_ = 0;
};

// Counts one torn row; the first that is left out keeps its place.
void count_torn(LeftOut& left_out, const std::string& place, const TornRow& row);

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
