// SPDX-License-Identifier: MIT
#include <algorithm>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/session/session_reader.h"
#include "datasets/session/session_verify.h"
#include "recorders/capture.h"
#include "recorders/synthetic_source.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

const SimulatedItem kItem{4, 2, 0};

SensorSpec sensor_spec() {
  SensorSpec spec;
  spec.dropped_share = 0.1;
  return spec;
}

std::vector<SimulatedSensor> two_sensors() {
  const auto poses = rig_poses({2.0, {0.6, 1.9}, {}}, {0.0, 1.0, 0.0});
  return {draw_sensor(sensor_spec(), kItem, 0, poses[0]), draw_sensor(sensor_spec(), kItem, 1, poses[1])};
}

// A ball that moves in front of a wall-less floor.
DepthScene moving_ball(double time_s) {
  DepthScene scene;
  append_room(scene, {}, {0.0, 1.0, 0.0});
  scene.spheres.push_back({{0.5 * time_s, 1.0, 0.0}, 0.2});
  return scene;
}

SyntheticSource source_of(const ForEach& for_each = {}) {
  return {sensor_spec(),
          kItem,
          generated_motion(Person{}, Activity::standing),
          two_sensors(),
          1.0,
          {exact_body_tracker()},
          SyntheticDepth{moving_ball, {}, for_each}};
}

TEST(SyntheticDepthSource, EveryBodyFrameHasItsDepthWithTheSameStamps) {
  const ScratchFolder folder;
  SyntheticSource source = source_of();
  const RecordSummary summary = record(source, folder / "session.h5", {});
  EXPECT_EQ(summary.depth_frames, summary.body_frames);
  const SessionReader session(folder / "session.h5");
  for (const Finding& finding : verify_session(session, {}))
    EXPECT_NE(finding.severity, Severity::error) << finding.place << ": " << finding.text;
  for (std::size_t s = 0; s < 2; ++s) {
    const std::uint64_t frames = session.counts(s).body_frames;
    EXPECT_GT(frames, 20u);
    EXPECT_LT(frames, 31u);  // some are dropped
    ASSERT_EQ(session.counts(s).depth_frames, frames);
    const auto bodies = session.stamps(s, FrameStream::bodies, 0, frames);
    const auto depth = session.stamps(s, FrameStream::depth, 0, frames);
    for (std::size_t i = 0; i < frames; ++i) {
      EXPECT_EQ(bodies[i].sequence, depth[i].sequence);
      EXPECT_EQ(bodies[i].device_ticks, depth[i].device_ticks);
      EXPECT_EQ(bodies[i].arrival_ns, depth[i].arrival_ns);
    }
  }
}

TEST(SyntheticDepthSource, AFrameShowsTheSceneAtItsExposure) {
  const ScratchFolder folder;
  SyntheticSource source = source_of();
  record(source, folder / "session.h5", {});
  const SessionReader session(folder / "session.h5");
  const auto sensors = two_sensors();
  for (std::size_t s = 0; s < 2; ++s) {
    const DepthRenderer renderer(sensors[s].intrinsics, {}, draw_depth_unit({}, kItem.seed, s));
    const auto stamps = session.stamps(s, FrameStream::depth, 0, session.counts(s).depth_frames);
    std::vector<std::uint16_t> stored(kDepthPixels), expected(kDepthPixels);
    for (const std::size_t i : {std::size_t{0}, std::size_t{9}, stamps.size() - 1}) {
      const auto number = static_cast<std::uint64_t>(stamps[i].sequence);
      const double time_s = (exposure_of(sensors[s], sensor_spec(), number) - kMotionStart).seconds();
      renderer.render(moving_ball(time_s), sensors[s].pose.world_from_sensor,
                      {kItem.seed, Purpose::depth_pixel, random_item(kItem.take, s, 0, number)}, expected);
      session.depth_frame(s, i, stored);
      EXPECT_EQ(stored, expected) << s << " " << i;
    }
  }
}

