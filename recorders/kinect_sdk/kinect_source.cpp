// SPDX-License-Identifier: MIT
#include "recorders/kinect_sdk/kinect_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "datasets/base/error.h"
#include "datasets/rig/depth_camera.h"
#include "recorders/frame_source.h"

namespace trilat {
namespace {

using kinect::ComPointer;
using kinect::failed;

constexpr const char* kPlace = "the source kinect";
constexpr std::int64_t kPeriodTicks = 333'333;
enum Stream : std::size_t { kDepthStream, kBodyStream, kStreams };

void require(kinect::HResult result, const char* what) {
  if (!failed(result)) return;
  char code[16];
  std::snprintf(code, sizeof code, "0x%08X", static_cast<unsigned>(result));
  throw InputError(kPlace, std::string(what) + " (" + code + ")");
}

std::string ascii_of(const char16_t* text) {
  std::string result;
  for (; *text; ++text) result.push_back(*text < 0x7f ? static_cast<char>(*text) : '?');
  return result;
}

// Offset of the table's pixels from those of the intrinsics, in pixels right and down: the median over the
// middle of the image. Nothing where half of the rays leave it by more than half a pixel.
std::optional<std::array<double, 2>> shift_of_rays(std::span<const kinect::PointF> rays,
                                                   const DepthIntrinsics& in) {
  constexpr int kMargin = 64, kStep = 8;
  constexpr double kMaxSpread_px = 0.5;
  std::array<std::vector<double>, 2> shifts_px;
  for (int v = kMargin; v < in.height_px - kMargin; v += kStep)
    for (int u = kMargin; u < in.width_px - kMargin; u += kStep) {
      const kinect::PointF ray = rays[static_cast<std::size_t>(v * in.width_px + u)];
      if (!std::isfinite(ray.x) || !std::isfinite(ray.y)) continue;
      const auto pixel_px = project(in, {ray.x, ray.y, 1.0});
      if (!pixel_px) continue;
      shifts_px[0].push_back(u - pixel_px->x());
      shifts_px[1].push_back(v - pixel_px->y());
    }
  std::array<double, 2> shift{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<double>& values = shifts_px[axis];
    if (values.empty()) return std::nullopt;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    shift[axis] = *middle;
    for (double& value : values) value = std::abs(value - shift[axis]);
    std::ranges::nth_element(values, middle);
    if (*middle > kMaxSpread_px) return std::nullopt;
  }
  return shift;
}

}  // namespace

KinectSource::KinectSource(kinect::KinectRuntime runtime, KinectOptions options)
    : runtime_(std::move(runtime)), options_(options), sequence_(kStreams, kPeriodTicks) {
  open();
  describe();
}

KinectSource::~KinectSource() {
  if (reader_ && arrived_) reader_->UnsubscribeMultiSourceFrameArrived(arrived_);
  reader_.reset();
  if (sensor_) sensor_->Close();
}

void KinectSource::open() {
  require(runtime_.default_sensor(sensor_.put()), "the runtime gives no sensor");
  require(sensor_->Open(), "the sensor cannot be opened");
  require(sensor_->OpenMultiSourceFrameReader(kinect::kFrameSourceDepth | kinect::kFrameSourceBody,
                                              reader_.put()),
          "depth and bodies cannot be read");
  require(reader_->SubscribeMultiSourceFrameArrived(&arrived_), "there is no event for new frames");
}

void KinectSource::describe() {
  SensorDescription sensor;
  sensor.name = "kinect";
  sensor.source = "kinect-sdk";
  sensor.has_depth = true;
  const std::int64_t deadline_ns =
      host_now_ns() + std::chrono::nanoseconds(options_.first_frame_limit).count();
  bool frames_came = false;
  for (;;) {
    if (runtime_.wait(arrived_, kPollPeriod)) take_frame();
    frames_came = frames_came || has_frame();
    ready_.clear();
    lost_ = 0;  // before the recording
    if (frames_came && read_intrinsics(sensor.intrinsics)) break;
    if (host_now_ns() < deadline_ns) continue;
    throw InputError(kPlace, frames_came   ? "the sensor does not tell its intrinsics"
                             : available() ? "the sensor is there, but no frame came"
                                           : "no sensor is available: is it plugged into USB 3 and powered?");
  }
  char16_t id[kinect::kUniqueIdChars] = {};
  if (!failed(sensor_->get_UniqueKinectId(kinect::kUniqueIdChars - 1, id))) sensor.serial = ascii_of(id);
  header_.sensors.push_back(sensor);
}

// False while the SDK reports zeros, as it does until the sensor has delivered.
bool KinectSource::read_intrinsics(DepthIntrinsics& intrinsics) {
  ComPointer<kinect::ICoordinateMapper> mapper;
  kinect::CameraIntrinsics read{};
  if (failed(sensor_->get_CoordinateMapper(mapper.put())) || failed(mapper->GetDepthCameraIntrinsics(&read)))
    return false;
  if (read.focal_length_x == 0.0f || read.focal_length_y == 0.0f) return false;
  intrinsics.fx_px = read.focal_length_x;
  intrinsics.fy_px = read.focal_length_y;
  intrinsics.cx_px = read.principal_point_x;
  intrinsics.cy_px = read.principal_point_y;
  intrinsics.k1 = read.radial_distortion_second_order;
  intrinsics.k2 = read.radial_distortion_fourth_order;
  intrinsics.k3 = read.radial_distortion_sixth_order;
  move_principal_point(*mapper, intrinsics);
  return true;
}

// The SDK does not say whether its principal point counts pixels from their centres or their corners; its
// table of a ray a pixel does.
void KinectSource::move_principal_point(kinect::ICoordinateMapper& mapper, DepthIntrinsics& intrinsics) {
  std::uint32_t entries = 0;
  kinect::PointF* rays = nullptr;
  if (failed(mapper.GetDepthFrameToCameraSpaceTable(&entries, &rays)) || !rays) return;
  const auto shift = entries == kDepthPixels ? shift_of_rays({rays, entries}, intrinsics) : std::nullopt;
  runtime_.free(rays);
  if (!shift) {
    ready_.push_back(
        {0, SourceNotice{"the SDK's table of rays is not that of its intrinsics, which are kept"}});
    return;
  }
  constexpr double kNotable_px = 0.1;
  if (std::hypot((*shift)[0], (*shift)[1]) > kNotable_px) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "the SDK's table of rays moves its principal point (%.2f, %.2f) by (%.2f, %.2f) pixels",
                  intrinsics.cx_px, intrinsics.cy_px, (*shift)[0], (*shift)[1]);
    ready_.push_back({0, SourceNotice{text}});
  }
  intrinsics.cx_px += (*shift)[0];
  intrinsics.cy_px += (*shift)[1];
}

