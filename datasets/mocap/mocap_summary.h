// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

struct MocapSummaryOptions {
  // A pose that stays the same to the last digit this long, and for at least five frames, is frozen: a lost
  // body whose last pose is repeated. A body that truly stands still shows noise.
  double frozen_s = 0.1;
  int frozen_frames = 5;
  double jump_speed_m_s = 20.0;  // two neighbouring samples farther apart than this speed allows are a jump
};

struct AssetSummary {
  std::uint64_t samples = 0;  // frames with a position (or, without one, a rotation)
  std::uint64_t missing = 0;
  std::uint64_t frozen = 0;  // samples inside frozen stretches
  std::uint64_t jumps = 0;
  std::uint64_t sentinels = 0;  // samples at the exact origin with the rotation (0, 0, 0, +-1)
  double longest_gap_s = 0.0;   // without samples, between two samples
};

struct MocapSummary {
  std::uint64_t frames = 0;
  std::uint64_t index_gaps = 0;     // places where frame numbers leave some out
  std::uint64_t index_missing = 0;  // frame numbers left out
  std::int64_t first_index = 0;
  double duration_s = 0.0;                  // first to last frame
  double rate_hz = 0.0;                     // stated, or measured where none is stated
  double worst_printed_time_error_s = 0.0;  // printed time against frame number and rate
  std::vector<AssetSummary> assets;
};

// Gathers a summary frame by frame.
class MocapSummarizer {
 public:
  MocapSummarizer(const MocapHeader& header, const MocapSummaryOptions& options);
  void add(const MocapFrame& frame);
  MocapSummary finish() const;

 private:
  struct Track {
    bool seen = false;
    MocapTime last_time;
    MocapPose last;
    std::uint64_t same = 0;  // samples equal to the last one, itself included
    MocapTime same_since;
  };
  void add_sample(std::size_t asset, const MocapFrame& frame);
  void close_stretch(std::size_t asset);
  bool is_frozen(const Track& track) const;

  MocapSummaryOptions options_;
  MocapHeader header_;
  MocapSummary summary_;
  std::vector<Track> tracks_;
  std::int64_t last_index_ = 0;
  MocapTime last_time_;
  double first_printed_s_ = 0.0;
};

}  // namespace trilat
