// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "datasets/mocap/mocap_take.h"

namespace trilat {

// Some exports repeat the last pose of a lost body instead of leaving it out. The noise of a body
// that is truly still shows in the last digits, so a pose that stays the same to the bit is lost.
struct FrozenOptions {
  double min_s = 0.095;         // from the first to the last frame of the stretch
  std::int64_t min_frames = 5;  // and at least so many
};

// Follows one asset frame by frame.
class FrozenStretch {
 public:
  // How many of the frames so far are newly known to be frozen, this one being the last of them:
  // the whole stretch when it has just become long enough, then one at a time.
  std::int64_t add(const MocapPose& pose, bool present, MocapTime time, const FrozenOptions& options);

 private:
  MocapPose pose_;
  MocapTime start_;
  std::int64_t frames_ = 0;
  bool frozen_ = false;
};

}  // namespace trilat
