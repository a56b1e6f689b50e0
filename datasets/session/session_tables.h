// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_reader.h"

// The opened tables of one sensor of a session, for SessionReader.
namespace trilat {

inline constexpr std::uint64_t kBodyCheckpoint = 1024;  // frames between remembered body rows

struct StampColumns {
  H5Table sequence, device_ticks, arrival_ns;
  explicit StampColumns(const H5Node& node);
};

struct BodyColumns {
  H5Table frame, tracking_id, position_m, orientation, tracking_state, hand_state, hand_confidence;
  explicit BodyColumns(const H5Node& node);
};

struct SensorTables {
  StampColumns body_stamps;
  H5Table floor_plane, body_count;
  BodyColumns bodies;
  std::optional<StampColumns> depth_stamps;
  std::optional<H5Table> depth_frames;
  H5Table clock_exchanges, drop_counts;
  H5Table notice_host_ns, notice_text;
  std::vector<std::uint64_t> body_row_at;  // of every kBodyCheckpoint-th frame
  SensorCounts counts;
};

// Opens everything and counts the rows that belong together. Unless the session is `complete`, these are
// limited to what its writer said to have flushed, and chunks that it was rewriting when it died are
// accepted.
SensorTables open_sensor_tables(const H5Node& sensor, bool complete);

}  // namespace trilat
