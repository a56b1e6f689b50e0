// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/simulated_markers.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/simulation_spec.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr Activity kActivities[] = {Activity::walking, Activity::arm_swing, Activity::leg_crossing,
                                    Activity::standing, Activity::steps};

std::vector<SimulatedSensor> rig_of(const SensorSpec& spec, const SimulatedItem& item) {
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0}))
    sensors.push_back(draw_sensor(spec, item, sensors.size(), pose));
  return sensors;
}

// Mean, and standard deviation about it.
struct ErrorMoments {
  double n = 0.0, sum = 0.0, squares = 0.0;
  void add(double value) {
    n += 1.0;
    sum += value;
    squares += value * value;
  }
  double mean() const { return sum / n; }
  double sigma() const { return std::sqrt(squares / n - mean() * mean()); }
};

TEST(GeneratedPerson, EveryJointMovesSmoothly) {
  constexpr double kStep_s = 1e-3, kFastest_m_s = 6.0, kMostAcceleration_m_s2 = 60.0;
  for (const Activity activity : kActivities) {
    const Motion motion = generated_motion(draw_person(3, 1, 1.70, 0.17), activity);
    for (double t = 0.0; t < 40.0; t += 0.017) {
      const SkeletonPose before = motion(t - kStep_s), at = motion(t), after = motion(t + kStep_s);
      EXPECT_TRUE(at.present.all());
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const Vector3d& p = at.joint_in_world_m[j];
        ASSERT_TRUE(p.allFinite());
        ASSERT_LT((after.joint_in_world_m[j] - p).norm() / kStep_s, kFastest_m_s);
        ASSERT_LT(
            (after.joint_in_world_m[j] - 2.0 * p + before.joint_in_world_m[j]).norm() / (kStep_s * kStep_s),
            kMostAcceleration_m_s2)
            << activity_names()[static_cast<std::size_t>(activity)] << " joint " << j << " at " << t << " s";
      }
    }
  }
}

TEST(GeneratedPerson, LimbsKeepTheirLengthWhileMoving) {
  const std::pair<Joint, Joint> limbs[] = {
      {Joint::hip_left, Joint::knee_left},       {Joint::hip_right, Joint::knee_right},
      {Joint::knee_left, Joint::ankle_left},     {Joint::knee_right, Joint::ankle_right},
      {Joint::shoulder_left, Joint::elbow_left}, {Joint::shoulder_right, Joint::elbow_right},
      {Joint::elbow_left, Joint::wrist_left},    {Joint::elbow_right, Joint::wrist_right},
      {Joint::wrist_left, Joint::hand_left},     {Joint::wrist_right, Joint::hand_right}};
  for (const Activity activity : kActivities) {
    const Motion motion = generated_motion(draw_person(3, 2, 1.70, 0.17), activity);
    for (const auto& [parent, child] : limbs) {
      const SkeletonPose start = motion(0.0);
      const double length_m = (start.at(child) - start.at(parent)).norm();
      EXPECT_GT(length_m, 0.05);
      for (double t = 0.0; t < 35.0; t += 0.11) {
        const SkeletonPose pose = motion(t);
        ASSERT_NEAR((pose.at(child) - pose.at(parent)).norm(), length_m, 1e-9)
            << name_of(parent) << " to " << name_of(child) << " at " << t << " s";
      }
    }
  }
}

