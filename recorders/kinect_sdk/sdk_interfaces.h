// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace trilat::kinect {

using HResult = std::int32_t;  // negative: failed
using WaitableHandle = std::intptr_t;
using Timespan = std::int64_t;  // 100 ns ticks from an arbitrary origin
using Boolean = std::uint8_t;   // BOOLEAN, not BOOL

inline constexpr HResult kOk = 0;
inline constexpr HResult kPending = static_cast<HResult>(0x8000000A);  // E_PENDING: no new frame yet
inline constexpr HResult kFailed = static_cast<HResult>(0x80004005);   // E_FAIL

inline bool failed(HResult result) { return result < 0; }

inline constexpr std::uint32_t kFrameSourceDepth = 8;
inline constexpr std::uint32_t kFrameSourceBody = 32;
inline constexpr std::uint32_t kBodyCount = 6;
inline constexpr std::uint32_t kJointTypeCount = 25;
inline constexpr std::uint32_t kUniqueIdChars = 256;

struct Vector4 {
  float x, y, z, w;
};

struct CameraSpacePoint {
  float x, y, z;
};

struct PointF {
  float x, y;
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
static_assert(sizeof(Vector4) == 16 && sizeof(CameraSpacePoint) == 12);
static_assert(sizeof(Joint) == 20 && offsetof(Joint, position) == 4 && offsetof(Joint, tracking_state) == 16);
static_assert(sizeof(JointOrientation) == 20 && offsetof(JointOrientation, orientation) == 4);
static_assert(sizeof(CameraIntrinsics) == 28 && offsetof(CameraIntrinsics, principal_point_x) == 8 &&
              offsetof(CameraIntrinsics, radial_distortion_second_order) == 16);

// Owns one reference to a COM object.
template <class Interface>
class ComPointer {
 public:
  ComPointer() = default;
  ~ComPointer() { reset(); }
  ComPointer(const ComPointer&) = delete;
  ComPointer& operator=(const ComPointer&) = delete;

  // For a function that hands a reference over.
  Interface** put() {
    reset();
    return &object_;
  }
  void reset() {
    if (Interface* object = std::exchange(object_, nullptr)) object->Release();
  }
  Interface* operator->() const { return object_; }
  Interface& operator*() const { return *object_; }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  Interface* object_ = nullptr;
};

// The order of the functions is that of the SDK's tables and must not change. Those without parameters are
// never called, but for Open, Close, AddRef and Release; they only hold their place.
struct IUnknown {
  virtual HResult QueryInterface() = 0;
  virtual std::uint32_t AddRef() = 0;
  virtual std::uint32_t Release() = 0;

 protected:
  ~IUnknown() = default;
};

struct IDepthFrame : IUnknown {
  virtual HResult CopyFrameDataToArray(std::uint32_t capacity, std::uint16_t* depth_mm) = 0;
  virtual HResult AccessUnderlyingBuffer() = 0;
  virtual HResult get_FrameDescription() = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;
  virtual HResult get_DepthFrameSource() = 0;
  virtual HResult get_DepthMinReliableDistance() = 0;
  virtual HResult get_DepthMaxReliableDistance() = 0;

 protected:
  ~IDepthFrame() = default;
};

struct IDepthFrameReference : IUnknown {
  virtual HResult AcquireFrame(IDepthFrame** frame) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;

 protected:
  ~IDepthFrameReference() = default;
};

struct IBody : IUnknown {
  virtual HResult GetJoints(std::uint32_t capacity, Joint* joints) = 0;
  virtual HResult GetJointOrientations(std::uint32_t capacity, JointOrientation* orientations) = 0;
  virtual HResult get_Engaged() = 0;
  virtual HResult GetExpressionDetectionResults() = 0;
  virtual HResult GetActivityDetectionResults() = 0;
  virtual HResult GetAppearanceDetectionResults() = 0;
  virtual HResult get_HandLeftState(std::int32_t* state) = 0;
  virtual HResult get_HandLeftConfidence(std::int32_t* confidence) = 0;
  virtual HResult get_HandRightState(std::int32_t* state) = 0;
  virtual HResult get_HandRightConfidence(std::int32_t* confidence) = 0;
  virtual HResult get_ClippedEdges() = 0;
  virtual HResult get_TrackingId(std::uint64_t* id) = 0;
  virtual HResult get_IsTracked(Boolean* tracked) = 0;
  virtual HResult get_IsRestricted() = 0;
  virtual HResult get_Lean() = 0;
  virtual HResult get_LeanTrackingState() = 0;

 protected:
  ~IBody() = default;
};

struct IBodyFrame : IUnknown {
  virtual HResult GetAndRefreshBodyData(std::uint32_t capacity, IBody** bodies) = 0;
  virtual HResult get_FloorClipPlane(Vector4* plane) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;
  virtual HResult get_BodyFrameSource() = 0;