bool KinectSource::available() {
  kinect::Boolean available = 0;
  return !failed(sensor_->get_IsAvailable(&available)) && available != 0;
}

std::optional<SourceEvent> KinectSource::next() {
  if (last_frame_ns_ == 0) last_frame_ns_ = host_now_ns();
  while (ready_.empty() && !stopped_) {
    if (runtime_.wait(arrived_, kPollPeriod)) take_frame();
    check_silence();
  }
  if (ready_.empty()) return std::nullopt;
  SourceEvent event = std::move(ready_.front());
  ready_.pop_front();
  return event;
}

// Frames that could not be acquired, of both streams together. One that was replaced before leaves a gap in
// the numbers as well, of which the recorder counts the larger.
void KinectSource::lose(std::int64_t frames) {
  lost_ += frames;
  ready_.push_back({0, DropCount{host_now_ns(), lost_, 0}});
}

void KinectSource::take_frame() {
  const std::int64_t arrival_ns = host_now_ns();
  ComPointer<kinect::IMultiSourceFrameArrivedEventArgs> event;
  ComPointer<kinect::IMultiSourceFrameReference> reference;
  ComPointer<kinect::IMultiSourceFrame> frame;
  if (failed(reader_->GetMultiSourceFrameArrivedEventData(arrived_, event.put())) ||
      failed(event->get_FrameReference(reference.put())) || failed(reference->AcquireFrame(frame.put())))
    return lose(kStreams);
  take_depth(*frame, arrival_ns);
  take_bodies(*frame, arrival_ns);
}

void KinectSource::take_depth(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns) {
  ComPointer<kinect::IDepthFrameReference> reference;
  ComPointer<kinect::IDepthFrame> depth;
  kinect::Timespan ticks = 0;
  DepthFrame result;
  result.depth_mm.resize(kDepthPixels);
  if (failed(frame.get_DepthFrameReference(reference.put())) ||
      failed(reference->AcquireFrame(depth.put())) || failed(depth->get_RelativeTime(&ticks)) ||
      failed(depth->CopyFrameDataToArray(kDepthPixels, result.depth_mm.data())))
    return lose(1);
  depth.reset();
  result.stamp = {sequence_.number_of(kDepthStream, ticks), ticks, arrival_ns};
  ready_.push_back({0, std::move(result)});
}

