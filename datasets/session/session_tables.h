// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/hdf5/hdf5_file.h"
#include "datasets/session/session_layout.h"
#include "datasets/session/session_reader.h"

// The opened tables of one sensor of a session, for SessionReader.
namespace trilat {

inline constexpr std::uint64_t kBodyCheckpoint = 1024;  // frames between remembered body rows

// An opened column.
template <class T>
struct ReadColumn {
  H5Table table;

  void open(const H5Node& node, const char* name, const std::vector<std::uint64_t>& row_shape) {
    table = node.table(name, h5_type_of<T>(), row_shape);
  }
  std::vector<T> read(std::uint64_t first, std::uint64_t count) const {
    std::vector<T> values(count * table.row_elements());
    table.read(first, std::span<T>(values));
    return values;
  }
  const std::string& place() const { return table.place(); }
};

struct SensorTables {
  session_layout::BodyFrames<ReadColumn> frames;
  session_layout::Bodies<ReadColumn> bodies;
  std::optional<session_layout::Stamps<ReadColumn>> depth_stamps;
  std::optional<H5Table> depth_frames;
  session_layout::Lists<ReadColumn> lists;
  session_layout::Notices<ReadColumn> notices;
  std::vector<std::uint64_t> body_row_at;  // of every kBodyCheckpoint-th frame
  SensorCounts counts;
};

// Opens everything and counts the rows that belong together. Unless the session is `complete`, these are
// limited to what its writer said to have flushed, and chunks that it was rewriting when it died are
// accepted.
SensorTables open_sensor_tables(const H5Node& sensor, bool complete);

}  // namespace trilat
