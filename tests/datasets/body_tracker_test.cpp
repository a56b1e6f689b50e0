// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "datasets/synthetic/generated_person.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

const SensorSpec kSensorSpec;

SimulatedSensor sensor_at(const Vector3d& position_m, std::uint64_t index = 0) {
  return draw_sensor(kSensorSpec, {}, index,
                     {"k", world_from_sensor_looking_at(position_m, {0.0, 1.0, 0.0})});
}
const Vector3d kFront(0.0, 1.0, 2.5), kBack(0.0, 1.0, -2.5), kLeft(2.5, 1.0, 0.0);

// Faces +z.
SkeletonPose standing() { return generated_motion(Person{}, Activity::standing)(0.0); }

SkeletonPose turned(double turn_rad) {
  SkeletonPose pose = standing();
  for (Vector3d& joint : pose.joint_in_world_m)
    joint = Eigen::AngleAxisd(turn_rad, Vector3d::UnitY()) * joint;
  pose.heading_rad = turn_rad;
  return pose;
}

BodyTracker tracker_of(const BodyTrackerSpec& spec, const SimulatedSensor& sensor, SimulatedItem item = {}) {
  return {spec, kSensorSpec, sensor, item};
}

TrackedFrame observe(BodyTracker& tracker, std::uint64_t frame, const SkeletonPose& pose) {
  return tracker.observe(frame, pose);
}

// How far a delivered joint is off, along the world's axes.
Vector3d error_of(const SimulatedSensor& sensor, const Body& body, std::size_t joint,
                  const SkeletonPose& pose) {
  const auto& p = body.position_m[joint];
  const Vector3d seen = sensor.pose.world_from_sensor * Eigen::Vector3f(p[0], p[1], p[2]).cast<double>();
  return seen - pose.joint_in_world_m[joint];
}

BodyTrackerSpec::Groups all_groups(double value) {
  BodyTrackerSpec::Groups groups;
  groups.fill(value);
  return groups;
}

double of_group(const BodyTrackerSpec::Groups& groups, std::size_t joint) {
  return groups[static_cast<std::size_t>(tracker_group_of(static_cast<Joint>(joint)))];
}

// Errors of every joint of a person in `frames` frames, who goes `step_m` to and fro from frame to frame.
std::vector<std::array<Vector3d, kJointCount>> errors_of(const BodyTrackerSpec& spec, std::uint64_t frames,
                                                         const SimulatedItem& item = {},
                                                         double step_m = 0.0) {
  const SimulatedSensor sensor = sensor_at(kFront);
  BodyTracker tracker = tracker_of(spec, sensor, item);
  std::vector<std::array<Vector3d, kJointCount>> errors(frames);
  for (std::uint64_t f = 0; f < frames; ++f) {
    SkeletonPose pose = standing();
    for (Vector3d& joint : pose.joint_in_world_m) joint.z() += f % 2 == 0 ? 0.0 : step_m;
    const TrackedFrame frame = observe(tracker, f, pose);
    for (std::size_t j = 0; j < kJointCount; ++j)
      errors[f][j] = error_of(sensor, frame.body.value(), j, pose);
  }
  return errors;
}

TEST(BodyTracker, WithEverySourceAtZeroJointsAreExactToSinglePrecision) {
  for (const Activity activity : {Activity::walking, Activity::arm_swing, Activity::leg_crossing}) {
    const Motion motion = generated_motion(draw_person(1, 2, 1.7, 0.1), activity);
    for (const Vector3d& place : {kFront, kBack, kLeft}) {
      const SimulatedSensor sensor = sensor_at(place);
      BodyTracker tracker = tracker_of(exact_body_tracker(), sensor);
      std::uint64_t id = 0;
      for (std::uint64_t f = 0; f < 100; ++f) {
        const SkeletonPose pose = motion(static_cast<double>(f) / 30.0);
        const TrackedFrame frame = observe(tracker, f, pose);
        ASSERT_TRUE(frame.body);
        const Body& body = *frame.body;
        if (f == 0) id = body.tracking_id;
        EXPECT_EQ(body.tracking_id, id);
        EXPECT_TRUE(frame.hidden.none() && !frame.exchanged);
        for (std::size_t j = 0; j < kJointCount; ++j) {
          EXPECT_EQ(body.tracking_state[j], 2);
          const Vector3d truth = sensor.pose.world_from_sensor.inverse() * pose.joint_in_world_m[j];
          for (int axis = 0; axis < 3; ++axis)
            ASSERT_EQ(body.position_m[j][static_cast<std::size_t>(axis)], static_cast<float>(truth[axis]));
        }
      }
    }
  }
}

