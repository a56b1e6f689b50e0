// SPDX-License-Identifier: MIT
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/units.h"
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
  constexpr double kStep_s = 1e-3, kMaxSpeed_m_s = 6.0, kMaxAcceleration_m_s2 = 60.0;
  for (const Activity activity : kActivities) {
    const Motion motion = generated_motion(draw_person(3, 1, 1.70, 0.17), activity);
    for (double t = 0.0; t < 40.0; t += 0.017) {
      const SkeletonPose before = motion(t - kStep_s), at = motion(t), after = motion(t + kStep_s);
      EXPECT_TRUE(at.present.all());
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const Vector3d& p = at.joint_in_world_m[j];
        ASSERT_TRUE(p.allFinite());
        ASSERT_LT((after.joint_in_world_m[j] - p).norm() / kStep_s, kMaxSpeed_m_s);
        ASSERT_LT(
            (after.joint_in_world_m[j] - 2.0 * p + before.joint_in_world_m[j]).norm() / (kStep_s * kStep_s),
            kMaxAcceleration_m_s2)
            << word_of(activity) << " joint " << j << " at " << t << " s";
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
  for (const Activity activity : {Activity::walking, Activity::steps, Activity::walk_and_stop})
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
        ASSERT_GE(standing, 1u) << word_of(activity) << " at " << t << " s";
        for (const Joint knee : {Joint::knee_left, Joint::knee_right})
          ASSERT_NEAR((at.at(knee) - at.at(parent_of(knee).value())).norm(), 0.245 * stature_m, 1e-9);
        for (const Joint ankle : {Joint::ankle_left, Joint::ankle_right})
          ASSERT_NEAR((at.at(ankle) - at.at(parent_of(ankle).value())).norm(), 0.246 * stature_m, 1e-9);
      }
    }
}

struct AngleRange {
  double min_deg, max_deg;
};

// Least and largest of an angle over a minute, of a person whose amplitude is 1.
AngleRange range_of(Activity activity, const std::function<double(const SkeletonPose&)>& angle_rad) {
  const Motion motion = generated_motion({.stature_m = 1.7, .tempo = 1.0, .amplitude = 1.0}, activity);
  AngleRange range{1e3, -1e3};
  for (double t = 0.0; t < 60.0; t += 0.01) {
    const double degrees = angle_rad(motion(t)) / kRadPerDegree;
    range = {std::min(range.min_deg, degrees), std::max(range.max_deg, degrees)};
  }
  return range;
}

void expect_range(const AngleRange& range, double min_deg, double max_deg, double within_deg) {
  EXPECT_NEAR(range.min_deg, min_deg, within_deg);
  EXPECT_NEAR(range.max_deg, max_deg, within_deg);
}

double bend_rad(const SkeletonPose& pose, Joint from, Joint at, Joint to) {
  const Vector3d in = pose.at(at) - pose.at(from), out = pose.at(to) - pose.at(at);
  return std::atan2(in.cross(out).norm(), in.dot(out));
}

// From straight down to straight ahead.
double flexion_rad(const SkeletonPose& pose, Joint from, Joint to) {
  const Vector3d along = pose.at(to) - pose.at(from);
  const Vector3d forward(std::sin(pose.heading_rad), 0.0, std::cos(pose.heading_rad));
  return std::atan2(along.dot(forward), -along.y());
}

// Who walks swings each arm by 26 degrees to and fro and bends the elbow by 20 to 37; who swings the arms
// goes from -40 to 63 degrees at the shoulder. Abduction by 7 degrees makes bends seem a little smaller.
TEST(GeneratedPerson, ArmsAndTrunkSwingAsFarAsTheActivitySays) {
  for (const auto& [shoulder, elbow, wrist] :
       {std::tuple{Joint::shoulder_left, Joint::elbow_left, Joint::wrist_left},
        std::tuple{Joint::shoulder_right, Joint::elbow_right, Joint::wrist_right}}) {
    const auto arm = [&, from = shoulder, to = elbow](const SkeletonPose& pose) {
      return flexion_rad(pose, from, to);
    };
    const auto bend = [&, from = shoulder, at = elbow, to = wrist](const SkeletonPose& pose) {
      return bend_rad(pose, from, at, to);
    };
    expect_range(range_of(Activity::walking, arm), -25.8, 25.8, 0.3);
    expect_range(range_of(Activity::walking, bend), 20.0, 37.0, 0.4);
    expect_range(range_of(Activity::arm_swing, arm), -40.1, 63.0, 0.3);
    expect_range(range_of(Activity::arm_swing, bend), 17.1, 39.8, 0.4);
  }
  const auto lean = [](const SkeletonPose& pose) {
    return -flexion_rad(pose, Joint::neck, Joint::spine_base);
  };
  expect_range(range_of(Activity::arm_swing, lean), -1.15, 1.15, 0.02);
  expect_range(range_of(Activity::walking, lean), 2.86, 2.86, 0.02);
}

// Who crosses the legs swings each by 0.3 rad to and fro, a little more as it goes aside.
TEST(GeneratedPerson, LegsCrossAsFarOnBothSides) {
  for (const auto& [hip, knee] :
       {std::pair{Joint::hip_left, Joint::knee_left}, std::pair{Joint::hip_right, Joint::knee_right}}) {
    const auto thigh = [&, from = hip, to = knee](const SkeletonPose& pose) {
      return flexion_rad(pose, from, to);
    };
    expect_range(range_of(Activity::leg_crossing, thigh), -17.2, 17.2, 2.0);
  }
}

