// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_summary.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "datasets/base/error.h"
#include "datasets/mocap/mocap_reader.h"

namespace trilat {
namespace {

constexpr double kJumpSpeed_m_s =
    20.0;  // a foot of a sprinter is as fast, no body part of a person in a room is

}  // namespace

MocapSummarizer::MocapSummarizer(const MocapHeader& header)
    : rate_is_stated_(!std::isnan(header.export_rate_hz)), tracks_(header.assets.size()) {
  summary_.rate_hz = header.export_rate_hz;
  summary_.assets.resize(header.assets.size());
}

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

void MocapSummarizer::add(const MocapFrame& frame) {
  TRILAT_CHECK(frame.poses.size() == tracks_.size(), "a frame has a pose for each asset");
  const bool skips = summary_.frames > 0 && frame.index - last_index_ > 1;
  add_time(frame);
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  double positions = 0.0;
  for (const MocapPose& pose : frame.poses)
    if (pose.has_position()) {
      mean_m += pose.position_m;
      positions += 1.0;
    }
  mean_m /= positions;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    AssetSummary& counts = summary_.assets[i];
    const MocapPose& pose = frame.poses[i];
    track.missed = track.missed || skips || !pose.has_position();
    if (pose.has_position()) {
      counts.sum_m += pose.position_m - mean_m;
      add_sample(pose, frame.time, track, counts);
    } else {
      ++counts.missing;
    }
  }
}

void MocapSummarizer::add_time(const MocapFrame& frame) {
  if (summary_.frames > 0 && frame.index - last_index_ > 1) {
    ++summary_.index_gaps;
    summary_.skipped_frames += frame.index - last_index_ - 1;
  }
  ++summary_.frames;
  last_index_ = frame.index;
  summary_.duration_s = (frame.time - MocapTime{}).seconds();
  if (!rate_is_stated_ && summary_.duration_s > 0.0)
    summary_.rate_hz = static_cast<double>(summary_.frames - 1) / summary_.duration_s;
  if (std::isnan(frame.printed_time_s)) return;
  if (std::isnan(first_printed_s_)) {
    first_printed_s_ = frame.printed_time_s - summary_.duration_s;
    summary_.largest_time_error_s = 0.0;
  }
  summary_.largest_time_error_s = std::max(
      summary_.largest_time_error_s, std::abs(frame.printed_time_s - first_printed_s_ - summary_.duration_s));
}

void MocapSummarizer::add_sample(const MocapPose& pose, MocapTime time, Track& track, AssetSummary& counts) {
  ++counts.samples;
  if (track.seen) {
    const double since_s = (time - track.last_time).seconds();
    const double distance_m = (pose.position_m - track.last_pose.position_m).norm();
    if (distance_m > kJumpSpeed_m_s * since_s) ++counts.jumps;
    if (track.missed) counts.longest_gap_s = std::max(counts.longest_gap_s, since_s);
  }
  track.seen = true;
  track.missed = false;
  track.last_pose = pose;
  track.last_time = time;
}

MocapSummary summarize_mocap(MocapReader& reader) {
  MocapSummarizer summarizer(reader.header());
  MocapPositions positions;
  positions.position_m.resize(reader.header().assets.size());
  MocapFrame frame;
  while (reader.next(frame)) {
    summarizer.add(frame);
    positions.time.push_back(frame.time);
    for (std::size_t i = 0; i < frame.poses.size(); ++i)
      positions.position_m[i].push_back(frame.poses[i].position_m);
  }
  MocapSummary summary = summarizer.finish();
  const std::vector<MissingCounts> missing = remove_missing(positions.time, positions.position_m);
  for (std::size_t i = 0; i < missing.size(); ++i) summary.assets[i].no_measurement = missing[i];
  return summary;
}

}  // namespace trilat
