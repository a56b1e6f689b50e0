// SPDX-License-Identifier: MIT
#include "datasets/mocap/frozen_stretch.h"

#include <cstring>

namespace trilat {
namespace {

bool same_bits(const MocapPose& a, const MocapPose& b) {
  return std::memcmp(a.position_m.data(), b.position_m.data(), 3 * sizeof(double)) == 0 &&
         std::memcmp(a.rotation.coeffs().data(), b.rotation.coeffs().data(), 4 * sizeof(double)) == 0;
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

}  // namespace trilat
