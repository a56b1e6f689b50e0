// SPDX-License-Identifier: MIT
#include "evaluators/fusion/self_calibration.h"

#include <gmock/gmock.h>

#include "evaluators/fusion/baselines.h"
#include "tests/evaluators/seen_joints.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

constexpr std::uint32_t kJoints = 25;

// How a rig is off, and how its trackers err.
struct OffRig {
  double rotation_rad = 0.03, translation_m = 0.01, range_m = 0.015;  // standard deviations of each sensor
  double joint_m = 0.02;  // constant error of each joint in each sensor's view, an axis
  double noise_m = 0.02;  // an axis
  double reach_m = 0.5;   // how far the person walks; 0 stands still
  std::size_t instants = 60;
  std::vector<RigidTransform> rig = circle_rig({0.6, 2.2, 0.9, 1.9});
};

struct OffTake {
  std::vector<RigidTransform> stated;
  std::vector<PoseCorrection> truth;
  std::vector<JointObservation> observations;
  std::vector<std::uint32_t> joint;
  std::vector<Eigen::Vector3d> truth_m;

  SelfCalibration calibrate(const PosePriors& priors = {}) const {
    return self_calibrate(observations, stated, joint, priors);
  }
  // Of the mean of the sensors' positions.
  double mean_error_m(const std::vector<PoseCorrection>& corrections) const {
    double sum_m = 0.0;
    for (std::size_t i = 0; i < joint.size(); ++i) {
      std::vector<JointObservation> seen;
      for (std::size_t s = 0; s < stated.size(); ++s)
        seen.push_back(corrected_view(observations[i * stated.size() + s], stated[s], corrections[s]));
      sum_m += (solve_mean(seen, {}).position_m - truth_m[i]).norm();
    }
    return sum_m / static_cast<double>(joint.size());
  }
};

OffTake off_take(const OffRig& spec, std::uint64_t seed) {
  OffTake take;
  take.stated = spec.rig;
  std::vector<RigidTransform> standing;
  for (std::size_t s = 0; s < spec.rig.size(); ++s) {
    const RandomStream random{seed, Purpose::test, 1'000'000 + s};
    PoseCorrection off;
    off.rotation_rad = spec.rotation_rad * normal_vector_of(random, 0);
    off.translation_m = spec.translation_m * normal_vector_of(random, 4);
    off.range_m = spec.range_m * random.normal(8);
    take.truth.push_back(off);
    standing.push_back(corrected_pose(spec.rig[s], off));
  }
  for (std::size_t i = 0; i < spec.instants; ++i)
    for (std::uint32_t j = 0; j < kJoints; ++j) {
      const RandomStream at{seed, Purpose::test, i}, of_joint{seed, Purpose::test, 2'000'000 + j},
          now{seed, Purpose::test, 3'000'000 + i * kJoints + j};
      const Eigen::Vector3d walked_m =
          spec.reach_m * Eigen::Vector3d(at.uniform(0) - 0.5, 0.0, at.uniform(1) - 0.5);
      const Eigen::Vector3d joint_m =
          walked_m + 0.5 * some_joint_m(of_joint) + Eigen::Vector3d(0.0, 0.5, 0.0);
      for (std::size_t s = 0; s < standing.size(); ++s) {
        const auto at_s = static_cast<std::uint32_t>(16 + 4 * s);
        const Eigen::Vector3d seen_m = joint_m + spec.joint_m * normal_vector_of(of_joint, at_s) +
                                       spec.noise_m * normal_vector_of(now, at_s);
        const Eigen::Vector3d v = standing[s].inverse() * seen_m;
        take.observations.push_back(
            observe(v * (1.0 + take.truth[s].range_m / v.norm()), TrackingState::tracked, take.stated[s]));
      }
      take.joint.push_back(j);
      take.truth_m.push_back(joint_m);
    }
  return take;
}

// What is not seen, or lies in the sensor's own place, has no ray to be corrected along.
TEST(CorrectedView, WhatIsNotSeenOrHasNoRangeStaysAsItIs) {
  const PoseCorrection off{{0.1, 0.0, 0.0}, {0.2, 0.0, 0.0}, 0.3};
  JointObservation unseen;
  unseen.seen = false;
  unseen.range_m = 2.0;
  unseen.point_in_world_m = {0.0, 1.0, 2.0};
  JointObservation on_sensor = unseen;
  on_sensor.seen = true;
  on_sensor.range_m = 0.0;
  for (const JointObservation& view : {unseen, on_sensor}) {
    const JointObservation same = corrected_view(view, {}, off);
    EXPECT_EQ(same.range_m, view.range_m);
    EXPECT_EQ(same.point_in_world_m, view.point_in_world_m);
  }
  JointObservation seen = unseen;
  seen.seen = true;
  EXPECT_EQ(corrected_view(seen, {}, off).range_m, 1.7);
}