TEST(BodyTracker, JitterIsWhiteAndOfTheDeclaredSize) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.jitter_sigma_m = default_body_tracker().jitter_sigma_m;
  const auto errors = errors_of(spec, 2000);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    double square = 0.0, product = 0.0;
    for (std::size_t f = 1; f < errors.size(); ++f) {
      square += errors[f][j].squaredNorm() / 3.0;
      product += errors[f][j].dot(errors[f - 1][j]) / 3.0;
    }
    const double n = static_cast<double>(errors.size() - 1);
    EXPECT_NEAR(std::sqrt(square / n) / of_group(spec.jitter_sigma_m, j), 1.0, 0.04) << j;
    EXPECT_NEAR(product / square, 0.0, 0.05) << j;
  }
}

TEST(BodyTracker, DriftHasTheDeclaredSizeAndLosesItsMemoryAlongTheDeclaredPath) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.own_drift_sigma_m = {0.006, 0.007, 0.008, 0.01, 0.012, 0.015, 0.02, 0.009, 0.011, 0.013, 0.014};
  spec.drift_path_m = 0.24;
  const auto errors = errors_of(spec, 9000, {}, 0.01);
  constexpr std::size_t kLag = 24;  // 0.24 m
  std::map<TrackerGroup, double> squares, counts;
  double product = 0.0, square = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    for (std::size_t f = kLag; f < errors.size(); ++f) {
      const double sigma = of_group(spec.own_drift_sigma_m, j);
      const TrackerGroup group = tracker_group_of(static_cast<Joint>(j));
      squares[group] += errors[f][j].squaredNorm() / (3.0 * sigma * sigma);
      counts[group] += 1.0;
      square += errors[f][j].squaredNorm() / (sigma * sigma);
      product += errors[f][j].dot(errors[f - kLag][j]) / (sigma * sigma);
    }
  for (const auto& [group, sum] : squares)
    EXPECT_NEAR(std::sqrt(sum / counts[group]), 1.0, 0.1) << name_of(group);
  EXPECT_NEAR(square / (3.0 * kJointCount * static_cast<double>(errors.size() - kLag)), 1.0, 0.05);
  EXPECT_NEAR(product / square, std::exp(-1.0), 0.04);
  for (const auto& at_rest : errors_of(spec, 100)) EXPECT_EQ(at_rest, errors_of(spec, 1).front());
}

TEST(BodyTracker, BiasIsConstantAndOfTheDeclaredSizeBetweenParticipants) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.bias_sigma_m = default_body_tracker().bias_sigma_m;
  std::map<TrackerGroup, double> squares, counts;
  for (std::uint64_t p = 0; p < 400; ++p) {
    const auto errors = errors_of(spec, 2, {1, 0, p});
    for (std::size_t j = 0; j < kJointCount; ++j) {
      EXPECT_EQ(errors[0][j], errors[1][j]);
      const TrackerGroup group = tracker_group_of(static_cast<Joint>(j));
      squares[group] += errors[0][j].squaredNorm() / 3.0;
      counts[group] += 1.0;
    }
  }
  for (const auto& [group, sum] : squares)
    EXPECT_NEAR(std::sqrt(sum / counts[group]) / spec.bias_sigma_m[static_cast<std::size_t>(group)], 1.0,
                0.07)
        << name_of(group);
}

// Sums over participants and joints of products of what two sensors make of one person.
struct TwoViews {
  Eigen::Matrix3d first = Eigen::Matrix3d::Zero(), product = Eigen::Matrix3d::Zero();  // e1 e1^T, e1 e2^T
  double along = 0.0;  // the square of e1 along the first sensor's ray
  double n = 0.0;
};
TwoViews two_views(const BodyTrackerSpec& spec, const Vector3d& one_m, const Vector3d& other_m) {
  const SkeletonPose pose = standing();
  TwoViews sums;
  for (std::uint64_t p = 0; p < 400; ++p) {
    const SimulatedSensor s1 = sensor_at(one_m, 0), s2 = sensor_at(other_m, 1);
    BodyTracker a = tracker_of(spec, s1, {1, p, p}), b = tracker_of(spec, s2, {1, p, p});
    const TrackedFrame f1 = observe(a, 0, pose), f2 = observe(b, 0, pose);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vector3d e1 = error_of(s1, f1.body.value(), j, pose), e2 = error_of(s2, f2.body.value(), j, pose);
      sums.first += e1 * e1.transpose();
      sums.along += std::pow(e1.dot((pose.joint_in_world_m[j] - one_m).normalized()), 2);
      sums.product += e1 * e2.transpose();
      sums.n += 1.0;
    }
  }
  return sums;
}

