// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

struct AssetSummary {
  std::int64_t samples = 0;                         // frames in which the asset has a position
  std::int64_t missing = 0;                         // frames in which it has none
  MissingCounts no_measurement;                     // samples that stand for what was not seen
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();  // of its positions, less the mean of all in the frame
};

struct MocapSummary {
  std::int64_t frames = 0;
  std::int64_t index_gaps = 0;       // places where the frame index skips
  std::int64_t skipped_frames = 0;   // indices skipped there
  double duration_s = 0.0;           // from the first frame to the last
  double rate_hz = kNaN;             // as stated; else frames over duration
  std::vector<AssetSummary> assets;  // as in the header
};

// The axis along which the assets' mean positions spread most: that which points up, when it is a person or a
// rig of markers on one. 'x', 'y' or 'z'; nothing when another axis is nearly as long.
struct LikelyUp {
  std::optional<char> axis;
  Eigen::Vector3d spread_m = Eigen::Vector3d::Constant(kNaN);
};
LikelyUp likely_up(const MocapSummary& summary);

// Summary of a take as it is written, with counts of what remove_missing() would take out.
MocapSummary summarize_mocap(MocapTake take);

}  // namespace trilat
