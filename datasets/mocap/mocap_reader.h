// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "datasets/mocap/missing_positions.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

class ColumnRows;
class LineReader;

inline constexpr std::size_t kBlockBytes = 1 << 20;  // read from the disk at once

// Whether a file begins as a motion capture of one of the formats below, whatever follows.
bool begins_as_mocap(const std::filesystem::path& path);

// Streams a motion capture of any length with bounded memory: OptiTrack's exports (Motive's column format 1.2
// to 1.25), and the markers of TRC files; the content says which. Positions come out in metres. What an
// export writes for lost bodies is delivered as it stands; read_positions() finds it.
class MocapReader {
 public:
  // Reads the header. InputError when the file cannot be opened or is in none of these formats.
  explicit MocapReader(const std::filesystem::path& path, std::size_t block_bytes = kBlockBytes);
  ~MocapReader();
  MocapReader(const MocapReader&) = delete;
  MocapReader& operator=(const MocapReader&) = delete;

  const MocapHeader& header() const { return header_; }

  // From now on the poses of the other assets stay missing; their columns are skipped unread.
  void read_only(const std::vector<std::size_t>& assets);

  // The next frame; times strictly increase. False at the end. InputError with the place and the asset when a
  // number makes no sense, and when the file of a format that promises a count ends early. Reuse one frame
  // for all calls: then nothing is allocated.
  bool next(MocapFrame& frame);

  // Counted so far.
  const MocapAnomalies& anomalies() const { return anomalies_; }

 private:
  std::unique_ptr<LineReader> lines_;
  MocapHeader header_;
  std::unique_ptr<ColumnRows> rows_;
  MocapAnomalies anomalies_;
};

// The positions of some assets over a motion capture, by asset of the header and frame. NaN where an asset is
// missing, also where remove_missing() says so; assets that were not asked for have none.
struct MocapPositions {
  MocapHeader header;
  std::vector<MocapTime> time;  // of the frames, since the first
  double first_s = 0.0;         // the first frame's time as the file has it; 0 where it has none
  std::vector<std::vector<Eigen::Vector3d>> position_m;
  std::vector<MissingCounts> missing;  // by asset
  MocapAnomalies anomalies;
  std::vector<std::string>
      taken_as;  // what of the file is read in another way than it is written, a sentence each
};

// Reads to the end, or through the first frame at `until`.
MocapPositions read_positions(MocapReader& reader, const std::vector<std::size_t>& assets,
                              MocapTime until = {std::numeric_limits<std::int64_t>::max()});

}  // namespace trilat
