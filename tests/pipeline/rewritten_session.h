// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <vector>

#include "datasets/rig/campaign.h"
#include "datasets/rig/depth_camera.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_writer.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {

// What a copy of a session does with the frames of each sensor.
struct SessionChange {
  // Changes a body frame; false leaves it out.
  std::function<bool(std::size_t sensor, BodyFrame&)> bodies = [](std::size_t, BodyFrame&) { return true; };
  std::function<bool(std::size_t sensor, std::uint64_t frame)> keeps_depth = [](std::size_t, std::uint64_t) {
    return true;
  };
  bool keeps_exchanges = true;
};

// The take's session becomes a changed copy of it.
inline void change_session(Take& take, const std::filesystem::path& copy, const SessionChange& change) {
  const SessionReader session(take.session);
  SessionWriter writer(copy, session.header());
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    for (BodyFrame& frame : session.body_frames(s, 0, session.counts(s).body_frames))
      if (change.bodies(s, frame)) writer.add_body_frame(s, frame);
    const std::uint64_t images = session.counts(s).depth_frames;
    const auto stamps =
        images > 0 ? session.stamps(s, FrameStream::depth, 0, images) : std::vector<FrameStamp>{};
    for (std::uint64_t f = 0; f < images; ++f) {
      if (!change.keeps_depth(s, f)) continue;
      session.depth_frame(s, f, depth_mm);
      writer.add_depth_frame(s, encode_depth_frame(stamps[f], depth_mm, ChunkCompression::blosc));
    }
    if (!change.keeps_exchanges) continue;
    for (const ClockExchange& exchange : session.clock_exchanges(s)) writer.add_clock_exchange(s, exchange);
  }
  writer.finish();
  take.session = copy;
}

// The body of somebody who stands at a place of the world, wholly tracked, as a sensor sees it.
inline Body body_at(const SensorPose& pose, double x_m, double z_m, std::uint64_t tracking_id) {
  const SkeletonPose person = generated_motion(Person{}, Activity::standing)(0.0);
  Eigen::Vector3d middle_m = person.at(Joint::spine_mid);
  middle_m.y() = 0.0;
  Body body;
  body.tracking_id = tracking_id;
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Eigen::Vector3d in_sensor =
        pose.world_from_sensor.inverse() *
        Eigen::Vector3d(person.joint_in_world_m[j] - middle_m + Eigen::Vector3d(x_m, 0.0, z_m));
    for (int axis = 0; axis < 3; ++axis)
      body.position_m[j][static_cast<std::size_t>(axis)] = static_cast<float>(in_sensor[axis]);
    body.tracking_state[j] = 2;
  }
  return body;
}

// Adds the bodies of another recording of as many sensors to a copy of the take's session, frame by frame:
// two persons in one view. Their identities differ from the first person's.
inline void add_bodies_of(Take& take, const std::filesystem::path& other, const std::filesystem::path& copy) {
  const SessionReader session(other);
  std::vector<std::map<std::int64_t, std::vector<Body>>> bodies(session.header().sensors.size());
  for (std::size_t s = 0; s < bodies.size(); ++s)
    for (BodyFrame& frame : session.body_frames(s, 0, session.counts(s).body_frames))
      bodies[s][frame.stamp.sequence] = std::move(frame.bodies);
  change_session(take, copy, {[&](std::size_t s, BodyFrame& frame) {
                   for (Body body : bodies.at(s)[frame.stamp.sequence]) {
                     body.tracking_id += 1'000'000'000;
                     frame.bodies.insert(frame.bodies.begin(), body);
                   }
                   return true;
                 }});
}

}  // namespace trilat
