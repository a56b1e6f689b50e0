// SPDX-License-Identifier: MIT
#include "recorders/test_source.h"

#include <array>
#include <chrono>
#include <cmath>
#include <thread>

#include "recorders/frame_source.h"

namespace trilat {
namespace {

constexpr std::int64_t kPeriodNs = 33'333'300;

std::vector<std::uint16_t> slope(std::int64_t frame) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t i = 0; i < kDepthPixels; ++i)
    depth_mm[i] = static_cast<std::uint16_t>(1000 + (i + static_cast<std::size_t>(frame)) % kDepthWidth * 4);
  return depth_mm;
}

// A person of 1.7 m who faces the sensor with arms that hang: to the left, and up from spine_base, in the
// order of Joint.
struct InFront {
  float left_m, up_m;
};
constexpr std::array<InFront, kJointCount> kStanding{
    {{0.0f, 0.0f},     {0.0f, 0.31f},    {0.0f, 0.6f},    {0.0f, 0.75f},    {0.18f, 0.48f},
     {0.25f, 0.22f},   {0.28f, -0.02f},  {0.28f, -0.1f},  {-0.18f, 0.48f},  {-0.25f, 0.22f},
     {-0.28f, -0.02f}, {-0.28f, -0.1f},  {0.08f, -0.04f}, {0.1f, -0.44f},   {0.1f, -0.82f},
     {0.12f, -0.9f},   {-0.08f, -0.04f}, {-0.1f, -0.44f}, {-0.1f, -0.82f},  {-0.12f, -0.9f},
     {0.0f, 0.53f},    {0.28f, -0.18f},  {0.24f, -0.14f}, {-0.28f, -0.18f}, {-0.24f, -0.14f}}};

BodyFrame one_body(std::int64_t frame) {
  BodyFrame result;
  result.floor_plane = {0.0f, 1.0f, 0.0f, 1.0f};
  Body body;
  body.tracking_id = 1;
  const float sway_m = 0.2f * std::sin(0.1f * static_cast<float>(frame));
  for (std::size_t j = 0; j < kJointCount; ++j) {
    body.position_m[j] = {sway_m + kStanding[j].left_m, kStanding[j].up_m, 2.5f};
    body.tracking_state[j] = 2;
  }
  result.bodies.push_back(body);
  return result;
}

}  // namespace

TestSource::TestSource(double duration_s)
    : frames_(static_cast<std::int64_t>(std::ceil(duration_s * 1e9 / kPeriodNs))) {
  header_.simulated = true;
  SensorDescription sensor;
  sensor.name = "test";
  sensor.serial = "none";
  sensor.source = "test";
  sensor.has_depth = true;
  header_.sensors.push_back(sensor);
}

std::optional<SourceEvent> TestSource::next() {
  if (bodies_) {
    SourceEvent event{0, std::move(*bodies_)};
    bodies_.reset();
    return event;
  }
  if (start_ns_ == 0) start_ns_ = host_now_ns();
  const std::int64_t due_ns = start_ns_ + frame_ * kPeriodNs;
  for (std::int64_t left_ns; !stopped_ && (left_ns = due_ns - host_now_ns()) > 0;)
    std::this_thread::sleep_for(
        std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(left_ns), kPollPeriod));
  if (stopped_ || frame_ >= frames_) return std::nullopt;
  const FrameStamp stamp{frame_, frame_ * kPeriodNs / header_.sensors[0].tick_ns, host_now_ns()};
  bodies_ = one_body(frame_);
  bodies_->stamp = stamp;
  return SourceEvent{0, DepthFrame{stamp, slope(frame_++)}};
}

}  // namespace trilat
