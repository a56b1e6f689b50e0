// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

#include "recorders/kinect_sdk/sdk_interfaces.h"

// Objects with the SDK's tables, each function of which fails until a fake overrides it. Who calls one that
// only holds its place gets a failure as well.
namespace trilat::kinect::fake {

inline std::atomic<int> live_objects{0};

template <class Interface>
struct Object : Interface {
  Object() { ++live_objects; }
  virtual ~Object() { --live_objects; }
  HResult QueryInterface() override { return kFailed; }
  std::uint32_t AddRef() override { return ++references_; }
  std::uint32_t Release() override {
    const std::uint32_t left = --references_;
    if (left == 0) delete this;
    return left;
  }

 private:
  std::uint32_t references_ = 1;
};

struct IDepthFrameTable : Object<IDepthFrame> {
  HResult CopyFrameDataToArray(std::uint32_t, std::uint16_t*) override { return kFailed; }
  HResult AccessUnderlyingBuffer() override { return kFailed; }
  HResult get_FrameDescription() override { return kFailed; }
  HResult get_RelativeTime(Timespan*) override { return kFailed; }
  HResult get_DepthFrameSource() override { return kFailed; }
  HResult get_DepthMinReliableDistance() override { return kFailed; }
  HResult get_DepthMaxReliableDistance() override { return kFailed; }
};

struct IDepthFrameReferenceTable : Object<IDepthFrameReference> {
  HResult AcquireFrame(IDepthFrame**) override { return kFailed; }
  HResult get_RelativeTime(Timespan*) override { return kFailed; }
};

struct IBodyTable : Object<IBody> {
  HResult GetJoints(std::uint32_t, Joint*) override { return kFailed; }
  HResult GetJointOrientations(std::uint32_t, JointOrientation*) override { return kFailed; }
  HResult get_Engaged() override { return kFailed; }
  HResult GetExpressionDetectionResults() override { return kFailed; }
  HResult GetActivityDetectionResults() override { return kFailed; }
  HResult GetAppearanceDetectionResults() override { return kFailed; }
  HResult get_HandLeftState(std::int32_t*) override { return kFailed; }
  HResult get_HandLeftConfidence(std::int32_t*) override { return kFailed; }
  HResult get_HandRightState(std::int32_t*) override { return kFailed; }
  HResult get_HandRightConfidence(std::int32_t*) override { return kFailed; }
  HResult get_ClippedEdges() override { return kFailed; }
  HResult get_TrackingId(std::uint64_t*) override { return kFailed; }
  HResult get_IsTracked(Boolean*) override { return kFailed; }
  HResult get_IsRestricted() override { return kFailed; }
  HResult get_Lean() override { return kFailed; }
  HResult get_LeanTrackingState() override { return kFailed; }
};

struct IBodyFrameTable : Object<IBodyFrame> {
  HResult GetAndRefreshBodyData(std::uint32_t, IBody**) override { return kFailed; }
  HResult get_FloorClipPlane(Vector4*) override { return kFailed; }
  HResult get_RelativeTime(Timespan*) override { return kFailed; }
  HResult get_BodyFrameSource() override { return kFailed; }
};

struct IBodyFrameReferenceTable : Object<IBodyFrameReference> {
  HResult AcquireFrame(IBodyFrame**) override { return kFailed; }
  HResult get_RelativeTime(Timespan*) override { return kFailed; }
};

struct IMultiSourceFrameTable : Object<IMultiSourceFrame> {
  HResult get_ColorFrameReference() override { return kFailed; }
  HResult get_DepthFrameReference(IDepthFrameReference**) override { return kFailed; }
  HResult get_BodyFrameReference(IBodyFrameReference**) override { return kFailed; }
  HResult get_BodyIndexFrameReference() override { return kFailed; }
  HResult get_InfraredFrameReference() override { return kFailed; }
  HResult get_LongExposureInfraredFrameReference() override { return kFailed; }
};

struct IMultiSourceFrameReferenceTable : Object<IMultiSourceFrameReference> {
  HResult AcquireFrame(IMultiSourceFrame**) override { return kFailed; }
};

struct IMultiSourceFrameArrivedEventArgsTable : Object<IMultiSourceFrameArrivedEventArgs> {
  HResult get_FrameReference(IMultiSourceFrameReference**) override { return kFailed; }
};

struct IMultiSourceFrameReaderTable : Object<IMultiSourceFrameReader> {
  HResult SubscribeMultiSourceFrameArrived(WaitableHandle*) override { return kFailed; }
  HResult UnsubscribeMultiSourceFrameArrived(WaitableHandle) override { return kFailed; }
  HResult GetMultiSourceFrameArrivedEventData(WaitableHandle, IMultiSourceFrameArrivedEventArgs**) override {
    return kFailed;
  }
  HResult AcquireLatestFrame(IMultiSourceFrame**) override { return kFailed; }
  HResult get_FrameSourceTypes() override { return kFailed; }
  HResult get_IsPaused() override { return kFailed; }
  HResult put_IsPaused() override { return kFailed; }
  HResult get_KinectSensor() override { return kFailed; }
};

struct ICoordinateMapperTable : Object<ICoordinateMapper> {
  HResult SubscribeCoordinateMappingChanged() override { return kFailed; }
  HResult UnsubscribeCoordinateMappingChanged() override { return kFailed; }
  HResult GetCoordinateMappingChangedEventData() override { return kFailed; }
  HResult MapCameraPointToDepthSpace() override { return kFailed; }
  HResult MapCameraPointToColorSpace() override { return kFailed; }
  HResult MapDepthPointToCameraSpace() override { return kFailed; }
  HResult MapDepthPointToColorSpace() override { return kFailed; }
  HResult MapCameraPointsToDepthSpace() override { return kFailed; }
  HResult MapCameraPointsToColorSpace() override { return kFailed; }
  HResult MapDepthPointsToCameraSpace() override { return kFailed; }
  HResult MapDepthPointsToColorSpace() override { return kFailed; }
  HResult MapDepthFrameToCameraSpace() override { return kFailed; }
  HResult MapDepthFrameToColorSpace() override { return kFailed; }
  HResult MapColorFrameToDepthSpace() override { return kFailed; }
  HResult MapColorFrameToCameraSpace() override { return kFailed; }
  HResult GetDepthFrameToCameraSpaceTable(std::uint32_t*, PointF**) override { return kFailed; }
  HResult GetDepthCameraIntrinsics(CameraIntrinsics*) override { return kFailed; }
};

struct IKinectSensorTable : Object<IKinectSensor> {
  HResult SubscribeIsAvailableChanged() override { return kFailed; }
  HResult UnsubscribeIsAvailableChanged() override { return kFailed; }
  HResult GetIsAvailableChangedEventData() override { return kFailed; }
  HResult Open() override { return kFailed; }
  HResult Close() override { return kFailed; }
  HResult get_IsOpen() override { return kFailed; }
  HResult get_IsAvailable(Boolean*) override { return kFailed; }
  HResult get_ColorFrameSource() override { return kFailed; }
  HResult get_DepthFrameSource() override { return kFailed; }
  HResult get_BodyFrameSource() override { return kFailed; }
  HResult get_BodyIndexFrameSource() override { return kFailed; }
  HResult get_InfraredFrameSource() override { return kFailed; }
  HResult get_LongExposureInfraredFrameSource() override { return kFailed; }
  HResult get_AudioSource() override { return kFailed; }
  HResult OpenMultiSourceFrameReader(std::uint32_t, IMultiSourceFrameReader**) override { return kFailed; }
  HResult get_CoordinateMapper(ICoordinateMapper**) override { return kFailed; }
  HResult get_UniqueKinectId(std::uint32_t, char16_t*) override { return kFailed; }
  HResult get_KinectCapabilities() override { return kFailed; }
};

}  // namespace trilat::kinect::fake