TEST(GeneratedPerson, WhoWalksStandsOnAFootThatDoesNotMove) {
  for (const Activity activity : {Activity::walking, Activity::steps, Activity::walk_about})
    for (const double stature_m : {1.53, 1.87}) {
      const Motion motion =
          generated_motion({.stature_m = stature_m, .tempo = 1.1, .phase_rad = 1.0}, activity);
      for (double t = 0.0; t < 35.0; t += 0.013) {
        const SkeletonPose before = motion(t - 1e-3), at = motion(t), after = motion(t + 1e-3);
        std::size_t standing = 0;
        for (const Joint ankle : {Joint::ankle_left, Joint::ankle_right}) {
          standing += (at.at(ankle) - before.at(ankle)).norm() < 1e-9 ||
                      (after.at(ankle) - at.at(ankle)).norm() < 1e-9;
          ASSERT_GT(at.at(ankle).y(), 0.038 * stature_m);
        }
        ASSERT_GE(standing, 1u) << activity_names()[static_cast<std::size_t>(activity)] << " at " << t
                                << " s";
        for (const Joint knee : {Joint::knee_left, Joint::knee_right})
          ASSERT_NEAR((at.at(knee) - at.at(parent_of(knee).value())).norm(), 0.245 * stature_m, 1e-9);
        for (const Joint ankle : {Joint::ankle_left, Joint::ankle_right})
          ASSERT_NEAR((at.at(ankle) - at.at(parent_of(ankle).value())).norm(), 0.246 * stature_m, 1e-9);
      }
    }
}

TEST(GeneratedPerson, IsDrawnWithinTheStatedRangeAndFillsIt) {
  ErrorMoments stature;
  double least = 10.0, most = 0.0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const Person person = draw_person(7, i, 1.70, 0.17);
    stature.add(person.stature_m);
    least = std::min(least, person.stature_m);
    most = std::max(most, person.stature_m);
    EXPECT_GE(person.tempo, 0.9);
    EXPECT_LE(person.tempo, 1.1);
    EXPECT_GE(person.amplitude, 0.9);
    EXPECT_LE(person.amplitude, 1.1);
  }
  EXPECT_GE(least, 1.53);
  EXPECT_LT(least, 1.54);
  EXPECT_LE(most, 1.87);
  EXPECT_GT(most, 1.86);
  EXPECT_NEAR(stature.mean(), 1.70, 4.0 * 0.17 / std::sqrt(3.0 * 2000.0));
}

TEST(GeneratedPerson, FacingPlusZHasItsLeftAtPlusXAndItsHeadUp) {
  for (const Activity activity : {Activity::standing, Activity::arm_swing, Activity::leg_crossing}) {
    const SkeletonPose pose = generated_motion(Person{}, activity)(0.3);
    EXPECT_EQ(pose.heading_rad, 0.0);
    for (const Joint left : {Joint::shoulder_left, Joint::hip_left})
      EXPECT_GT(pose.at(left).x(), pose.at(mirror_of(left)).x() + 0.1) << name_of(left);
    EXPECT_GT(pose.at(Joint::foot_left).z(), pose.at(Joint::ankle_left).z());
    EXPECT_GT(pose.at(Joint::head).y(), pose.at(Joint::spine_base).y() + 0.5);
    EXPECT_GT(pose.at(Joint::spine_base).y(), pose.at(Joint::ankle_right).y() + 0.5);
  }
}

TEST(GeneratedPerson, WalksTheWayItFacesAndStaysAboveTheFloor) {
  const Person person = draw_person(1, 4, 1.70, 0.17);
  const Motion motion = generated_motion(person, Activity::walking);
  for (double t = 0.0; t < 35.0; t += 0.07) {
    const SkeletonPose pose = motion(t);
    Vector3d step = motion(t + 1e-4).at(Joint::spine_base) - motion(t - 1e-4).at(Joint::spine_base);
    step.y() = 0.0;
    const Vector3d forward(std::sin(pose.heading_rad), 0.0, std::cos(pose.heading_rad));
    EXPECT_GT(step.normalized().dot(forward), 0.99) << t << " s";
    const Vector3d left = pose.at(Joint::shoulder_left) - pose.at(Joint::shoulder_right);
    EXPECT_GT(left.dot(Vector3d::UnitY().cross(forward)), 0.1) << t << " s";
    EXPECT_GT(std::min(pose.at(Joint::foot_left).y(), pose.at(Joint::foot_right).y()), -0.02) << t << " s";
  }
}

