// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

// Binary interface of the Kinect for Windows SDK 2.0, as far as it is used here. Names are the SDK's, so that
// its documentation applies; no Windows header is needed.
namespace trilat::kinect {

using HResult = std::int32_t;  // negative: failed
using WaitableHandle = std::intptr_t;
using Timespan = std::int64_t;  // 100 ns ticks from an arbitrary origin
using Boolean = std::uint8_t;   // BOOLEAN, not BOOL

inline constexpr HResult kOk = 0;
inline constexpr HResult kPending = static_cast<HResult>(0x8000000A);  // E_PENDING: no new frame yet
inline constexpr HResult kFailed = static_cast<HResult>(0x80004005);   // E_FAIL
inline constexpr HResult kNoInterface = static_cast<HResult>(0x80004002);

inline bool failed(HResult result) { return result < 0; }

inline constexpr std::uint32_t kFrameSourceDepth = 8;
inline constexpr std::uint32_t kFrameSourceBody = 32;
inline constexpr std::uint32_t kBodyCount = 6;
inline constexpr std::uint32_t kJointTypeCount = 25;
inline constexpr std::uint32_t kUniqueIdChars = 256;

struct Guid {
  std::uint32_t data1;
  std::uint16_t data2, data3;
  std::uint8_t data4[8];
  bool operator==(const Guid&) const = default;
};

struct Vector4 {
  float x, y, z, w;
};

struct CameraSpacePoint {
  float x, y, z;
};

struct Joint {
  std::int32_t joint_type;
  CameraSpacePoint position;
  std::int32_t tracking_state;
};

struct JointOrientation {
  std::int32_t joint_type;
  Vector4 orientation;
};

struct CameraIntrinsics {
  float focal_length_x, focal_length_y;
  float principal_point_x, principal_point_y;
  float radial_distortion_second_order, radial_distortion_fourth_order, radial_distortion_sixth_order;
};

static_assert(sizeof(Boolean) == 1 && sizeof(WaitableHandle) == sizeof(void*));
static_assert(sizeof(Guid) == 16 && offsetof(Guid, data4) == 8);
static_assert(sizeof(Vector4) == 16 && sizeof(CameraSpacePoint) == 12);
static_assert(sizeof(Joint) == 20 && offsetof(Joint, position) == 4 && offsetof(Joint, tracking_state) == 16);
static_assert(sizeof(JointOrientation) == 20 && offsetof(JointOrientation, orientation) == 4);
static_assert(sizeof(CameraIntrinsics) == 28 && offsetof(CameraIntrinsics, principal_point_x) == 8 &&
              offsetof(CameraIntrinsics, radial_distortion_second_order) == 16);

}  // namespace trilat::kinect
