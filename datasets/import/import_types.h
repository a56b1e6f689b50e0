// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/hdf5/chunk_codec.h"

namespace trilat {

struct ImportOptions {
  std::optional<double> rate_hz{};        // frames a second where the files do not say when a frame was made
  std::optional<double> depth_unit_mm{};  // of depth images: what a value of 1 means
  std::filesystem::path
      timestamps{};             // of depth images: one time in seconds a line, in the order of the names
  bool time_from_name = false;  // of depth images: the last number in a name is its time in seconds
  ChunkCompression compression = ChunkCompression::blosc;
  // Called with the share done, in [0, 1]; what it throws ends the import.
  std::function<void(double)> progress{};
};

// What of a recording is not in the session, and why.
struct LeftOut {
  std::int64_t torn_rows = 0;       // cut short, unreadable or damaged
  std::int64_t repeated_times = 0;  // the same time stamp as the frame before
  std::int64_t backward_times = 0;  // an earlier one
  std::string first{};              // place and problem of the first of them

  std::int64_t total() const { return torn_rows + repeated_times + backward_times; }
};

struct ImportedSensor {
  std::string name;
  std::string file;
  std::int64_t body_frames = 0;
  std::int64_t bodies = 0;
  std::int64_t depth_frames = 0;
  std::int64_t gap_frames = 0;      // frames that the time stamps say are missing in between
  std::int64_t skipped_events = 0;  // of streams that a session does not hold: infrared, colour, sound
  std::int64_t skipped_bytes = 0;   // of damage that was stepped over
  std::optional<double> intrinsics_rms_px{};  // nothing: the intrinsics are a default
  LeftOut left_out{};
};

struct ImportReport {
  std::string note;  // what was assumed; stands in the session too
  std::vector<ImportedSensor> sensors;
};

// A row or frame that is no use. It is counted, and reading goes on behind it.
struct TornRow {
  std::string problem;
};

}  // namespace trilat
