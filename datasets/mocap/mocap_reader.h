// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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

// Streams a motion capture of any length with bounded memory: OptiTrack's exports (Motive's column format 1.2
// to 1.25 and the row formats 1.0 and 1.1), and the markers of TRC and C3D files; the content says which.
// Poses come out right-handed in metres: units are converted, Euler angles become quaternions, and a
// left-handed file is mirrored in z. Lost bodies that an export writes as a frozen pose or a sentinel are
// delivered as they stand; the summary and the frozen filter find them.
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

  // The next frame; times strictly increase. False at the end. InputError with the place and the asset when a
  // number makes no sense, and when the file of a format that promises a count ends early. Reuse one frame
  // for all calls: then nothing is allocated.
  bool next(MocapFrame& frame);

  // Counted so far.
  const MocapAnomalies& anomalies() const { return anomalies_; }

 private:
  std::unique_ptr<LineReader> lines_;
  MocapHeader header_;
  std::unique_ptr<RowSource> rows_;
  MocapAnomalies anomalies_;
};

// Some exports repeat the last pose of a lost body instead of leaving it out. The noise of a body that is
// truly still shows in the last digits, so a pose that stays the same to the bit is lost.
struct FrozenOptions {
  double min_s = 0.095;         // from the first to the last frame of the stretch
  std::int64_t min_frames = 5;  // and at least so many
};

// Follows one asset frame by frame.
class FrozenStretch {
 public:
  // How many of the frames so far are newly known to be frozen, this one being the last of them:
  // the whole stretch when it has just become long enough, then one at a time.
  std::int64_t add(const MocapPose& pose, bool present, MocapTime time, const FrozenOptions& options);

 private:
  MocapPose pose_;
  MocapTime start_;
  std::int64_t frames_ = 0;
  bool frozen_ = false;
};

// The frames of a reader in which every frozen pose is missing, from its first frame on, and so is one
// exactly at the origin, which some exports write for "lost": neither is a measurement. Reads ahead, and
// holds, no more than one shortest stretch.
class FrozenFilter {
 public:
  explicit FrozenFilter(MocapReader& reader, FrozenOptions options = {});
  bool next(MocapFrame& frame);
  // Poses taken out so far, for each asset of the header; a little ahead of the frames given.
  const std::vector<std::int64_t>& removed() const { return removed_; }

 private:
  bool is_decided() const;
  bool read_one();

  MocapReader& reader_;
  FrozenOptions options_;
  std::vector<FrozenStretch> stretches_;
  std::vector<std::int64_t> removed_;
  std::deque<MocapFrame> held_;
  MocapFrame frame_;
  bool ended_ = false;
};

}  // namespace trilat