std::vector<SourceEvent> all_events(SyntheticSource source) {
  std::vector<SourceEvent> events;
  while (auto event = source.next()) events.push_back(std::move(*event));
  return events;
}

TEST(SyntheticDepthSource, TheOrderInWhichFramesAreRenderedMakesNoDifference) {
  const auto forwards = all_events(source_of());
  std::size_t most = 0;
  const auto backwards =
      all_events(source_of([&](std::size_t count, const std::function<void(std::size_t)>& body) {
        most = std::max(most, count);
        for (std::size_t i = count; i-- > 0;) body(i);
      }));
  EXPECT_GT(most, 1u);
  EXPECT_LE(most, 64u);  // memory stays bounded
  ASSERT_EQ(backwards.size(), forwards.size());
  for (std::size_t i = 0; i < forwards.size(); ++i) {
    ASSERT_EQ(backwards[i].data.index(), forwards[i].data.index());
    EXPECT_EQ(backwards[i].sensor, forwards[i].sensor);
    if (const auto* depth = std::get_if<DepthFrame>(&forwards[i].data)) {
      EXPECT_EQ(std::get<DepthFrame>(backwards[i].data).depth_mm, depth->depth_mm);
    }
  }
}

struct Delivered {
  std::vector<BodyFrame> frames[2];
};

void deliver(FrameSource& source, Delivered& into) {
  while (auto event = source.next())
    if (const auto* frame = std::get_if<BodyFrame>(&event->data))
      into.frames[event->sensor].push_back(*frame);
}

Delivered delivered_bodies(double dropped_share) {
  SensorSpec spec = sensor_spec();
  spec.dropped_share = dropped_share;
  Delivered into;
  SyntheticSource source(spec, kItem, generated_motion(Person{}, Activity::walking), two_sensors(), 2.0,
                         default_body_tracker());
  deliver(source, into);
  return into;
}

void expect_same_bodies(const BodyFrame& a, const BodyFrame& b) {
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_EQ(a.bodies[i].tracking_id, b.bodies[i].tracking_id);
    EXPECT_EQ(a.bodies[i].position_m, b.bodies[i].position_m);
    EXPECT_EQ(a.bodies[i].tracking_state, b.bodies[i].tracking_state);
  }
}

TEST(SyntheticSource, AFrameThatIsLostDoesNotChangeWhatTheTrackerSaysLater) {
  const Delivered all = delivered_bodies(0.0), some = delivered_bodies(0.3);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_LT(some.frames[s].size(), all.frames[s].size() - 5);
    ASSERT_FALSE(some.frames[s].empty());
    for (std::size_t i = 0; i < some.frames[s].size(); ++i) {
      const auto number = static_cast<std::size_t>(some.frames[s][i].stamp.sequence);
      expect_same_bodies(some.frames[s][i], all.frames[s].at(number));
    }
  }
}

TEST(SyntheticDepthSource, BodiesOfATrackerAreThoseWithoutDepth) {
  const Delivered plain = delivered_bodies(0.1);
  Delivered with_depth;
  SyntheticSource source(sensor_spec(), kItem, generated_motion(Person{}, Activity::walking), two_sensors(),
                         2.0, default_body_tracker(), SyntheticDepth{moving_ball, {}, {}});
  deliver(source, with_depth);
  for (std::size_t s = 0; s < 2; ++s) {
    ASSERT_EQ(with_depth.frames[s].size(), plain.frames[s].size());
    ASSERT_FALSE(plain.frames[s].empty());
    for (std::size_t i = 0; i < plain.frames[s].size(); ++i)
      expect_same_bodies(with_depth.frames[s][i], plain.frames[s][i]);
  }
}

TEST(SyntheticDepthSource, WhatStopsTheRenderingEndsTheRecording) {
  const ScratchFolder folder;
  SyntheticSource source =
      source_of([](std::size_t, const std::function<void(std::size_t)>&) { throw Interrupted(); });
  EXPECT_THROW(record(source, folder / "session.h5", {}), Interrupted);
  EXPECT_FALSE(std::filesystem::exists(folder / "session.h5"));
}

}  // namespace
}  // namespace trilat
