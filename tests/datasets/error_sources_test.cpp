// SPDX-License-Identifier: MIT
#include "datasets/synthetic/error_sources.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/simulated_markers.h"
#include "datasets/synthetic/tracker/body_tracker.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

// Every source is on, and large enough to be seen in ten seconds.
SimulationSpec spec_with_everything() {
  SimulationSpec spec;
  spec.name = "everything";
  spec.seed = 3;
  spec.activities = {{Activity::walking, 10.0, {Joint::head, Joint::wrist_left}}};
  spec.body_tracker = default_body_tracker();
  spec.body_tracker.jump_rate_per_minute.fill(20.0);
  spec.body_tracker.exchanged_share = 1.0;
  spec.sensor.dropped_share = 0.1;
  spec.mocap.gap_share = 0.1;
  return spec;
}

using Bodies = std::vector<std::vector<Body>>;  // by sensor; one a frame, dropped or not

// What one take of a simulation consists of, part by part.
struct Parts {
  Bodies bodies;
  std::vector<bool> dropped;
  std::vector<FrameStamp> stamps;  // of all frames, dropped or not
  std::vector<ClockExchange> exchanges;
  std::vector<Vector3d> markers_m;
  Duration mocap_error{};
};

Parts parts_of(const SimulationSpec& spec) {
  constexpr std::uint64_t kFrames = 300;
  const SimulatedItem item{spec.seed, 0, 0};
  const Motion motion = generated_motion(draw_person(spec.seed, 0, 1.7, 0.1), Activity::walking);
  SensorSpec lossless = spec.sensor;
  lossless.dropped_share = 0.0;
  Parts parts;
  for (const SensorPose& pose : rig_poses(spec.rig, {0.0, 1.0, 0.0})) {
    const SimulatedSensor sensor = draw_sensor(spec.sensor, item, parts.bodies.size(), pose);
    BodyTracker tracker(spec.body_tracker, spec.sensor, sensor, item);
    parts.bodies.emplace_back();
    for (std::uint64_t f = 0; f < kFrames; ++f) {
      const SkeletonPose truth = motion((exposure_of(sensor, spec.sensor, f) - kMotionStart).seconds());
      parts.bodies.back().push_back(tracker.observe(f, truth).body.value());
      parts.dropped.push_back(!simulate_empty_frame(sensor, spec.sensor, item, f));
      parts.stamps.push_back(simulate_empty_frame(sensor, lossless, item, f)->stamp);
    }
    for (std::uint64_t n = 0; n < 20; ++n)
      parts.exchanges.push_back(simulate_exchange(sensor, spec.sensor, item, n));
  }
  for (std::uint64_t f = 0; f < 500; ++f)
    for (const Joint joint : spec.activities[0].marker_joints)
      for (const Vector3d& marker :
           simulate_markers(motion(0.01 * static_cast<double>(f)), joint, spec.mocap, item, f))
        parts.markers_m.push_back(marker);
  parts.mocap_error = mocap_clock_error(spec.mocap, item);
  return parts;
}

bool same(const Bodies& a, const Bodies& b) {
  for (std::size_t s = 0; s < a.size(); ++s)
    for (std::size_t f = 0; f < a[s].size(); ++f)
      if (a[s][f].position_m != b[s][f].position_m || a[s][f].tracking_state != b[s][f].tracking_state)
        return false;
  return true;
}

bool same(const std::vector<FrameStamp>& a, const std::vector<FrameStamp>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].device_ticks != b[i].device_ticks || a[i].arrival_ns != b[i].arrival_ns) return false;
  return true;
}

bool same(const std::vector<ClockExchange>& a, const std::vector<ClockExchange>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].t1_ns != b[i].t1_ns || a[i].t2_ns != b[i].t2_ns || a[i].t3_ns != b[i].t3_ns ||
        a[i].t4_ns != b[i].t4_ns)
      return false;
  return true;
}

double worst_m(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    worst = a[i].allFinite() && b[i].allFinite() ? std::max(worst, (a[i] - b[i]).norm()) : 1e9;
  return worst;
}

bool is_of_tracker(ErrorSource source) {
  static const std::set<ErrorSource> kTracker{ErrorSource::jitter,  ErrorSource::wander, ErrorSource::jumps,
                                              ErrorSource::bias,    ErrorSource::lag,    ErrorSource::hidden,
                                              ErrorSource::exchange};
  return kTracker.contains(source);
}

