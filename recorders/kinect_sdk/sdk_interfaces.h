// SPDX-License-Identifier: MIT
#pragma once

#include "recorders/kinect_sdk/sdk_types.h"

// The order of the functions is that of the SDK's tables and must not change. Those without parameters are
// never called, but for Open and Close; they only hold their place.
namespace trilat::kinect {

struct IUnknown {
  virtual HResult QueryInterface(const Guid& id, void** out) = 0;
  virtual std::uint32_t AddRef() = 0;
  virtual std::uint32_t Release() = 0;

 protected:
  ~IUnknown() = default;
};

struct IDepthFrame : IUnknown {
  static constexpr Guid kId{0xD8600853, 0x8835, 0x44F9, {0x84, 0xA7, 0xE6, 0x17, 0xCD, 0xD7, 0xDF, 0xDD}};
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
  static constexpr Guid kId{0x20621E5E, 0xABC9, 0x4EBD, {0xA7, 0xEE, 0x4C, 0x77, 0xED, 0xD0, 0x15, 0x2A}};
  virtual HResult AcquireFrame(IDepthFrame** frame) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;

 protected:
  ~IDepthFrameReference() = default;
};

struct IBody : IUnknown {
  static constexpr Guid kId{0x46AEF731, 0x98B0, 0x4D18, {0x82, 0x7B, 0x93, 0x37, 0x58, 0x67, 0x8F, 0x4A}};
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
  static constexpr Guid kId{0x52884F1F, 0x94D7, 0x4B57, {0xBF, 0x87, 0x92, 0x26, 0x95, 0x09, 0x80, 0xD5}};
  virtual HResult GetAndRefreshBodyData(std::uint32_t capacity, IBody** bodies) = 0;
  virtual HResult get_FloorClipPlane(Vector4* plane) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;
  virtual HResult get_BodyFrameSource() = 0;

 protected:
  ~IBodyFrame() = default;
};

struct IBodyFrameReference : IUnknown {
  static constexpr Guid kId{0xC3A1733C, 0x5F84, 0x443B, {0x96, 0x59, 0x2F, 0x2B, 0xE2, 0x50, 0xC9, 0x7D}};
  virtual HResult AcquireFrame(IBodyFrame** frame) = 0;
  virtual HResult get_RelativeTime(Timespan* time) = 0;

 protected:
  ~IBodyFrameReference() = default;
};

struct IMultiSourceFrame : IUnknown {
  static constexpr Guid kId{0x29A63AFB, 0x76CE, 0x4359, {0x89, 0x5A, 0x99, 0x7F, 0x1E, 0x09, 0x4D, 0x1C}};
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
  static constexpr Guid kId{0xDD70E845, 0xE283, 0x4DD1, {0x8D, 0xAF, 0xFC, 0x25, 0x9A, 0xC5, 0xF9, 0xE3}};
  virtual HResult AcquireFrame(IMultiSourceFrame** frame) = 0;

 protected:
  ~IMultiSourceFrameReference() = default;
};

struct IMultiSourceFrameArrivedEventArgs : IUnknown {
  static constexpr Guid kId{0x3532F40B, 0xD908, 0x451D, {0xBB, 0xF4, 0x6C, 0xA7, 0x3B, 0x78, 0x25, 0x58}};
  virtual HResult get_FrameReference(IMultiSourceFrameReference** reference) = 0;

 protected:
  ~IMultiSourceFrameArrivedEventArgs() = default;
};

struct IMultiSourceFrameReader : IUnknown {
  static constexpr Guid kId{0xC0F6432B, 0x9FFE, 0x4AB3, {0xA6, 0x83, 0xF3, 0x7C, 0x72, 0xBB, 0xB1, 0x58}};
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
  static constexpr Guid kId{0x8784DF2D, 0x16B0, 0x481C, {0xA1, 0x1E, 0x55, 0xE7, 0x0B, 0xF2, 0x50, 0x18}};
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
  virtual HResult GetDepthFrameToCameraSpaceTable() = 0;
  virtual HResult GetDepthCameraIntrinsics(CameraIntrinsics* intrinsics) = 0;

 protected:
  ~ICoordinateMapper() = default;
};

struct IKinectSensor : IUnknown {
  static constexpr Guid kId{0x3C6EBA94, 0x0DE1, 0x4360, {0xB6, 0xD4, 0x65, 0x3A, 0x10, 0x79, 0x4C, 0x8B}};
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