TEST(SimulatedSensor, FramesAreDroppedAsDeclaredAndTheFloorKeepsItsPlace) {
  SensorSpec spec;
  spec.dropped_share = 0.1;
  const SimulatedItem item{12, 0, 0};
  constexpr std::uint64_t kFrames = 4500;
  for (const SimulatedSensor& sensor : rig_of(spec, item)) {
    double kept = 0.0;
    for (std::uint64_t f = 0; f < kFrames; ++f) {
      const auto frame = simulate_empty_frame(sensor, spec, item, f);
      if (!frame) continue;
      kept += 1.0;
      // the world's origin lies on the floor: n . p + height = 0
      const Vector3d origin = sensor.pose.world_from_sensor.inverse() * Vector3d::Zero();
      const auto& plane = frame->floor_plane;
      const Vector3d normal = Eigen::Vector3f(plane[0], plane[1], plane[2]).cast<double>();
      EXPECT_NEAR(normal.norm(), 1.0, 1e-6);
      EXPECT_NEAR(normal.dot(origin) + static_cast<double>(plane[3]), 0.0, 1e-6);
    }
    EXPECT_NEAR(1.0 - kept / kFrames, 0.1, 4.0 * std::sqrt(0.1 * 0.9 / kFrames));
  }
}

TEST(SimulatedMarkers, TheirMeanIsTheJoint) {
  MocapSpec spec;
  spec.marker_noise_sigma_m = 0.0;
  spec.gap_share = 0.0;
  const Motion motion = generated_motion(Person{}, Activity::walking);
  for (std::uint64_t f = 0; f < 300; f += 11) {
    const SkeletonPose pose = motion(static_cast<double>(f) / spec.rate_hz);
    const auto markers = simulate_markers(pose, Joint::elbow_left, spec, {1, 0, 0}, f);
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& marker : markers) {
      mean += marker / kMarkersPerJoint;
      EXPECT_NEAR((marker - pose.at(Joint::elbow_left)).norm(), spec.marker_offset_m, 1e-12);
    }
    EXPECT_LT((mean - pose.at(Joint::elbow_left)).norm(), 1e-12);
  }
}

TEST(SimulatedMarkers, NoiseAndGapsAreAsDeclared) {
  MocapSpec spec;
  spec.gap_share = 0.05;
  MocapSpec exact = spec;
  exact.marker_noise_sigma_m = 0.0;
  const Motion motion = generated_motion(Person{}, Activity::standing);
  ErrorMoments noise;
  double lost = 0.0, all = 0.0;
  for (std::uint64_t f = 0; f < 10'000; ++f) {
    const auto noisy = simulate_markers(motion(0.0), Joint::head, spec, {9, 0, 0}, f);
    const auto still = simulate_markers(motion(0.0), Joint::head, exact, {9, 0, 0}, f);
    for (std::size_t m = 0; m < noisy.size(); ++m) {
      all += 1.0;
      EXPECT_EQ(noisy[m].allFinite(), still[m].allFinite());
      if (!noisy[m].allFinite())
        lost += 1.0;
      else
        for (int axis = 0; axis < 3; ++axis) noise.add(noisy[m][axis] - still[m][axis]);
    }
  }
  EXPECT_NEAR(noise.sigma(), spec.marker_noise_sigma_m, 0.02 * spec.marker_noise_sigma_m);
  EXPECT_NEAR(lost / all, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / (4.0 * 500.0)));  // 500 stretches a marker
}

TEST(SimulatedMarkers, AJointTheSourceDoesNotKnowHasNoMarkers) {
  for (const Vector3d& marker : simulate_markers(SkeletonPose{}, Joint::head, {}, {1, 0, 0}, 0))
    EXPECT_TRUE(marker.array().isNaN().all());
}