TEST(SelfCalibration, CorrectionsTakeAwayWhatTheyAre) {
  const OffTake take = off_take({.joint_m = 0.0, .noise_m = 0.0}, 1);
  EXPECT_LT(take.mean_error_m(take.truth), 1e-12);
}

TEST(SelfCalibration, FindsTurnedSensorsAndRangesThatAreTooLong) {
  OffRig spec{.rotation_rad = 0.0, .translation_m = 0.0, .range_m = 0.0, .joint_m = 0.005, .noise_m = 0.01};
  OffTake take = off_take(spec, 2);
  const PoseCorrection off{.rotation_rad = {0.0, 0.07, 0.0}, .range_m = 0.04};
  for (std::size_t i = 0; i < take.joint.size(); ++i) {  // sensor 2 is where it is said to be, but turned
    JointObservation& o = take.observations[4 * i + 2];
    const Eigen::Vector3d v = Eigen::AngleAxisd(0.07, Eigen::Vector3d::UnitY()) *
                              (o.point_in_world_m - take.stated[2].translation_m);
    o.range_m += off.range_m;
    o.point_in_world_m = take.stated[2].translation_m + v * (o.range_m / v.norm());
  }
  const SelfCalibration found = take.calibrate();
  ASSERT_EQ(found.problem, "");
  const CorrectionMagnitudes turned = magnitudes_of(found, 2);
  EXPECT_NEAR(turned.rotation_rad.value, 0.07, 0.015);
  EXPECT_GT(turned.rotation_rad.low, 0.03);
  EXPECT_GT(turned.range_m.low, 0.01);
  for (const std::size_t s : {0u, 1u, 3u}) EXPECT_LT(magnitudes_of(found, s).rotation_rad.value, 0.025) << s;
  EXPECT_LT(take.mean_error_m(found.of_sensor), 0.5 * take.mean_error_m(std::vector<PoseCorrection>(4)));
}

// A rig that is turned and shifted as a whole shows nothing of it: its corrections turn with it.
TEST(SelfCalibration, TheWorldDoesNotMove) {
  const OffTake take = off_take({}, 10);
  OffTake moved = take;
  const RigidTransform world{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                             {0.5, 0.2, -0.1}};
  for (RigidTransform& pose : moved.stated) pose = world * pose;
  for (JointObservation& o : moved.observations) o.point_in_world_m = world * o.point_in_world_m;
  const SelfCalibration here = take.calibrate(), there = moved.calibrate();
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_LT((world.rotation * here.of_sensor[s].rotation_rad - there.of_sensor[s].rotation_rad).norm(),
              1e-9);
    EXPECT_LT((world.rotation * here.of_sensor[s].translation_m - there.of_sensor[s].translation_m).norm(),
              1e-9);
    EXPECT_NEAR(here.of_sensor[s].range_m, there.of_sensor[s].range_m, 1e-9);
  }
}

// Corrections of an exact rig are within what they are said to be known to, and change little.
TEST(SelfCalibration, LeavesAnExactRigAlone) {
  double before_m = 0.0, behind_m = 0.0, squares = 0.0, count = 0.0;
  for (std::uint64_t seed = 20; seed < 50; ++seed) {
    const OffTake take = off_take({.rotation_rad = 0.0, .translation_m = 0.0, .range_m = 0.0}, seed);
    const SelfCalibration found = take.calibrate();
    before_m += take.mean_error_m(take.truth);
    behind_m += take.mean_error_m(found.of_sensor);
    for (const PoseCorrection& c : found.of_sensor)
      for (int k = 0; k < 7; ++k) {
        const double value = k < 3 ? c.rotation_rad[k] : k < 6 ? c.translation_m[k - 3] : c.range_m;
        squares += value * value / c.covariance(k, k);
        count += 1.0;
      }
  }
  EXPECT_LT(squares / count, 1.0);
  EXPECT_LT(behind_m, 1.02 * before_m);
}

