// SPDX-License-Identifier: MIT
#include "datasets/mocap/frozen.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "datasets/base/check.h"

namespace trilat {
namespace {

bool same_bits(const MocapPose& a, const MocapPose& b) {
  return std::memcmp(a.position_m.data(), b.position_m.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.world_from_asset.coeffs().data(), b.world_from_asset.coeffs().data(),
                     4 * sizeof(double)) == 0;
}

}  // namespace

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

FrozenFilter::FrozenFilter(std::vector<MocapAsset> assets, FrozenOptions options)
    : assets_(std::move(assets)),
      options_(options),
      stretches_(assets_.size()),
      frozen_(assets_.size(), 0) {}

void FrozenFilter::push(const MocapFrame& frame) {
  TRILAT_CHECK(frame.poses.size() == assets_.size(), "a frame has a pose for each asset");
  held_.push_back(frame);
  for (std::size_t i = 0; i < assets_.size(); ++i) {
    const std::int64_t count = stretches_[i].add(
        frame.poses[i], frame.poses[i].is_present(assets_[i]), frame.time, options_);
    frozen_[i] += count;
    for (std::int64_t back = 1; back <= count; ++back)
      held_[held_.size() - static_cast<std::size_t>(back)].poses[i] = MocapPose();
  }
}

bool FrozenFilter::pop(MocapFrame& frame) {
  if (held_.empty()) return false;
  // A stretch through the oldest frame has either ended or become long enough by now.
  const bool decided = static_cast<std::int64_t>(held_.size()) >= options_.min_frames &&
                       held_.back().time - held_.front().time >= duration_from_s(options_.min_s);
  if (!decided && !finished_) return false;
  std::swap(frame, held_.front());
  held_.pop_front();
  return true;
}

}  // namespace trilat