void KinectSource::take_bodies(kinect::IMultiSourceFrame& frame, std::int64_t arrival_ns) {
  ComPointer<kinect::IBodyFrameReference> reference;
  ComPointer<kinect::IBodyFrame> bodies;
  kinect::Timespan ticks = 0;
  if (failed(frame.get_BodyFrameReference(reference.put())) ||
      failed(reference->AcquireFrame(bodies.put())) || failed(bodies->get_RelativeTime(&ticks)) ||
      !bodies_.refresh(*bodies))
    return lose(1);
  BodyFrame result;
  kinect::Vector4 floor{};
  if (!failed(bodies->get_FloorClipPlane(&floor))) result.floor_plane = {floor.x, floor.y, floor.z, floor.w};
  bodies.reset();
  result.stamp = {sequence_.number_of(kBodyStream, ticks), ticks, arrival_ns};
  result.bodies = bodies_.tracked();
  ready_.push_back({0, std::move(result)});
}

bool KinectSource::has_frame() const {
  return std::ranges::any_of(ready_, [](const SourceEvent& event) {
    return std::holds_alternative<DepthFrame>(event.data) || std::holds_alternative<BodyFrame>(event.data);
  });
}

void KinectSource::check_silence() {
  const std::int64_t now_ns = host_now_ns();
  if (has_frame()) {
    last_frame_ns_ = now_ns;
    if (std::exchange(said_, {}).empty()) return;
    SourceEvent& back = ready_.emplace_front();
    back.data = SourceNotice{"the Kinect delivers frames again"};
    return;
  }
  if (now_ns - last_frame_ns_ < std::chrono::nanoseconds(options_.idle_timeout).count()) return;
  say(available() ? "the Kinect is available but delivers no frames"
                  : "the Kinect is not available: unplugged or without power; waiting for it");
}

// Once, as long as it stays so.
void KinectSource::say(const std::string& text) {
  if (text == said_) return;
  said_ = text;
  ready_.push_back({0, SourceNotice{text}});
}

namespace kinect {
namespace {

static_assert(kJointTypeCount == kJointCount && kBodyCount == kMaxBodies);

// Zero, the SDK's word for unknown or low, where the SDK does not say.
template <class Get>
std::uint8_t state_of(IBody& body, Get get) {
  std::int32_t state = 0;
  if (failed((body.*get)(&state))) return 0;
  return static_cast<std::uint8_t>(state);
}

std::optional<Body> read(IBody& from) {
  Boolean tracked = 0;
  std::array<Joint, kJointTypeCount> joints{};
  Body body;
  if (failed(from.get_IsTracked(&tracked)) || tracked == 0) return std::nullopt;
  if (failed(from.get_TrackingId(&body.tracking_id))) return std::nullopt;
  if (failed(from.GetJoints(kJointTypeCount, joints.data()))) return std::nullopt;
  std::array<JointOrientation, kJointTypeCount> turns{};
  if (failed(from.GetJointOrientations(kJointTypeCount, turns.data()))) turns = {};
  for (std::size_t j = 0; j < kJointTypeCount; ++j) {
    const CameraSpacePoint& p = joints[j].position;
    const Vector4& q = turns[j].orientation;
    body.position_m[j] = {p.x, p.y, p.z};
    body.orientation_xyzw[j] = {q.x, q.y, q.z, q.w};
    body.tracking_state[j] = static_cast<std::uint8_t>(joints[j].tracking_state);
  }
  body.hand_state = {state_of(from, &IBody::get_HandLeftState), state_of(from, &IBody::get_HandRightState)};
  body.hand_confidence = {state_of(from, &IBody::get_HandLeftConfidence),
                          state_of(from, &IBody::get_HandRightConfidence)};
  return body;
}

}  // namespace

KinectBodies::~KinectBodies() {
  for (IBody* body : slots_)
    if (body) body->Release();
}

bool KinectBodies::refresh(IBodyFrame& frame) {
  return !failed(frame.GetAndRefreshBodyData(kBodyCount, slots_.data()));
}

std::vector<Body> KinectBodies::tracked() const {
  std::vector<Body> bodies;
  for (IBody* slot : slots_)
    if (slot)
      if (auto body = read(*slot)) bodies.push_back(std::move(*body));
  return bodies;
}

}  // namespace kinect
}  // namespace trilat
