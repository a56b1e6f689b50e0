// SPDX-License-Identifier: MIT
#include "datasets/mocap/frozen_filter.h"

#include <cstring>
#include <utility>

namespace trilat {

namespace {

bool same_bits(const MocapPose& a, const MocapPose& b) {
  return std::memcmp(a.position_m.data(), b.position_m.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.rotation.coeffs().data(), b.rotation.coeffs().data(), 4 * sizeof(double)) == 0;
}

}  // namespace

FrozenFilter::FrozenFilter(MocapReader& reader, FrozenOptions options)
    : reader_(reader),
      options_(options),
      stretches_(reader.header().assets.size()),
      removed_(stretches_.size(), 0) {}

// A stretch through the oldest frame has by now either ended or become long enough.
bool FrozenFilter::is_decided() const {
  return ended_ || (static_cast<std::int64_t>(held_.size()) >= options_.min_frames &&
                    held_.back().time - held_.front().time >= duration_from_s(options_.min_s));
}

bool FrozenFilter::read_one() {
  if (!reader_.next(frame_)) return false;
  held_.push_back(frame_);
  for (std::size_t i = 0; i < stretches_.size(); ++i) {
    const bool sentinel = frame_.poses[i].position_m.isZero(0.0);
    if (sentinel) {
      held_.back().poses[i] = MocapPose();
      ++removed_[i];
    }
    const bool present = !sentinel && frame_.poses[i].is_present(reader_.header().assets[i]);
    const std::int64_t count = stretches_[i].add(frame_.poses[i], present, frame_.time, options_);
    removed_[i] += count;
    for (std::int64_t back = 1; back <= count; ++back)
      held_[held_.size() - static_cast<std::size_t>(back)].poses[i] = MocapPose();
  }
  return true;
}

bool FrozenFilter::next(MocapFrame& frame) {
  while (held_.empty() || !is_decided()) {
    if (ended_) return false;
    ended_ = !read_one();
  }
  std::swap(frame, held_.front());
  held_.pop_front();
  return true;
}

std::int64_t FrozenStretch::add(const MocapPose& pose, bool present, MocapTime time,
                                const FrozenOptions& options) {
  if (!present) {
    frames_ = 0;
    return 0;
  }
  if (frames_ == 0 || !same_bits(pose, pose_)) {
    pose_ = pose;
    start_ = time;
    frames_ = 1;
    frozen_ = false;
    return 0;
  }
  ++frames_;
  if (frozen_) return 1;
  frozen_ = frames_ >= options.min_frames && time - start_ >= duration_from_s(options.min_s);
  return frozen_ ? frames_ : 0;
}

}  // namespace trilat