// Over 1600 sensors: 96, 100 and 93 %, lengths that may be none included.
TEST(SelfCalibration, IntervalsHoldTheTruth) {
  const std::uint64_t takes = trials(200);
  const auto holds = [takes](const Interval& magnitude, double value) {
    return magnitude.low <= value && value <= magnitude.high ? 1.0 / static_cast<double>(4 * takes) : 0.0;
  };
  double turn = 0.0, shift = 0.0, range = 0.0;
  for (std::uint64_t seed = 100; seed < 100 + takes; ++seed) {
    const OffTake take = off_take({}, seed);
    const SelfCalibration found = take.calibrate();
    for (std::size_t s = 0; s < 4; ++s) {
      const CorrectionMagnitudes m = magnitudes_of(found, s);
      turn += holds(m.rotation_rad, take.truth[s].rotation_rad.norm());
      shift += holds(m.translation_m, take.truth[s].translation_m.norm());
      range += holds(m.range_m, take.truth[s].range_m);
    }
  }
  const double by_chance = slack(0.95, 4 * takes);
  EXPECT_GT(turn, 0.93 - by_chance);
  EXPECT_LT(turn, 0.99 + by_chance);
  EXPECT_GT(shift, 0.93 - by_chance);  // mostly from 0: it may be none
  EXPECT_GT(range, 0.92 - by_chance);
  EXPECT_LT(range, 0.97 + by_chance);
}

TEST(SelfCalibration, OneGrossErrorMovesLittle) {
  OffTake take = off_take({}, 3);
  const double before_m = take.mean_error_m(take.calibrate().of_sensor);
  OffTake spoiled = take;
  for (std::size_t i = 0; i < take.joint.size(); i += 10) {  // a tenth of one sensor's views
    JointObservation& o = spoiled.observations[4 * i];
    o.point_in_world_m += Eigen::Vector3d(0.4, 0.3, 0.0);
    o.range_m = (o.point_in_world_m - take.stated[0].translation_m).norm();
  }
  EXPECT_LT(take.mean_error_m(spoiled.calibrate().of_sensor), 1.05 * before_m);
}

TEST(SelfCalibration, TwoSensorsAndAPersonWhoStandsShrinkToThePrior) {
  for (const OffRig& spec : {OffRig{.reach_m = 0.0}, OffRig{.rig = circle_rig({0.6, 2.2}, 2.0, 180.0)}}) {
    double before_m = 0.0, behind_m = 0.0;
    for (std::uint64_t seed = 60; seed < 70; ++seed) {
      const OffTake take = off_take(spec, seed);
      const SelfCalibration found = take.calibrate();
      ASSERT_EQ(found.problem, "");
      before_m += take.mean_error_m(std::vector<PoseCorrection>(spec.rig.size()));
      behind_m += take.mean_error_m(found.of_sensor);
    }
    EXPECT_LT(behind_m, before_m);
  }
}

TEST(SelfCalibration, SaysWhyItTellsNothing) {
  const OffRig one{.rig = circle_rig({1.0})};
  const SelfCalibration alone = off_take(one, 4).calibrate();
  EXPECT_THAT(alone.problem, testing::HasSubstr("fewer than 20 times do two sensors see the same joint"));
  ASSERT_EQ(alone.of_sensor.size(), 1u);
  EXPECT_EQ(alone.of_sensor[0].rotation_rad, Eigen::Vector3d::Zero());
  EXPECT_TRUE(std::isnan(magnitudes_of(alone, 0).rotation_rad.value));
  OffTake apart = off_take({}, 5);  // each joint is seen by one sensor only
  for (std::size_t i = 0; i < apart.joint.size(); ++i)
    for (std::size_t s = 0; s < 4; ++s)
      if (apart.joint[i] % 4 != s) apart.observations[4 * i + s] = {};
  EXPECT_THAT(apart.calibrate().problem, testing::HasSubstr("see the same joint"));
}

TEST(SelfCalibration, PriorsThatAreNotPositiveAreTheCallersError) {
  const OffTake take = off_take({.instants = 5}, 6);
  EXPECT_THROW(take.calibrate({.rotation_rad = 0.0}), std::exception);
  EXPECT_THROW(take.calibrate({.range_m = -1.0}), std::exception);
}

}  // namespace
}  // namespace trilat
