// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <limits>
#include <optional>
#include <string_view>
#include <thread>

#include "datasets/rig/depth_camera.h"
#include "datasets/session/session_types.h"
#include "recorders/kinect_sdk/kinect_source.h"
#include "tests/recorders/fake_kinect_tables.h"

namespace trilat::kinect::fake {

// What one exposure delivers; a part without a time cannot be acquired.
struct Exposure {
  std::optional<Timespan> depth_time;
  std::optional<Timespan> body_time;
  std::uint16_t depth_mm = 1000;
  bool tracked = false;
  bool pending = false;  // the frame as a whole cannot be acquired any more
};

struct Desk {
  std::deque<Exposure> exposures;
  double rays_right_px = 0.0, rays_down_px = 0.0;  // of the table beside the intrinsics
  bool has_rays = true, knows_rays = true;
  int tables_held = 0;
  bool available = true;
  bool intrinsics_known = true;
  int bodies_made = 0;
};

struct DepthFrame : IDepthFrameTable {
  explicit DepthFrame(const Exposure& e) : exposure(e) {}
  HResult CopyFrameDataToArray(std::uint32_t capacity, std::uint16_t* depth_mm) override {
    if (capacity != kDepthPixels) return kFailed;
    for (std::uint32_t i = 0; i < capacity; ++i) depth_mm[i] = exposure.depth_mm;
    return kOk;
  }
  HResult get_RelativeTime(Timespan* time) override { return *time = *exposure.depth_time, kOk; }
  Exposure exposure;
};

struct DepthReference : IDepthFrameReferenceTable {
  explicit DepthReference(const Exposure& e) : exposure(e) {}
  HResult AcquireFrame(IDepthFrame** frame) override {
    if (!exposure.depth_time) return kPending;
    return *frame = new DepthFrame(exposure), kOk;
  }
  Exposure exposure;
};

// Joint j of slot s stands at (s, j, 2); the left hand is a lasso with high confidence, the right one closed.
struct TrackedBody : IBodyTable {
  explicit TrackedBody(int s) : slot(s) {}
  HResult GetJoints(std::uint32_t capacity, Joint* joints) override {
    if (capacity != kJointTypeCount) return kFailed;
    for (std::int32_t j = 0; j < 25; ++j)
      joints[j] = {j, {static_cast<float>(slot), static_cast<float>(j), 2.0f}, j % 3};
    return kOk;
  }
  HResult GetJointOrientations(std::uint32_t capacity, JointOrientation* turns) override {
    if (capacity != kJointTypeCount) return kFailed;
    for (std::int32_t j = 0; j < 25; ++j) turns[j] = {j, {0.0f, 0.6f, 0.0f, 0.8f}};
    return kOk;
  }
  HResult get_HandLeftState(std::int32_t* state) override { return *state = 4, kOk; }
  HResult get_HandLeftConfidence(std::int32_t* confidence) override { return *confidence = 1, kOk; }
  HResult get_HandRightState(std::int32_t* state) override { return *state = 3, kOk; }
  HResult get_HandRightConfidence(std::int32_t* confidence) override { return *confidence = 0, kOk; }
  HResult get_TrackingId(std::uint64_t* id) override {
    return *id = (std::uint64_t{1} << 56) + static_cast<std::uint64_t>(slot), kOk;
  }
  HResult get_IsTracked(Boolean* is) override { return *is = tracked ? 1 : 0, kOk; }
  int slot;
  bool tracked = false;
};

struct BodyFrame : IBodyFrameTable {
  BodyFrame(const Exposure& e, Desk& d) : exposure(e), desk(d) {}
  HResult GetAndRefreshBodyData(std::uint32_t capacity, IBody** bodies) override {
    if (capacity != kBodyCount) return kFailed;
    for (int s = 0; s < 6; ++s) {
      if (!bodies[s]) {
        bodies[s] = new TrackedBody(s);
        ++desk.bodies_made;
      }
      static_cast<TrackedBody*>(bodies[s])->tracked = exposure.tracked && s == 2;
    }
    return kOk;
  }
  HResult get_FloorClipPlane(Vector4* plane) override { return *plane = {0.0f, 1.0f, 0.0f, 0.75f}, kOk; }
  HResult get_RelativeTime(Timespan* time) override { return *time = *exposure.body_time, kOk; }
  Exposure exposure;
  Desk& desk;
};

struct BodyReference : IBodyFrameReferenceTable {
  BodyReference(const Exposure& e, Desk& d) : exposure(e), desk(d) {}
  HResult AcquireFrame(IBodyFrame** frame) override {
    if (!exposure.body_time) return kPending;
    return *frame = new BodyFrame(exposure, desk), kOk;
  }
  Exposure exposure;
  Desk& desk;
};

struct MultiFrame : IMultiSourceFrameTable {
  MultiFrame(const Exposure& e, Desk& d) : exposure(e), desk(d) {}
  HResult get_DepthFrameReference(IDepthFrameReference** r) override {
    return *r = new DepthReference(exposure), kOk;
  }
  HResult get_BodyFrameReference(IBodyFrameReference** r) override {
    return *r = new BodyReference(exposure, desk), kOk;
  }
  Exposure exposure;
  Desk& desk;
};

struct MultiReference : IMultiSourceFrameReferenceTable {
  MultiReference(const Exposure& e, Desk& d) : exposure(e), desk(d) {}
  HResult AcquireFrame(IMultiSourceFrame** frame) override {
    if (exposure.pending) return kPending;
    return *frame = new MultiFrame(exposure, desk), kOk;
  }
  Exposure exposure;
  Desk& desk;
};

struct Arrival : IMultiSourceFrameArrivedEventArgsTable {
  Arrival(const Exposure& e, Desk& d) : exposure(e), desk(d) {}
  HResult get_FrameReference(IMultiSourceFrameReference** r) override {
    return *r = new MultiReference(exposure, desk), kOk;
  }
  Exposure exposure;
  Desk& desk;
};

struct Reader : IMultiSourceFrameReaderTable {
  explicit Reader(Desk& d) : desk(d) {}
  HResult SubscribeMultiSourceFrameArrived(WaitableHandle* handle) override { return *handle = 77, kOk; }
  HResult UnsubscribeMultiSourceFrameArrived(WaitableHandle) override { return kOk; }
  HResult GetMultiSourceFrameArrivedEventData(WaitableHandle handle,
                                              IMultiSourceFrameArrivedEventArgs** event) override {
    if (handle != 77 || desk.exposures.empty()) return kFailed;
    *event = new Arrival(desk.exposures.front(), desk);
    desk.exposures.pop_front();
    return kOk;
  }
  Desk& desk;
};

struct Mapper : ICoordinateMapperTable {
  explicit Mapper(Desk& d) : desk(d) {}
  HResult GetDepthCameraIntrinsics(CameraIntrinsics* in) override {
    *in = desk.intrinsics_known ? CameraIntrinsics{365.5f, 366.5f, 255.0f, 207.0f, 0.09f, -0.27f, 0.1f}
                                : CameraIntrinsics{};
    return kOk;
  }
  HResult GetDepthFrameToCameraSpaceTable(std::uint32_t* entries, PointF** rays) override {
    if (!desk.has_rays) return kFailed;
    DepthIntrinsics in;
    in.fx_px = 365.5, in.fy_px = 366.5, in.k1 = 0.09, in.k2 = -0.27, in.k3 = 0.1;
    in.cx_px = 255.0 + desk.rays_right_px, in.cy_px = 207.0 + desk.rays_down_px;
    *entries = kDepthPixels;
    *rays = new PointF[kDepthPixels];
    ++desk.tables_held;
    for (int v = 0; v < in.height_px; ++v)
      for (int u = 0; u < in.width_px; ++u) {
        const auto ray = ray_through(in, {u, v});
        const float unknown = -std::numeric_limits<float>::infinity();
        (*rays)[v * in.width_px + u] =
            ray && desk.knows_rays ? PointF{static_cast<float>(ray->x()), static_cast<float>(ray->y())}
                                   : PointF{unknown, unknown};
      }
    return kOk;
  }
  Desk& desk;
};

struct Sensor : IKinectSensorTable {
  explicit Sensor(Desk& d) : desk(d) {}
  HResult Open() override { return kOk; }
  HResult Close() override { return kOk; }
  HResult get_IsAvailable(Boolean* available) override { return *available = desk.available ? 1 : 0, kOk; }
  HResult OpenMultiSourceFrameReader(std::uint32_t sources, IMultiSourceFrameReader** reader) override {
    if (sources != (kFrameSourceDepth | kFrameSourceBody)) return kFailed;
    return *reader = new Reader(desk), kOk;
  }
  HResult get_CoordinateMapper(ICoordinateMapper** mapper) override {
    return *mapper = new Mapper(desk), kOk;
  }
  HResult get_UniqueKinectId(std::uint32_t capacity, char16_t* id) override {
    constexpr std::u16string_view kSerial = u"012345678947";
    if (capacity <= kSerial.size() || capacity >= kinect::kUniqueIdChars)
      return kFailed;  // and a zero behind
    kSerial.copy(id, kSerial.size());
    return kOk;
  }
  Desk& desk;
};

// The desk outlives what is made of the runtime.
inline KinectRuntime runtime_of(Desk& desk) {
  return {[&desk](IKinectSensor** sensor) { return *sensor = new Sensor(desk), kOk; },
          [&desk](WaitableHandle, std::chrono::milliseconds) {
            if (!desk.exposures.empty()) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return false;
          },
          [&desk](void* memory) {
            --desk.tables_held;
            delete[] static_cast<PointF*>(memory);
          }};
}

}  // namespace trilat::kinect::fake