TEST(SimulatedMarkers, ARigidBodyIsWhereItIsButForAMarkersNoiseAndGaps) {
  MocapSpec spec;
  spec.gap_share = 0.05;
  const Vector3d position(0.3, 1.2, -0.4);
  ErrorMoments noise;
  double lost = 0.0;
  for (std::uint64_t f = 0; f < 20'000; ++f) {
    const Vector3d seen = simulate_rigid_body(position, spec, {9, 0, 0}, f);
    if (!seen.allFinite())
      lost += 1.0;
    else
      for (int axis = 0; axis < 3; ++axis) noise.add(seen[axis] - position[axis]);
  }
  EXPECT_NEAR(noise.mean(), 0.0, 1e-5);
  EXPECT_NEAR(noise.sigma(), spec.marker_noise_sigma_m, 0.02 * spec.marker_noise_sigma_m);
  EXPECT_NEAR(lost / 20'000.0, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / 1000.0));
}

TEST(SimulatedMarkers, TheStatedStartIsOffByNoMoreThanDeclared) {
  ErrorMoments error;
  for (std::uint64_t take = 0; take < 1000; ++take) error.add(mocap_clock_error({}, {1, take, 0}).seconds());
  EXPECT_NEAR(error.sigma(), 0.005 / std::sqrt(3.0), 2e-4);
  EXPECT_NEAR(error.mean(), 0.0, 4e-4);
}

TEST(SimulationSpec, TheRigLooksAtItsCentreFromTheStatedHeights) {
  RigSpec rig;
  rig.centre_m = Vector3d(0.5, 1.2, -0.3);
  const auto poses = rig_poses(rig, Vector3d::Zero());
  ASSERT_EQ(poses.size(), 4u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].name, "k" + std::to_string(i + 1));
    const Vector3d& position = poses[i].world_from_sensor.translation_m;
    EXPECT_EQ(position.y(), rig.heights_m[i]);
    EXPECT_NEAR(std::hypot(position.x() - 0.5, position.z() + 0.3), 2.0, 1e-12);
    const Vector3d centre = poses[i].world_from_sensor.inverse() * *rig.centre_m;
    EXPECT_LT(centre.head<2>().norm(), 1e-12);
    EXPECT_GT(centre.z(), 1.9);
  }
}

TEST(SimulationSpec, HeightsMayBeARangeInAnyOrder) {
  const auto heights = [](const std::string& range) {
    return parse_simulation(
               parse_json(
                   R"({"format": "trilat.simulation", "version": 1, "rig": {"heights_m": )" + range + "}}",
                   "sim.json"),
               "sim.json", {})
        .rig.heights_m;
  };
  EXPECT_THAT(heights(R"({"sensors": 3, "mean_m": 1, "spread_m": 1})"), testing::ElementsAre(0.5, 1.0, 1.5));
  EXPECT_THAT(heights(R"({"sensors": 3, "mean_m": 1, "spread_m": 1, "order": 1})"),
              testing::ElementsAre(1.5, 1.0, 0.5));
  std::set<std::vector<double>> orders;
  for (int k = 0; k < 24; ++k)
    orders.insert(heights(fmt::format(R"({{"sensors": 4, "order": {}}})", (k + 0.5) / 24.0)));
  EXPECT_EQ(orders.size(), 24u);
}

TEST(SimulationSpec, SensorsShareTheArc) {
  RigSpec rig;
  rig.arc_rad = std::numbers::pi / 2.0;
  const auto poses = rig_poses(rig, Vector3d::Zero());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3d& p = poses[i].world_from_sensor.translation_m;
    EXPECT_NEAR(std::atan2(p.x(), p.z()), (static_cast<double>(i) + 0.5) * std::numbers::pi / 8.0, 1e-12);
  }
}

std::string simulation_refusal(const std::string& members) {
  return message_of([&] {
    parse_simulation(
        parse_json(R"({"format": "trilat.simulation", "version": 1)" + members + "}", "sim.json"), "sim.json",
        {});
  });
}

