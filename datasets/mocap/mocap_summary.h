// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/mocap/mocap_reader.h"
#include "datasets/mocap/mocap_take.h"

namespace trilat {

struct AssetSummary {
  std::int64_t samples = 0;                         // frames in which the asset has a position
  std::int64_t missing = 0;                         // frames in which it has none
  MissingCounts no_measurement;                     // samples that stand for what was not seen
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();  // of its positions, less the mean of all in the frame
  std::int64_t jumps = 0;                           // steps from one sample to the next faster than 20 m/s
  // Longest time between two neighbouring samples with a frame missing between them; what is missing before
  // the first and after the last sample does not count.
  double longest_gap_s = 0.0;
};

struct MocapSummary {
  std::int64_t frames = 0;
  std::int64_t index_gaps = 0;             // places where the frame index skips
  std::int64_t skipped_frames = 0;         // indices skipped there
  double duration_s = 0.0;                 // from the first frame to the last
  double rate_hz = kMissing;               // as stated; else frames over duration
  double largest_time_error_s = kMissing;  // of the printed time against the delivered one
  std::vector<AssetSummary> assets;        // as in the header
};

// The axis along which the assets' mean positions spread most: that which points up, when it is a person or a
// rig of markers on one. 'x', 'y' or 'z'; nothing when another axis is nearly as long.
struct LikelyUp {
  std::optional<char> axis;
  Eigen::Vector3d spread_m = Eigen::Vector3d::Constant(kMissing);
};
LikelyUp likely_up(const MocapSummary& summary);

// Accumulates a summary frame by frame; summarize_mocap() fills in the counts of `no_measurement`.
class MocapSummarizer {
 public:
  explicit MocapSummarizer(const MocapHeader& header);
  void add(const MocapFrame& frame);
  const MocapSummary& finish() const { return summary_; }

 private:
  struct Track {
    bool seen = false;
    bool missed = false;  // since the last sample
    MocapPose last_pose;
    MocapTime last_time;
  };

  void add_time(const MocapFrame& frame);
  static void add_sample(const MocapPose& pose, MocapTime time, Track& track, AssetSummary& counts);

  bool rate_is_stated_ = false;
  MocapSummary summary_;
  std::vector<Track> tracks_;
  std::int64_t last_index_ = 0;
  double first_printed_s_ = kMissing;
};

// Reads to the end.
MocapSummary summarize_mocap(MocapReader& reader);

}  // namespace trilat
