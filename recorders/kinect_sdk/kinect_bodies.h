// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "datasets/session/session_types.h"
#include "recorders/kinect_sdk/sdk_interfaces.h"

namespace trilat::kinect {

// The SDK's six body objects, which it makes once and fills anew for every frame. One thread at a time.
class KinectBodies {
 public:
  KinectBodies() = default;
  ~KinectBodies();
  KinectBodies(const KinectBodies&) = delete;
  KinectBodies& operator=(const KinectBodies&) = delete;

  // False where the frame gives no bodies.
  bool refresh(IBodyFrame& frame);
  // The tracked ones of the last refresh(), as the SDK gives them.
  std::vector<Body> tracked() const;

 private:
  std::array<IBody*, kBodyCount> slots_{};
};

}  // namespace trilat::kinect