TEST(BodyTracker, ErrorsSplitAlongAndAcrossTheRayAsDeclaredAndKeepTheirSum) {
  for (const double ratio : {0.2, 1.0, 4.0}) {
    BodyTrackerSpec spec = exact_body_tracker();
    spec.drift_sigma_m = all_groups(0.03);
    spec.ray_ratio = ratio;
    const TwoViews views = two_views(spec, kFront, kLeft);
    EXPECT_NEAR(views.first.trace() / views.n / 3.0, 0.03 * 0.03, 0.03 * 0.03 * 0.05) << ratio;
    const double across = 0.5 * (views.first.trace() - views.along);
    EXPECT_NEAR(std::sqrt(views.along / across), ratio, 0.05 * ratio) << ratio;
  }
}

// Of each part: how much of the error's square two sensors at a right angle, and opposite ones, have in
// common.
TEST(BodyTracker, SensorsShareWhatIsCommonAndWhatGoesWithTheDirectionOfView) {
  struct Case {
    BodyTrackerSpec::Groups BodyTrackerSpec::*part;
    double beside, opposite;
  };
  for (const Case& c : {Case{&BodyTrackerSpec::bias_sigma_m, 1.0, 1.0},
                        {&BodyTrackerSpec::view_bias_sigma_m, 0.0, -1.0},
                        {&BodyTrackerSpec::own_bias_sigma_m, 0.0, 0.0},
                        {&BodyTrackerSpec::drift_sigma_m, 1.0, 1.0},
                        {&BodyTrackerSpec::view_drift_sigma_m, 0.0, -1.0},
                        {&BodyTrackerSpec::own_drift_sigma_m, 0.0, 0.0}}) {
    BodyTrackerSpec spec = exact_body_tracker();
    spec.*c.part = all_groups(0.03);
    const TwoViews beside = two_views(spec, kFront, kLeft), opposite = two_views(spec, kFront, kBack);
    EXPECT_NEAR(beside.product.trace() / beside.first.trace(), c.beside, 0.04);
    EXPECT_NEAR(opposite.product.trace() / opposite.first.trace(), c.opposite, 0.04);
    EXPECT_NEAR(beside.first.trace() / beside.n / 3.0, 0.03 * 0.03, 0.03 * 0.03 * 0.05);
  }
}

TEST(BodyTracker, BodiesLieWhereTheUnitsDepthIsOff) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.unit_depth_share = 0.5;
  SimulatedSensor sensor = sensor_at(kFront);
  sensor.unit = {.offset_m = 0.02};
  BodyTracker tracker = tracker_of(spec, sensor);
  const SkeletonPose pose = standing();
  const TrackedFrame frame = observe(tracker, 0, pose);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vector3d ray = (pose.joint_in_world_m[j] - kFront).normalized();
    EXPECT_LT((error_of(sensor, frame.body.value(), j, pose) - 0.01 * ray).norm(), 1e-6);
  }
}

TEST(BodyTracker, BiasTurnsWithTheBody) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.bias_sigma_m = spec.view_bias_sigma_m = all_groups(0.05);
  constexpr double kTurn = 0.9;
  const SimulatedSensor straight = sensor_at(kFront);
  const Eigen::AngleAxisd turn(kTurn, Vector3d::UnitY());
  const SimulatedSensor beside = sensor_at(turn * kFront);
  for (const bool knows_heading : {true, false}) {
    BodyTracker a = tracker_of(spec, straight), b = tracker_of(spec, beside);
    SkeletonPose pose = turned(kTurn);
    if (!knows_heading) pose.heading_rad = 0.0;  // as of recorded motions: the shoulders tell
    const TrackedFrame first = observe(a, 0, standing()), second = observe(b, 0, pose);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Vector3d expected = turn * error_of(straight, first.body.value(), j, standing());
      EXPECT_GT(expected.norm(), 1e-3);
      EXPECT_LT((error_of(beside, second.body.value(), j, pose) - expected).norm(), 1e-5);
    }
  }
}

