// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "recorders/frame_source.h"

namespace trilat {

// How one sensor of a running recording is.
struct SensorStatus {
  std::string name;
  std::uint64_t body_frames = 0, depth_frames = 0;     // stored
  std::int64_t lost_at_source = 0, lost_in_queue = 0;  // the latter also torn ones and impossible times
  double rate_hz = 0.0;  // frames stored a second since the last status, of the slower of its streams
};

struct CaptureStatus {
  double elapsed_s = 0.0;
  std::vector<SensorStatus> sensors;
  std::size_t queue_bytes = 0, queue_limit_bytes = 0;
  std::uint64_t file_bytes = 0, disk_free_bytes = 0;
};

struct CaptureOptions {
  std::string started_utc;  // of the session; for people
  ChunkCompression depth_compression = ChunkCompression::blosc;
  int workers = 2;                       // threads that compress
  std::size_t queue_bytes = 512u << 20;  // about ten seconds of four Kinects
  double flush_period_s = 0.5;           // what a kill can cost, and a little more
  double sync_period_s = 1.0;            // between requests to put it all on the disk
  double duration_s = 0.0;               // 0: until the sources end or somebody stops it
  double silence_s = 2.0;  // without frames for so long, a stream of a sensor is named as silent
  std::uint64_t reserve_bytes =
      256u << 20;  // the recording ends in order when the disk has less left beside the queue
  std::function<bool()> stop_requested = {};
  std::function<void(const CaptureStatus&)> on_status = {};  // after every flush: what it counts is safe
  std::function<void(const std::string& sensor, const std::string& text)> on_notice = {};
  std::function<void(const std::string& sensor, const BodyFrame&)> on_bodies = {};  // by the writing thread
};

enum class CaptureEnd { source_ended, stop_requested, duration_over, disk_full, disk_failed };

struct CaptureSummary {
  CaptureEnd end = CaptureEnd::disk_failed;
  std::string problem;  // of disk_failed: what the disk said; the file then keeps its ".partial" name
  CaptureStatus last;
  bool source_failed = false;  // a source broke before it ended
  bool lost_frames() const;
};

// Records all sources, each on a thread of its own, into one session (`path`; its name is ".partial" behind
// until it is whole). Depth is compressed by workers and written, with all else, by the calling thread in the
// order of arrival. Live sources never wait: what finds no room is dropped and counted. InputError when two
// sensors have one name; a source that breaks is a notice, and the others go on.
CaptureSummary capture(const std::vector<std::unique_ptr<FrameSource>>& sources,
                       const std::filesystem::path& path, const CaptureOptions& options);

}  // namespace trilat
