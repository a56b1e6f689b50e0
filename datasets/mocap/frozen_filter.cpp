// SPDX-License-Identifier: MIT
#include "datasets/mocap/frozen_filter.h"

#include <cstring>

namespace trilat {
namespace {

bool same_bits(const double* a, const double* b, int count) {
  for (int i = 0; i < count; ++i)
    if (!(a[i] == b[i] || (a[i] != a[i] && b[i] != b[i]))) return false;
  return true;
}

bool is_missing(const MocapPose& pose) { return !pose.has_position() && !pose.has_rotation(); }

}  // namespace

bool same_pose(const MocapPose& a, const MocapPose& b) {
  return same_bits(a.position_m.data(), b.position_m.data(), 3) &&
         same_bits(a.rotation.coeffs().data(), b.rotation.coeffs().data(), 4);
}

bool is_frozen_stretch(std::uint64_t samples, Duration length, const MocapSummaryOptions& options) {
  return samples >= static_cast<std::uint64_t>(options.frozen_frames) && length.seconds() >= options.frozen_s;
}

FrozenFilter::FrozenFilter(OptitrackCsvReader& reader, const MocapSummaryOptions& options)
    : reader_(&reader), options_(options), tracks_(reader.header().assets.size()) {}

void FrozenFilter::remove(MocapPose& pose) {
  if (is_missing(pose)) return;
  pose = MocapPose{};
  ++removed_;
}

// Follows one asset into the newest frame ahead.
void FrozenFilter::look_at(std::size_t a) {
  Track& track = tracks_[a];
  MocapFrame& newest = ahead_.back();
  const MocapPose pose = newest.poses[a];
  if (is_missing(pose)) {
    track.same = 0;
    return;
  }
  if (track.same == 0 || !same_pose(pose, track.last)) {
    track = {1, newest.time, pose};
    return;
  }
  ++track.same;
  if (!is_frozen_stretch(track.same, newest.time - track.since, options_)) return;
  for (auto frame = ahead_.rbegin(); frame != ahead_.rend() && frame->time >= track.since; ++frame)
    remove(frame->poses[a]);
}

bool FrozenFilter::read_one() {
  MocapFrame frame;
  if (ended_ || !reader_->next(frame)) {
    ended_ = true;
    return false;
  }
  ahead_.push_back(std::move(frame));
  for (std::size_t a = 0; a < tracks_.size(); ++a) look_at(a);
  return true;
}

bool FrozenFilter::next(MocapFrame& frame) {
  const auto far_enough = [&] {
    return ahead_.size() > static_cast<std::size_t>(options_.frozen_frames) &&
           (ahead_.back().time - ahead_.front().time).seconds() > options_.frozen_s;
  };
  while (!far_enough() && read_one()) {
  }
  if (ahead_.empty()) return false;
  frame = std::move(ahead_.front());
  ahead_.pop_front();
  return true;
}

}  // namespace trilat
