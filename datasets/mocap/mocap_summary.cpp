// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_summary.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "datasets/mocap/missing_positions.h"

namespace trilat {
namespace {

AssetSummary summary_of(const std::vector<Eigen::Vector3d>& position_m,
                        const std::vector<Eigen::Vector3d>& middle_m) {
  AssetSummary counts;
  for (std::size_t f = 0; f < position_m.size(); ++f) {
    if (!position_m[f].allFinite()) {
      ++counts.missing;
      continue;
    }
    ++counts.samples;
    counts.sum_m += position_m[f] - middle_m[f];
  }
  return counts;
}

// The mean of all assets that are there in a frame.
std::vector<Eigen::Vector3d> middles_of(const MocapTake& take) {
  std::vector<Eigen::Vector3d> middle_m(take.time.size());
  for (std::size_t f = 0; f < middle_m.size(); ++f) {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const std::vector<Eigen::Vector3d>& position_m : take.position_m)
      if (position_m[f].allFinite()) {
        sum_m += position_m[f];
        count += 1.0;
      }
    middle_m[f] = sum_m / count;
  }
  return middle_m;
}

}  // namespace

LikelyUp likely_up(const MocapSummary& summary) {
  constexpr double kTimes = 1.5;  // as long as the next axis
  Eigen::AlignedBox3d box;
  for (const AssetSummary& asset : summary.assets)
    if (asset.samples > 0) box.extend(Eigen::Vector3d(asset.sum_m / static_cast<double>(asset.samples)));
  LikelyUp up;
  if (box.isEmpty()) return up;
  up.spread_m = box.sizes();
  Eigen::Index longest = 0;
  const double most_m = up.spread_m.maxCoeff(&longest);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (axis != longest && !(most_m > kTimes * up.spread_m[axis])) return up;
  up.axis = "xyz"[longest];
  return up;
}

MocapSummary summarize_mocap(MocapTake take) {
  MocapSummary summary;
  summary.frames = std::ssize(take.time);
  for (std::size_t f = 1; f < take.frame.size(); ++f)
    if (const std::int64_t skipped = take.frame[f] - take.frame[f - 1] - 1; skipped > 0) {
      ++summary.index_gaps;
      summary.skipped_frames += skipped;
    }
  if (!take.time.empty()) summary.duration_s = (take.time.back() - take.time.front()).seconds();
  summary.rate_hz = take.header.export_rate_hz;
  if (std::isnan(summary.rate_hz) && summary.duration_s > 0.0)
    summary.rate_hz = static_cast<double>(summary.frames - 1) / summary.duration_s;
  const std::vector<Eigen::Vector3d> middle_m = middles_of(take);
  for (const std::vector<Eigen::Vector3d>& position_m : take.position_m)
    summary.assets.push_back(summary_of(position_m, middle_m));
  const std::vector<MissingCounts> missing = remove_missing(take.time, take.position_m);
  for (std::size_t i = 0; i < missing.size(); ++i) summary.assets[i].no_measurement = missing[i];
  return summary;
}

}  // namespace trilat