TEST(SimulationSpec, DefaultsAreAWholeCampaign) {
  EXPECT_EQ(simulation_refusal(""), "no error");
  const SimulationSpec spec = parse_simulation(
      parse_json(R"({"format": "trilat.simulation", "version": 1})", "sim.json"), "sim.json", {});
  EXPECT_EQ(spec.participants, 16u);
  ASSERT_EQ(spec.activities.size(), 1u);
  EXPECT_EQ(spec.activities[0].activity, Activity::walking);
  EXPECT_EQ(spec.activities[0].marker_joints.size(), 7u);
}

TEST(SimulationSpec, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const std::pair<const char*, const char*> cases[] = {
      {R"(, "sensr": {})", "sim.json /sensr: is an unknown key; known are: "},
      {R"(, "seed": -1)", "sim.json /seed: must be an integer of 0 or more"},
      {R"(, "participants": 0)", "sim.json /participants: must be 1 to 10000"},
      {R"(, "participants": 1.7)", "sim.json /participants: must be an integer"},
      {R"(, "participants": 9000, "activities": [{"name": "walking"}, {"name": "standing"}])",
       "sim.json /participants: make more than 16000 takes"},
      {R"(, "stature_m": {"mean": 170})", "sim.json /stature_m/mean: must lie between 0.5 and 2.5"},
      {R"(, "activities": [{"name": "flying"}])",
       "sim.json /activities/0/name: is \"flying\", which is unknown; known are: walking"},
      {R"(, "activities": [{"name": "walking", "duration_s": 0}])",
       "sim.json /activities/0/duration_s: must lie between"},
      {R"(, "activities": [{"name": "walking", "marker_joints": ["nose"]}])",
       "sim.json /activities/0/marker_joints: names \"nose\", which is no joint"},
      {R"(, "activities": [{"name": "walking", "marker_joints": ["head", "head"]}])",
       "sim.json /activities/0/marker_joints: names \"head\" twice"},
      {R"(, "activities": [{"name": "walking"}], "recorded": {"mocap": "a.csv", "mapping": "b.json"})",
       "sim.json /activities: cannot stand beside \"recorded\""},
      {R"(, "rig": {"arc_deg": 400})", "sim.json /rig/arc_deg: must lie between"},
      {R"(, "rig": {"heights_m": {"sensors": 9}})", "sim.json /rig/heights_m/sensors: must be 1 to 8"},
      {R"(, "rig": {"heights_m": []})", "sim.json /rig/heights_m: must hold 1 to 8 heights"},
      {R"(, "rig": {"heights_m": 1.2})", "sim.json /rig/heights_m: must be an array"},
      {R"(, "rig": {"radius_m": 0})", "sim.json /rig/radius_m: must lie between 0.3 and 20"},
      {R"(, "sensor": {"dropped_share": 1.5})", "sim.json /sensor/dropped_share: must lie between 0 and 1"},
      {R"(, "sensor": {"free_running": 1})", "sim.json /sensor/free_running: must be true or false"},
      {R"(, "mocap": {"rate_hz": 0})", "sim.json /mocap/rate_hz: must lie between 1"},
      {R"(, "depth": {})", "sim.json /depth: says nothing without \"takes\": true"},
      {R"(, "room": {})", "sim.json /room: is seen by nobody without depth"},
      {R"(, "depth": {"takes": 1})", "sim.json /depth/takes: must be true or false"},
      {R"(, "depth": {"takes": true, "sigma": 1})", "sim.json /depth/sigma: is an unknown key"},
      {R"(, "depth": {"takes": true, "axial": {"level_m": 1}})",
       "sim.json /depth/axial/level_m: is an unknown"},
      {R"(, "depth": {"lateral_sigma_m": -1})", "sim.json /depth/lateral_sigma_m: must lie between 0"},
      {R"(, "depth": {"edge_dropped_share": 80})",
       "sim.json /depth/edge_dropped_share: must lie between 0 and 1"},
      {R"(, "depth": {"wiggle_length_low_m": 3})",
       "sim.json /depth/wiggle_length_high_m: must not be less than wiggle_length_low_m"},
      {R"(, "depth": {"nearest_m": 9})", "sim.json /depth/farthest_m: must be farther than nearest_m"},
      {R"(, "wand": {"positions": 2})", "sim.json /wand/positions: must be 3 to 10000"},
      {R"(, "wand": {"hold_s": 0})", "sim.json /wand/hold_s: must lie between 0.1"},
      {R"(, "wand": {"move": 1})", "sim.json /wand/move: is an unknown key"},
      {R"(, "wand": {"stick_radius_m": 0.1})",
       "sim.json /wand/stick_radius_m: must lie between 0.001 and 0.075"},
      {R"(, "wand": {}, "room": {"walls": 5})", "sim.json /room/walls: must be 0 to 4"},
      {R"(, "mocap": {"rate_hz": 100, "rate_hz": 120})", "sim.json: has the key \"rate_hz\" twice"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(simulation_refusal(members), HasSubstr(message)) << members;
  EXPECT_THAT(message_of([] { read_simulation("/nonexistent/sim.json"); }),
              HasSubstr("/nonexistent/sim.json"));
}

TEST(SimulationSpec, DepthAndWandAreAbsentUnlessAskedForAndHaveDefaults) {
  const auto parsed = [](const std::string& members) {
    return parse_simulation(
        parse_json(R"({"format": "trilat.simulation", "version": 1)" + members + "}", "sim.json"), "sim.json",
        {});
  };
  EXPECT_FALSE(parsed("").depth.takes);
  EXPECT_FALSE(parsed("").wand);
  const SimulationSpec wand = parsed(R"(, "wand": {})");
  ASSERT_TRUE(wand.wand);
  EXPECT_FALSE(wand.depth.takes);
  EXPECT_EQ(wand.wand->motion.positions, 50u);
  EXPECT_EQ(wand.wand->shape.ball_radius_m, 0.075);
  EXPECT_TRUE(wand.wand->person);
  EXPECT_EQ(wand.room.walls, 3);
  const SimulationSpec all = parsed(R"(, "depth": {"takes": true, "axial": {"square_mm": 0.5},
      "grazing_limit_rad": 1.2}, "wand": {"positions": 7, "move_s": 0.5, "person": false, "ball_radius_m": 0.1},
      "room": {"half_width_m": 4, "walls": 2})");
  EXPECT_TRUE(all.depth.takes);
  EXPECT_EQ(all.depth.noise.axial.square_mm, 0.5);
  EXPECT_EQ(all.depth.noise.axial.level_mm, 1.5);
  EXPECT_EQ(all.depth.noise.grazing_limit_rad, 1.2);
  EXPECT_EQ(all.wand->motion.positions, 7u);
  EXPECT_EQ(all.wand->motion.hold_s, 1.0);
  EXPECT_EQ(all.wand->motion.move_s, 0.5);
  EXPECT_EQ(all.wand->shape.ball_radius_m, 0.1);
  EXPECT_FALSE(all.wand->person);
  EXPECT_EQ(all.room.half_width_m, 4.0);
  EXPECT_EQ(all.room.half_depth_m, 3.0);
  EXPECT_EQ(all.room.walls, 2);
}

TEST(SimulationSpec, PathsInItAreRelativeToItsFile) {
  const Json json = parse_json(
      R"({"format": "trilat.simulation", "version": 1, "recorded": {"mocap": "a.csv", "mapping": "/m.json"}})",
      "sim.json");
  const SimulationSpec spec = parse_simulation(json, "sim.json", "/data");
  EXPECT_EQ(spec.recorded->mocap, "/data/a.csv");
  EXPECT_EQ(spec.recorded->mapping, "/m.json");
  EXPECT_EQ(spec.participants, 1u);
}

}  // namespace
}  // namespace trilat
