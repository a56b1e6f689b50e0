// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

struct OptitrackReadOptions {
  std::size_t block_bytes = 1u << 20;  // how much is read at a time
};

// Reads an OptiTrack CSV export frame by frame with bounded memory: Motive's columns (format 1.2 to 1.25) and
// the row formats of Arena, Tracking Tools and early Motive (1.0, 1.1). Positions become metres, Euler angles
// quaternions (turned about the moving axes in the order named), left-handed worlds right-handed. InputError
// with `take.csv:17`.
class OptitrackCsvReader {
 public:
  explicit OptitrackCsvReader(const std::filesystem::path& path, const OptitrackReadOptions& options = {});
  ~OptitrackCsvReader();
  OptitrackCsvReader(OptitrackCsvReader&&) noexcept;

  const MocapHeader& header() const;
  // From now on only these assets are read; the poses of the others stay missing.
  void read_only(const std::vector<std::size_t>& assets);
  // False at the end of the file.
  bool next(MocapFrame& frame);
  const MocapAnomalies& anomalies() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The whole file in memory, for small ones.
struct MocapTake {
  MocapHeader header;
  std::vector<MocapFrame> frames;
  MocapAnomalies anomalies;
};
MocapTake read_optitrack_csv(const std::filesystem::path& path, const OptitrackReadOptions& options = {});

}  // namespace trilat
