// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

class ColumnRows;
class LineReader;

inline constexpr std::size_t kBlockBytes = 1 << 20;  // read from the disk at once

// Whether a file begins as a motion capture of one of the formats below, whatever follows.
bool begins_as_mocap(const std::filesystem::path& path);

// Streams a motion capture of any length with bounded memory: OptiTrack's exports (Motive's column format 1.2
// to 1.25), and the markers of TRC files; the content says which. Positions come out in metres. Lost bodies
// that an export writes as a frozen pose or at the origin are delivered as they stand; read_positions() finds
// them, and the summary the frozen ones.
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

// Some systems repeat the last pose of a rigid body or bone that they have lost instead of leaving it out.
// What is truly still shows its noise in the last digits, provided that the file has digits for it: a solved
// pose that has moved before and then stays the same to the bit is lost where steps elsewhere in the file are
// many times smaller than the noise of a body at rest, some 0.02 mm. Markers are measured, and missing when
// hidden: they are never lost in this way.
class FrozenPoses {
 public:
  explicit FrozenPoses(const MocapHeader& header);
  // How many of the asset's poses so far are newly known to be frozen, this one being the last of them: the
  // whole stretch when it has just become long enough, then one at a time.
  std::int64_t add(std::size_t asset, const MocapPose& pose, MocapTime time);

 private:
  struct Stretch {
    bool is_solved = false;
    bool seen = false, moved = false;  // before the stretch
    MocapPose pose;
    MocapTime start;
    std::int64_t frames = 0;
    bool frozen = false;
  };
  std::vector<Stretch> stretches_;  // by asset of the header
  double finest_step_m_;            // so far, of all assets
};

// Poses that are no measurement.
struct RemovedPoses {
  std::int64_t frozen = 0;
  std::int64_t at_origin = 0;  // exactly (0, 0, 0), which some exports write for "missing"
};

// The positions of some assets over a motion capture, by asset of the header and frame. NaN where an asset is
// missing, where it is frozen (the whole stretch, from its first frame on), and where it is exactly at the
// origin; assets that were not asked for have none.
struct MocapPositions {
  MocapHeader header;
  std::vector<MocapTime> time;  // of the frames, since the first
  double first_s = 0.0;         // the first frame's time as the file has it; 0 where it has none
  std::vector<std::vector<Eigen::Vector3d>> position_m;
  RemovedPoses removed;
  MocapAnomalies anomalies;
};

// Reads to the end, or through the first frame at `until`.
MocapPositions read_positions(MocapReader& reader, const std::vector<std::size_t>& assets,
                              MocapTime until = {std::numeric_limits<std::int64_t>::max()});

}  // namespace trilat
