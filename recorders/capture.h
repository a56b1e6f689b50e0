// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"
#include "recorders/agents.h"
#include "recorders/frame_source.h"
#include "recorders/spool.h"

namespace trilat {

struct CaptureStatus {
  double elapsed_s = 0.0;
  std::vector<SensorStatus> sensors;
  std::size_t waiting_bytes = 0;  // for the log
  std::uint64_t log_bytes = 0, disk_free_bytes = 0;
};

struct CaptureOptions {
  std::string started_utc;  // of the session; for people
  // Agents of other computers: how many, where they connect, and how long they are waited for.
  std::size_t agents = 0;
  std::function<std::unique_ptr<StreamListener>()> listen = {};
  double wait_s = 60.0;
  SpoolOptions spool = {};
  double look_period_s = 0.25;  // between looks for silent sensors, losses and the disk
  double duration_s = 0.0;      // 0: until the sources end or somebody stops it
  std::uint64_t reserve_bytes =
      kDiskReserve_bytes;  // beside the log, as much for the session, and what waits
  std::function<bool()> stop_requested = {};
  // After every look, by the calling thread.
  std::function<void(const CaptureStatus&)> on_status = {};
  std::function<void(const std::string&)> on_notice = {};
  std::function<bool(double)> on_writing = {};  // share of the session that is written; false breaks that off

  static constexpr std::uint64_t kDiskReserve_bytes = std::uint64_t{256} << 20;
};

enum class CaptureEnd { source_ended, stop_requested, duration_over, disk_full };

struct CaptureSummary {
  CaptureEnd end = CaptureEnd::source_ended;
  CaptureStatus last;
  std::uint64_t session_bytes = 0;
  bool source_failed = false;  // a source broke before it ended
  std::string log_left;        // why the log was not removed; empty where the session is sound
  bool lost_frames() const;
};

// `path` with ".trilog" behind: the log of a recording that is to become `path`.
std::filesystem::path log_name(const std::filesystem::path& path);

// The logs from which the session at `path` is to be made: of its recorder, and copies of those of its
// agents.
std::vector<std::filesystem::path> logs_beside(const std::filesystem::path& path);

// The file under its name; where there is none, the log of a recording that runs or was killed, or the
// unfinished session of a recorder of version 0.4.0.
std::filesystem::path found_session(const std::filesystem::path& path);

// Records all sources and agents into logs beside `path` until they end or something stops them, makes the
// session of these, reads it back, and removes them. With agents, the recording that a killed recorder left
// there goes on. InputError when logs exist otherwise, two sensors have one name, or agents do not come;
// Interrupted when stopped before the beginning. OutputError when the disk fails: the logs then keep what was
// synced.
CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options);

struct RecordOptions {
  ChunkCompression depth_compression = ChunkCompression::blosc;
  std::function<bool()> stop_requested = {};  // asked now and then
};

struct RecordSummary {
  std::uint64_t body_frames = 0;
  std::uint64_t depth_frames = 0;
};

// Stores everything the source delivers in `path` (session.h5) until it ends. Throws Interrupted when asked
// to stop, and nothing is left then.
RecordSummary record(FrameSource& source, const std::filesystem::path& path, const RecordOptions& options);

}  // namespace trilat