TEST(BodyTracker, ASteadyMotionIsFollowedTheDeclaredTimeLater) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.lag_s = 0.045;
  const Vector3d speed_m_s(0.4, 0.1, -0.2);
  const SimulatedSensor sensor = sensor_at(kFront);
  BodyTracker tracker = tracker_of(spec, sensor);
  for (std::uint64_t f = 0; f < 60; ++f) {
    SkeletonPose pose = standing();
    for (Vector3d& joint : pose.joint_in_world_m) joint += static_cast<double>(f) / 30.0 * speed_m_s;
    const TrackedFrame frame = observe(tracker, f, pose);
    if (f == 0) {
      EXPECT_LT(error_of(sensor, frame.body.value(), 3, pose).norm(), 1e-6);
    }
    if (f < 30) continue;
    for (std::size_t j = 0; j < kJointCount; ++j)
      if (frame.body.value().tracking_state[j] == 2) {
        EXPECT_LT((error_of(sensor, frame.body.value(), j, pose) + 0.045 * speed_m_s).norm(), 1e-6);
      }
  }
}

TEST(BodyTracker, JumpsComeAtTheDeclaredRateAndHaveTheDeclaredSizeAndDuration) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.jump_rate_per_minute = all_groups(6.0);
  spec.jump_size_m = 0.1;
  spec.jump_duration_s = 0.1;  // three frames
  const auto errors = errors_of(spec, 9000);
  double jumps = 0.0, free_frames = 0.0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    for (std::size_t f = 1; f + 3 < errors.size(); ++f) {
      const bool began = errors[f][j].norm() > 0.01 && (errors[f - 1][j] - errors[f][j]).norm() > 1e-4;
      if (began) {
        ++jumps;
        EXPECT_NEAR(errors[f][j].norm(), 0.1, 1e-5);
        EXPECT_LT((errors[f + 2][j] - errors[f][j]).norm(), 1e-5);
        EXPECT_GT((errors[f + 3][j] - errors[f][j]).norm(), 1e-3);
      }
      if (began || errors[f][j].norm() < 1e-4) ++free_frames;  // in which a jump may begin
    }
  EXPECT_NEAR(jumps / (free_frames / 30.0 / 60.0), 6.0, 0.5);
}

TEST(BodyTracker, JumpsThatLastNoTimeAreNone) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.jump_rate_per_minute = all_groups(600.0);
  spec.jump_size_m = 0.1;
  spec.jump_duration_s = 0.0;
  for (const auto& joints : errors_of(spec, 30))
    for (const auto& error : joints) EXPECT_LT(error.norm(), 1e-6);
}

// Seen from the left, the right arm is behind the trunk.
TEST(BodyTracker, HiddenJointsAreInferredOrForTheDeclaredShareOfStretchesSaidToBeTracked) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.least_visible_share = 0.5;
  spec.inferred_error_sigma_m.fill(0.05);
  spec.hidden_as_tracked_share = 0.3;
  const SimulatedSensor sensor = sensor_at(kLeft);
  const SkeletonPose pose = standing();
  double stretches = 0.0, tracked = 0.0, square = 0.0;
  for (std::uint64_t take = 0; take < 300; ++take) {
    BodyTracker tracker = tracker_of(spec, sensor, {1, take, take});
    const TrackedFrame first = observe(tracker, 0, pose), second = observe(tracker, 1, pose);
    ASSERT_EQ(first.hidden, second.hidden);
    EXPECT_TRUE(first.hidden[static_cast<std::size_t>(Joint::elbow_right)]);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const Body& body = first.body.value();
      EXPECT_EQ(body.position_m[j], second.body.value().position_m[j]);
      EXPECT_EQ(body.tracking_state[j], second.body.value().tracking_state[j]);
      const Vector3d error = error_of(sensor, body, j, pose);
      if (!first.hidden[j]) {
        EXPECT_EQ(body.tracking_state[j], 2);
        EXPECT_LT(error.norm(), 1e-6);
        continue;
      }
      ++stretches;
      tracked += body.tracking_state[j] == 2 ? 1.0 : 0.0;
      EXPECT_GE(body.tracking_state[j], 1);
      square += error.squaredNorm() / 3.0;
    }
  }
  EXPECT_GT(stretches, 1500.0);
  EXPECT_NEAR(tracked / stretches, 0.3, 0.04);
  EXPECT_NEAR(std::sqrt(square / stretches), 0.05, 0.002);
}