TEST(GeneratedPerson, AFootIsLiftedByAFifthOfItsStep) {
  const Motion motion =
      generated_motion({.stature_m = 1.7, .tempo = 1.0, .amplitude = 1.0}, Activity::walking);
  for (const Joint ankle : {Joint::ankle_left, Joint::ankle_right}) {
    const double standing_m = 0.039 * 1.7;
    double lift_m = 0.0, step_m = 0.0;
    Vector3d stood = motion(0.0).at(ankle);
    for (double t = 0.0; t < 10.0; t += 0.002) {
      const Vector3d at = motion(t).at(ankle);
      lift_m = std::max(lift_m, at.y() - standing_m);
      if (at.y() - standing_m > 1e-9) continue;
      step_m = std::max(step_m, (at - stood).norm());
      stood = at;
    }
    EXPECT_NEAR(lift_m / step_m, 0.2, 0.01) << name_of(ankle);
  }
}

// Where a Kinect sees it: a little above the middle of the hips.
TEST(GeneratedPerson, TheBaseOfTheSpineLiesAboveTheHips) {
  for (const Activity activity : kActivities) {
    const SkeletonPose pose = generated_motion({.stature_m = 1.7}, activity)(0.7);
    const Vector3d hips = 0.5 * (pose.at(Joint::hip_left) + pose.at(Joint::hip_right));
    EXPECT_NEAR((pose.at(Joint::spine_base) - hips).norm(), 0.034, 1e-9);
    EXPECT_GT(pose.at(Joint::spine_base).y(), hips.y());
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

TEST(SimulatedSensor, SeesWhatLiesInItsImageAndRange) {
  const SensorSpec spec;
  SimulatedSensor sensor;
  const DepthIntrinsics& in = sensor.intrinsics;
  const auto sees = [&](double u_px, double v_px, double depth_m) {
    const Eigen::Vector2d ray = ray_through(in, {u_px, v_px}).value();
    return is_in_view(sensor, spec, depth_m * Vector3d(ray.x(), ray.y(), 1.0));
  };
  const double right_px = in.width_px - 1.0, bottom_px = in.height_px - 1.0;
  for (const double u_px : {1.0, right_px - 1.0})
    for (const double v_px : {1.0, bottom_px - 1.0})
      EXPECT_TRUE(sees(u_px, v_px, 2.0)) << u_px << " " << v_px;
  EXPECT_FALSE(sees(-1.0, 200.0, 2.0));
  EXPECT_FALSE(sees(right_px + 1.0, 200.0, 2.0));
  EXPECT_FALSE(sees(250.0, -1.0, 2.0));
  EXPECT_FALSE(sees(250.0, bottom_px + 1.0, 2.0));
  EXPECT_TRUE(sees(250.0, 200.0, spec.nearest_m + 0.01));
  EXPECT_FALSE(sees(250.0, 200.0, spec.nearest_m - 0.01));
  EXPECT_TRUE(sees(250.0, 200.0, spec.farthest_m - 0.01));
  EXPECT_FALSE(sees(250.0, 200.0, spec.farthest_m + 0.01));
  EXPECT_FALSE(is_in_view(sensor, spec, {0.0, 0.0, -2.0}));
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
    ASSERT_FALSE(markers.empty());
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
  EXPECT_THAT(heights(R"({"sensors": 1, "mean_m": 1, "spread_m": 1})"), testing::ElementsAre(1.0));
  std::set<std::vector<double>> orders;
  for (int k = 0; k < 24; ++k)
    orders.insert(heights(fmt::format(R"({{"sensors": 4, "order": {}}})", (k + 0.5) / 24.0)));
  EXPECT_EQ(orders.size(), 24u);
}

TEST(SimulationSpec, HeightsBelowTheFloorAreRefused) {
  const auto refused = [](const std::string& heights) {
    return message_of([&] {
      parse_simulation(parse_json(R"({"format": "trilat.simulation", "version": 1, "rig": {"heights_m": )" +
                                      heights + "}}",
                                  "sim.json"),
                       "sim.json", {});
    });
  };
  EXPECT_THAT(
      refused(R"({"mean_m": 1, "spread_m": 2.1})"),
      testing::HasSubstr("/rig/heights_m/spread_m: is 2.1 about a height of 1 m, which puts sensors below"));
  EXPECT_EQ(refused(R"({"mean_m": 1, "spread_m": 2})"), "no error");
  EXPECT_THAT(refused("[1, -0.2]"),
              testing::HasSubstr("/rig/heights_m/1: must lie between 0 and 8, is -0.2"));
}

// Members of an object that are alike share one row, and a value that may have two shapes names both.
TEST(SimulationSpec, ItsKeysAreDescribed) {
  std::set<std::string> described;
  const std::string text = markdown_of_schema(simulation_schema(), "simulation.json", described);
  for (const char* row : {"| `body_tracker` | object or text |",
                          "| `body_tracker.drift_sigma_m` | number or object of `trunk`, `head`,",
                          "| `body_tracker.lag_s` | number, 0 to 10 | `0.0",
                          "| `rig.heights_m` | list or object; 1 to 8 of them |",
                          "| `rig.heights_m.order` | number, 0 to 1 | `0.0` |",
                          "| `sensor.farthest_m` | number above 0, at most 100 | `4.5` |",
                          "| `name` | text | `\"simulated\"` |"})
    EXPECT_THAT(text, testing::HasSubstr(row));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("drift_sigma_m.trunk")));
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