 protected:
  ~IBodyFrame() = default;
};

struct IBodyFrameReference : IUnknown {
  virtual HResult AcquireFrame(IBodyFrame** frame) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;

 protected:
  ~IBodyFrameReference() = default;
};

struct IMultiSourceFrame : IUnknown {
  virtual HResult get_ColorFrameReference() = 0;
  virtual HResult get_DepthFrameReference(IDepthFrameReference** reference) = 0;
  virtual HResult get_BodyFrameReference(IBodyFrameReference** reference) = 0;
  virtual HResult get_BodyIndexFrameReference() = 0;
  virtual HResult get_InfraredFrameReference() = 0;
  virtual HResult get_LongExposureInfraredFrameReference() = 0;

 protected:
  ~IMultiSourceFrame() = default;
};

struct IMultiSourceFrameReference : IUnknown {
  virtual HResult AcquireFrame(IMultiSourceFrame** frame) = 0;

 protected:
  ~IMultiSourceFrameReference() = default;
};

struct IMultiSourceFrameArrivedEventArgs : IUnknown {
  virtual HResult get_FrameReference(IMultiSourceFrameReference** reference) = 0;

 protected:
  ~IMultiSourceFrameArrivedEventArgs() = default;
};

struct IMultiSourceFrameReader : IUnknown {
  virtual HResult SubscribeMultiSourceFrameArrived(WaitableHandle* handle) = 0;
  virtual HResult UnsubscribeMultiSourceFrameArrived(WaitableHandle handle) = 0;
  virtual HResult GetMultiSourceFrameArrivedEventData(WaitableHandle handle,
                                                      IMultiSourceFrameArrivedEventArgs** event) = 0;
  virtual HResult AcquireLatestFrame(IMultiSourceFrame** frame) = 0;
  virtual HResult get_FrameSourceTypes() = 0;
  virtual HResult get_IsPaused() = 0;
  virtual HResult put_IsPaused() = 0;
  virtual HResult get_KinectSensor() = 0;

 protected:
  ~IMultiSourceFrameReader() = default;
};

struct ICoordinateMapper : IUnknown {
  virtual HResult SubscribeCoordinateMappingChanged() = 0;
  virtual HResult UnsubscribeCoordinateMappingChanged() = 0;
  virtual HResult GetCoordinateMappingChangedEventData() = 0;
  virtual HResult MapCameraPointToDepthSpace() = 0;
  virtual HResult MapCameraPointToColorSpace() = 0;
  virtual HResult MapDepthPointToCameraSpace() = 0;
  virtual HResult MapDepthPointToColorSpace() = 0;
  virtual HResult MapCameraPointsToDepthSpace() = 0;
  virtual HResult MapCameraPointsToColorSpace() = 0;
  virtual HResult MapDepthPointsToCameraSpace() = 0;
  virtual HResult MapDepthPointsToColorSpace() = 0;
  virtual HResult MapDepthFrameToCameraSpace() = 0;
  virtual HResult MapDepthFrameToColorSpace() = 0;
  virtual HResult MapColorFrameToDepthSpace() = 0;
  virtual HResult MapColorFrameToCameraSpace() = 0;
  // A ray a pixel of the depth frame, at z = 1; the caller frees it.
  virtual HResult GetDepthFrameToCameraSpaceTable(std::uint32_t* entries, PointF** rays) = 0;
  virtual HResult GetDepthCameraIntrinsics(CameraIntrinsics* intrinsics) = 0;

 protected:
  ~ICoordinateMapper() = default;
};

struct IKinectSensor : IUnknown {
  virtual HResult SubscribeIsAvailableChanged() = 0;
  virtual HResult UnsubscribeIsAvailableChanged() = 0;
  virtual HResult GetIsAvailableChangedEventData() = 0;
  virtual HResult Open() = 0;
  virtual HResult Close() = 0;
  virtual HResult get_IsOpen() = 0;
  virtual HResult get_IsAvailable(Boolean* available) = 0;
  virtual HResult get_ColorFrameSource() = 0;
  virtual HResult get_DepthFrameSource() = 0;
  virtual HResult get_BodyFrameSource() = 0;
  virtual HResult get_BodyIndexFrameSource() = 0;
  virtual HResult get_InfraredFrameSource() = 0;
  virtual HResult get_LongExposureInfraredFrameSource() = 0;
  virtual HResult get_AudioSource() = 0;
  virtual HResult OpenMultiSourceFrameReader(std::uint32_t sources, IMultiSourceFrameReader** reader) = 0;
  virtual HResult get_CoordinateMapper(ICoordinateMapper** mapper) = 0;
  virtual HResult get_UniqueKinectId(std::uint32_t capacity, char16_t* id) = 0;
  virtual HResult get_KinectCapabilities() = 0;

 protected:
  ~IKinectSensor() = default;
};

}  // namespace trilat::kinect
