// SPDX-License-Identifier: MIT
#include "datasets/mocap/mocap_summary.h"

#include <algorithm>
#include <cmath>

#include "datasets/mocap/frozen_filter.h"

namespace trilat {
namespace {

bool is_sample(const MocapAsset& asset, const MocapPose& pose) {
  return asset.has_position ? pose.has_position() : pose.has_rotation();
}

bool is_sentinel(const MocapPose& pose) {
  return pose.has_position() && pose.position_m.isZero(0.0) && pose.rotation.vec().isZero(0.0) &&
         std::abs(pose.rotation.w()) == 1.0;
}

}  // namespace

MocapSummarizer::MocapSummarizer(const MocapHeader& header, const MocapSummaryOptions& options)
    : options_(options), header_(header), tracks_(header.assets.size()) {
  summary_.assets.resize(header.assets.size());
}

void MocapSummarizer::add(const MocapFrame& frame) {
  if (summary_.frames == 0) {
    summary_.first_index = frame.index;
    first_printed_s_ = frame.printed_time_s;
  } else if (frame.index > last_index_ + 1) {
    ++summary_.index_gaps;
    summary_.index_missing += static_cast<std::uint64_t>(frame.index - last_index_ - 1);
  }
  const double error_s =
      std::abs(frame.printed_time_s - first_printed_s_ - static_cast<double>(frame.time.ns) * 1e-9);
  if (std::isfinite(error_s))
    summary_.worst_printed_time_error_s = std::max(summary_.worst_printed_time_error_s, error_s);
  ++summary_.frames;
  last_index_ = frame.index;
  last_time_ = frame.time;
  for (std::size_t a = 0; a < tracks_.size(); ++a) add_sample(a, frame);
}

bool MocapSummarizer::is_frozen(const Track& track) const {
  return is_frozen_stretch(track.same, track.last_time - track.same_since, options_);
}

void MocapSummarizer::close_stretch(std::size_t asset) {
  if (is_frozen(tracks_[asset])) summary_.assets[asset].frozen += tracks_[asset].same;
  tracks_[asset].same = 0;
}

void MocapSummarizer::add_sample(std::size_t a, const MocapFrame& frame) {
  AssetSummary& summary = summary_.assets[a];
  Track& track = tracks_[a];
  const MocapPose& pose = frame.poses[a];
  if (!is_sample(header_.assets[a], pose)) {
    ++summary.missing;
    close_stretch(a);
    return;
  }
  ++summary.samples;
  if (is_sentinel(pose)) ++summary.sentinels;
  if (track.seen && track.same > 0 && same_pose(track.last, pose)) {
    ++track.same;
  } else {
    close_stretch(a);
    track.same = 1;
    track.same_since = frame.time;
  }
  if (track.seen) {
    const double step_s = (frame.time - track.last_time).seconds();
    const double moved_m = (pose.position_m - track.last.position_m).norm();
    if (moved_m > options_.jump_speed_m_s * step_s) ++summary.jumps;
    const double period_s = header_.rate_hz ? 1.0 / *header_.rate_hz : 0.0;
    if (step_s > 1.5 * period_s) summary.longest_gap_s = std::max(summary.longest_gap_s, step_s);
  }
  track.seen = true;
  track.last = pose;
  track.last_time = frame.time;
}

MocapSummary MocapSummarizer::finish() const {
  MocapSummary result = summary_;
  for (std::size_t a = 0; a < tracks_.size(); ++a)
    if (is_frozen(tracks_[a])) result.assets[a].frozen += tracks_[a].same;
  result.duration_s = static_cast<double>(last_time_.ns) * 1e-9;
  const double steps = static_cast<double>(result.frames) - 1.0;
  result.rate_hz = header_.rate_hz           ? *header_.rate_hz
                   : result.duration_s > 0.0 ? steps / result.duration_s
                                             : 0.0;
  return result;
}

}  // namespace trilat
