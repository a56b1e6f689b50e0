// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <vector>

#include "datasets/mocap/mocap_summary.h"
#include "datasets/mocap/optitrack_csv_reader.h"

namespace trilat {

// Equal to the last bit, missing parts included.
bool same_pose(const MocapPose& a, const MocapPose& b);

// Whether `samples` equal samples that span `length` are a frozen stretch.
bool is_frozen_stretch(std::uint64_t samples, Duration length, const MocapSummaryOptions& options);

// Frames of a reader in which frozen poses are missing. Looks ahead by the length of the shortest frozen
// stretch, so that a stretch is left out from its beginning. A frozen pose is no measurement.
class FrozenFilter {
 public:
  FrozenFilter(OptitrackCsvReader& reader, const MocapSummaryOptions& options);
  bool next(MocapFrame& frame);
  std::uint64_t samples_removed() const { return removed_; }

 private:
  struct Track {
    std::uint64_t same = 0;
    MocapTime since;
    MocapPose last;
  };
  bool read_one();
  void look_at(std::size_t asset);
  void remove(MocapPose& pose);

  OptitrackCsvReader* reader_;
  MocapSummaryOptions options_;
  std::deque<MocapFrame> ahead_;
  std::vector<Track> tracks_;
  bool ended_ = false;
  std::uint64_t removed_ = 0;
};

}  // namespace trilat