TEST(BodyTracker, SidesAreExchangedOnlyFromBehindAndForTheDeclaredShareOfStretches) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.back_view_angle_rad = 2.0 * kPi / 3.0;
  spec.exchanged_share = 0.5;
  const SkeletonPose pose = standing();
  double exchanged = 0.0;
  for (std::uint64_t take = 0; take < 600; ++take) {
    const SimulatedSensor sensor = sensor_at(kBack);
    BodyTracker tracker = tracker_of(spec, sensor, {1, take, 0});
    const TrackedFrame first = observe(tracker, 0, pose), second = observe(tracker, 1, pose);
    EXPECT_EQ(first.exchanged, second.exchanged);
    exchanged += first.exchanged ? 1.0 : 0.0;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto shown = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
      const Vector3d error = error_of(sensor, first.body.value(), first.exchanged ? shown : j, pose);
      const Vector3d moved = pose.joint_in_world_m[first.exchanged ? shown : j] - pose.joint_in_world_m[j];
      EXPECT_LT((error + moved).norm(), 1e-6);
    }
  }
  EXPECT_NEAR(exchanged / 600.0, 0.5, 0.06);
  spec.exchanged_share = 1.0;
  for (const Vector3d& place : {kFront, kLeft}) {
    BodyTracker tracker = tracker_of(spec, sensor_at(place));
    EXPECT_FALSE(observe(tracker, 0, pose).exchanged);
  }
}

// Nearly the same view, nearly the same errors: also of a body whose back is taken for its front.
TEST(BodyTracker, ABackThatIsTakenForTheFrontIsABodyThatFacesTheOtherWay) {
  BodyTrackerSpec spec = exact_body_tracker();
  spec.back_view_angle_rad = 2.0;
  spec.exchanged_share = 1.0;
  spec.view_bias_sigma_m = all_groups(0.03);
  BodyTracker tracker = tracker_of(spec, sensor_at(kFront));
  std::vector<bool> exchanged;
  std::uint64_t frame = 0;
  for (const double angle : {1.9, 2.1, 1.9, -2.1, -2.2, -1.9})
    exchanged.push_back(observe(tracker, frame++, turned(angle)).exchanged);
  EXPECT_THAT(exchanged, testing::ElementsAre(false, true, false, true, true, false));

  const SimulatedSensor sensor = sensor_at(kFront);
  BodyTracker from_behind = tracker_of(spec, sensor), from_ahead = tracker_of(spec, sensor);
  const SkeletonPose back = turned(kPi), front = turned(0.0);
  const Body seen_behind = observe(from_behind, 0, back).body.value(),
             seen_ahead = observe(from_ahead, 0, front).body.value();
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
    const Vector3d moved = back.joint_in_world_m[mirror] - back.joint_in_world_m[j];
    EXPECT_LT(
        (error_of(sensor, seen_behind, j, back) - moved - error_of(sensor, seen_ahead, j, front)).norm(),
        1e-5);
  }
}

TEST(BodyTracker, WhoLeavesTheViewIsGoneAndReturnsAsSomebodyElse) {
  BodyTracker tracker = tracker_of(exact_body_tracker(), sensor_at(kFront));
  SkeletonPose away = standing();
  for (Vector3d& joint : away.joint_in_world_m) joint.x() += 20.0;
  const auto id = observe(tracker, 0, standing()).body.value().tracking_id;
  EXPECT_GT(id, std::uint64_t{1} << 56);
  EXPECT_EQ(observe(tracker, 1, standing()).body.value().tracking_id, id);
  EXPECT_FALSE(observe(tracker, 2, away).body);
  EXPECT_NE(observe(tracker, 3, standing()).body.value().tracking_id, id);
}

TEST(BodyTracker, WhatOneSensorSaysDoesNotDependOnTheOthers) {
  const Motion motion = generated_motion(Person{}, Activity::walking);
  const SimulatedSensor a = sensor_at(kFront, 0), b = sensor_at(kLeft, 1);
  BodyTracker a1 = tracker_of(default_body_tracker(), a), b1 = tracker_of(default_body_tracker(), b);
  BodyTracker a2 = tracker_of(default_body_tracker(), a);
  for (std::uint64_t f = 0; f < 60; ++f) {
    const SkeletonPose pose = motion(static_cast<double>(f) / 30.0);
    const TrackedFrame beside = observe(a1, f, pose), alone = observe(a2, f, pose);
    observe(b1, f, pose);
    EXPECT_EQ(alone.hidden, beside.hidden);
    EXPECT_EQ(alone.body.value().position_m, beside.body.value().position_m);
    EXPECT_EQ(alone.body.value().tracking_state, beside.body.value().tracking_state);
  }
}

}  // namespace
}  // namespace trilat
