// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

class LineReader;
class RowSource;

struct MocapReadOptions {
  std::size_t block_bytes = 1 << 20;  // read from the disk at once
};

// Streams a motion capture of any length with bounded memory: OptiTrack's exports (Motive's column
// format 1.2 to 1.25 and the row formats 1.0 and 1.1), and the markers of TRC and C3D
// files; the content says which. Poses come out right-handed in metres: units are
// converted, Euler angles become quaternions, and a left-handed file is mirrored in z. Lost bodies
// that an export writes as a frozen pose or a sentinel are delivered as they stand; the summary
// and the frozen filter find them.
class MocapReader {
 public:
  // Reads the header. InputError when the file cannot be opened or is in none of these formats.
  explicit MocapReader(const std::filesystem::path& path, MocapReadOptions options = {});
  ~MocapReader();
  MocapReader(const MocapReader&) = delete;
  MocapReader& operator=(const MocapReader&) = delete;

  const MocapHeader& header() const { return header_; }

  // From now on the poses of the other assets stay missing; their columns are skipped unread.
  void read_only(const std::vector<std::size_t>& assets);

  // The next frame; times strictly increase. False at the end. InputError with the place and the
  // asset when a number makes no sense, and when the file of a format that promises a count ends early. Reuse
  // one frame for all calls: then nothing is allocated.
  bool next(MocapFrame& frame);

  // Counted so far.
  const MocapAnomalies& anomalies() const { return anomalies_; }

 private:
  std::unique_ptr<LineReader> lines_;
  MocapHeader header_;
  std::unique_ptr<RowSource> rows_;
  MocapAnomalies anomalies_;
};

}  // namespace trilat