TEST(ErrorSources, EachAloneSwitchesOnWhatItSaysAndNothingElse) {
  const SimulationSpec spec = spec_with_everything();
  const Parts none = parts_of(with_only(spec, ErrorSource::none));
  for (const ErrorSource source : error_sources()) {
    if (source == ErrorSource::all) continue;
    const std::string name = name_of(source);
    const Parts parts = parts_of(with_only(spec, source));
    const bool clocks = source == ErrorSource::clocks;
    EXPECT_EQ(same(parts.stamps, none.stamps), !clocks) << name;
    EXPECT_EQ(same(parts.exchanges, none.exchanges), !clocks) << name;
    EXPECT_EQ(parts.mocap_error == none.mocap_error, !clocks) << name;
    EXPECT_EQ(parts.dropped == none.dropped, source != ErrorSource::dropped) << name;
    EXPECT_EQ(worst_m(parts.markers_m, none.markers_m) == 0.0, source != ErrorSource::mocap) << name;
    // other clocks expose at other times
    EXPECT_EQ(same(parts.bodies, none.bodies), !is_of_tracker(source) && !clocks) << name;
  }
}

TEST(ErrorSources, WithNoneOfThemEverythingIsExact) {
  SimulationSpec spec = with_only(spec_with_everything(), ErrorSource::none);
  EXPECT_TRUE(spec.sensor.free_running);  // the sensors keep their phases …
  spec.sensor.free_running = false;       // … without which it is known when a frame is taken
  const Parts parts = parts_of(spec);
  const Motion motion = generated_motion(draw_person(spec.seed, 0, 1.7, 0.1), Activity::walking);
  const auto poses = rig_poses(spec.rig, {0.0, 1.0, 0.0});
  for (std::size_t s = 0; s < poses.size(); ++s)
    for (std::size_t f = 0; f < 300; ++f) {
      const SkeletonPose truth = motion(static_cast<double>(f) / 30.0);
      const Body& body = parts.bodies[s][f];
      for (std::size_t j = 0; j < kJointCount; ++j) {
        if (body.tracking_state[j] == 0) continue;  // out of view
        EXPECT_EQ(body.tracking_state[j], 2);
        const auto& p = body.position_m[j];
        const Vector3d seen = poses[s].world_from_sensor * Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
        ASSERT_LT((seen - truth.joint_in_world_m[j]).norm(), 1e-6);
      }
    }
  for (const bool dropped : parts.dropped) EXPECT_FALSE(dropped);
  EXPECT_EQ(parts.mocap_error.ns, 0);
  for (const ClockExchange& e : parts.exchanges)  // both ways take as long, so they show the clock as it is
    EXPECT_EQ(e.t2_ns - e.t1_ns, e.t4_ns - e.t3_ns);
}

TEST(ErrorSources, AllIsTheSimulationItselfAndPersonsAndRigStay) {
  SimulationSpec spec = spec_with_everything();
  spec.participants = 7;
  spec.rig.heights_m = {1.0, 2.0, 1.5};
  const SimulationSpec all = with_only(spec, ErrorSource::all);
  EXPECT_TRUE(same(parts_of(all).bodies, parts_of(spec).bodies));
  EXPECT_EQ(all.sensor.dropped_share, spec.sensor.dropped_share);
  for (const ErrorSource source : error_sources()) {
    const SimulationSpec only = with_only(spec, source);
    EXPECT_EQ(only.participants, 7u);
    EXPECT_EQ(only.seed, spec.seed);
    EXPECT_EQ(only.rig.heights_m, spec.rig.heights_m);
    EXPECT_EQ(only.activities.size(), 1u);
  }
}

TEST(ErrorSources, EachSettingOfTheTrackerBelongsToOneOfThem) {
  const SimulationSpec spec = spec_with_everything();
  const auto settings = [&](ErrorSource source) {
    return tracker_parameters(with_only(spec, source).body_tracker);
  };
  const auto none = settings(ErrorSource::none), all = settings(ErrorSource::all);
  for (std::size_t p = 0; p < all.size(); ++p) {
    if (all[p].value == none[p].value) continue;
    const auto has = [&](ErrorSource source) { return settings(source)[p].value != none[p].value; };
    EXPECT_EQ(std::ranges::count_if(error_sources(), has), 2) << all[p].name;  // it, and all together
  }
}

TEST(ErrorSources, LeaveTheCalibrationTrue) {
  SimulationSpec spec = spec_with_everything();
  spec.rig.position_sigma_m = 0.01;
  spec.rig.rotation_sigma_rad = 0.02;
  for (const ErrorSource source : error_sources()) {
    EXPECT_EQ(with_only(spec, source).rig.position_sigma_m, 0.0) << name_of(source);
    EXPECT_EQ(with_only(spec, source).rig.rotation_sigma_rad, 0.0) << name_of(source);
  }
}

}  // namespace
}  // namespace trilat
