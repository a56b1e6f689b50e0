// SPDX-License-Identifier: MIT
#include "recorders/kinect_sdk/kinect_bodies.h"

#include <optional>

namespace trilat::kinect {
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

}  // namespace trilat::kinect
