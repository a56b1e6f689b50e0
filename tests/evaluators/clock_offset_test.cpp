// SPDX-License-Identifier: MIT
#include "evaluators/alignment/clock_offset.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr std::array kJoints{Joint::head,       Joint::shoulder_left, Joint::shoulder_right,
                             Joint::elbow_left, Joint::elbow_right,   Joint::wrist_left,
                             Joint::wrist_right};

struct Recording {
  std::vector<PointPath> estimate, truth;
};

struct Disturbance {
  double noise_m = 0.010;
  double duration_s = 20.0;
  double drift = 0.0;
  double lost_share = 0.02;
  double truth_hz = 120.0;
};

// A person seen at 30 Hz with noise, and exactly at truth_hz; truth(t + offset) is what the estimate shows at
// t.
Recording record(const Motion& motion, double offset_s, std::uint64_t seed, const Disturbance& d = {}) {
  Recording recording;
  for (std::size_t j = 0; j < kJoints.size(); ++j) {
    PointPath estimate, truth;
    for (int i = 0; i < static_cast<int>(d.duration_s * d.truth_hz); ++i) {
      const double t = i / d.truth_hz;
      truth.time_s.push_back(t);
      truth.position_m.push_back(motion(t).at(kJoints[j]));
    }
    for (int i = 0; i < static_cast<int>(d.duration_s * 30.0); ++i) {
      const double t = i / 30.0;
      const RandomStream random{seed, Purpose::test, random_item(0, j, 0, static_cast<std::uint64_t>(i))};
      Vector3d noise(random.normal(0), random.normal(1), random.normal(2));
      if (random.uniform(9) < d.lost_share) noise.setConstant(kNaN);
      estimate.time_s.push_back(t);
      estimate.position_m.push_back(motion(t + offset_s + d.drift * t).at(kJoints[j]) + d.noise_m * noise);
    }
    recording.estimate.push_back(estimate);
    recording.truth.push_back(truth);
  }
  return recording;
}

ClockOffset find(const Recording& recording, const ClockOffsetOptions& options = {}) {
  return find_clock_offset(recording.estimate, recording.truth, options);
}

Motion walker(std::uint64_t person) {
  return generated_motion(draw_person(3, person, 1.7, 0.17), Activity::walking);
}

TEST(ClockOffset, IsFoundWithinAMillisecondInTwentySecondsOfWalking) {
  int within = 0, covered = 0;
  const int trials = 20;
  double squares = 0.0;
  for (int k = 0; k < trials; ++k) {
    const auto number = static_cast<std::uint64_t>(k);
    const double offset_s = RandomStream{11, Purpose::test, number}.uniform(0, -0.1, 0.1);
    const ClockOffset found = find(record(walker(number), offset_s, number, {.truth_hz = 60.0}));
    ASSERT_EQ(found.status, ClockOffsetStatus::found) << k << ' ' << name_of(found.status);
    const double off = found.offset_s - offset_s;
    squares += off * off;
    within += std::abs(off) < 1e-3;
    covered += found.low_s <= offset_s && offset_s <= found.high_s;
  }
  RecordProperty("rms_ms", std::to_string(1e3 * std::sqrt(squares / trials)));
  EXPECT_GE(within, 19);   // 95 %
  EXPECT_GE(covered, 17);  // 85 %: of 20 at 95 % fewer is less likely than 1 in 50
}

TEST(ClockOffset, WithoutNoiseIsExactToASmallPartOfAFrame) {
  const ClockOffset found = find(
      record(walker(1), 0.0123, 1, {.noise_m = 0.0, .duration_s = 20.0, .drift = 0.0, .lost_share = 0.0}));
  ASSERT_EQ(found.status, ClockOffsetStatus::found);
  EXPECT_NEAR(found.offset_s, 0.0123, 5e-5);
  EXPECT_GT(found.peak, 0.999);
  EXPECT_LE(found.peak, 1.0 + 1e-12);
}

TEST(ClockOffset, IsFoundBetweenFramesThatAreTurned) {
  Recording recording = record(walker(2), 0.0456, 2);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.0, Vector3d(1.0, 2.0, 3.0).normalized()));
  for (PointPath& path : recording.estimate)
    for (Vector3d& position_m : path.position_m) position_m = turn * position_m + Vector3d(1.0, 2.0, 3.0);
  const ClockOffset found = find(recording, {.frames = StreamFrames::turned});
  ASSERT_EQ(found.status, ClockOffsetStatus::found) << name_of(found.status);
  EXPECT_NEAR(found.offset_s, 0.0456, 1.5e-3);
}

TEST(ClockOffset, IsFoundWhereTheTruthCoversAPartOfTheTake) {
  for (const double share : {0.6, 0.45, 0.3}) {
    Recording recording = record(walker(3), 0.05, 8, {.duration_s = 40.0});
    for (PointPath& truth : recording.truth) {
      const auto kept = static_cast<std::size_t>(share * static_cast<double>(truth.time_s.size()));
      truth.time_s.resize(kept);
      truth.position_m.resize(kept);
    }
    const ClockOffset found = find(recording);
    EXPECT_EQ(found.status, ClockOffsetStatus::found) << share;
    EXPECT_NEAR(found.offset_s, 0.05, 0.003) << share;
  }
}

TEST(ClockOffset, IsRefusedOnStandingStill) {
  const Motion still = generated_motion(draw_person(3, 0, 1.7, 0.17), Activity::standing);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const ClockOffset found = find(record(still, 0.02, seed));
    EXPECT_EQ(found.status, ClockOffsetStatus::too_little_motion);
    EXPECT_TRUE(std::isnan(found.offset_s));
  }
}

TEST(ClockOffset, IsRefusedWhenTheStreamsShowDifferentMotions) {
  Recording recording = record(walker(1), 0.0, 1);
  recording.truth = record(walker(5), 7.3, 1).truth;
  const ClockOffset found = find(recording);
  EXPECT_NE(found.status, ClockOffsetStatus::found) << found.offset_s;
}

TEST(ClockOffset, IsRefusedWhenAPeriodFitsTwiceIntoTheSearch) {
  // one hand waving four times a second: its speed repeats every eighth of a second
  const Motion waving = [](double t) {
    SkeletonPose pose;
    pose.present.set();
    for (const Joint joint : kJoints)
      pose.at(joint) = Vector3d(0.2 * std::sin(8.0 * 3.14159265358979 * t), 1, 2);
    return pose;
  };
  EXPECT_EQ(find(record(waving, 0.01, 1)).status, ClockOffsetStatus::ambiguous);
}

TEST(ClockOffset, BeyondTheSearchIsSaid) {
  const ClockOffset found = find(record(walker(2), 0.2, 1), {.search_s = 0.1});
  EXPECT_EQ(found.status, ClockOffsetStatus::at_limit);
}

TEST(ClockOffset, ATakeTooShortIsRefused) {
  const ClockOffset found = find(record(walker(2), 0.01, 1, {.duration_s = 2.0}));
  EXPECT_NE(found.status, ClockOffsetStatus::found);
}

TEST(ClockOffset, DriftIsFoundBetweenTheThirds) {
  const ClockOffset found =
      find(record(walker(2), 0.0, 1, {.noise_m = 0.01, .duration_s = 120.0, .drift = 100e-6}));
  ASSERT_EQ(found.status, ClockOffsetStatus::found);
  EXPECT_NEAR(found.drift_ppm, 100.0, 4.0 * found.drift_sigma_ppm);
  EXPECT_LT(found.drift_sigma_ppm, 15.0);
}

TEST(ClockOffset, OffsetsOfTheJointsDoNotMatter) {
  Recording recording = record(walker(2), 0.015, 1);
  for (std::size_t j = 0; j < recording.estimate.size(); ++j)
    for (Vector3d& position : recording.estimate[j].position_m)
      position += Vector3d(0.1, -0.05, 0.02 * static_cast<double>(j));
  const ClockOffset found = find(recording);
  ASSERT_EQ(found.status, ClockOffsetStatus::found);
  EXPECT_NEAR(found.offset_s, 0.015, 1e-3);
}

TEST(LocalMotion, OfAStraightMotionIsExact) {
  PointPath path;
  for (int i = 0; i < 60; ++i) {
    path.time_s.push_back(i / 30.0);
    path.position_m.push_back(Vector3d(1.0, 2.0, 3.0) + i / 30.0 * Vector3d(0.5, -1.0, 0.25));
  }
  path.position_m[31].setConstant(kNaN);
  const auto motion = local_motion(path, 1.03, 0.06, 0.1);
  ASSERT_TRUE(motion);
  EXPECT_NEAR((motion->velocity_m_s - Vector3d(0.5, -1.0, 0.25)).norm(), 0.0, 1e-10);
  EXPECT_NEAR((motion->position_m - Vector3d(1.0, 2.0, 3.0) - 1.03 * Vector3d(0.5, -1.0, 0.25)).norm(), 0.0,
              1e-12);
}

TEST(LocalMotion, IsNotOfTwoPointsAlone) {
  const PointPath two{{0.0, 0.03}, {Vector3d::Zero(), Vector3d::UnitX()}};
  EXPECT_FALSE(local_motion(two, 0.01, 0.06, 0.1));
  const PointPath three{{0.0, 0.03, 0.06}, {Vector3d::Zero(), Vector3d::UnitX(), 2.0 * Vector3d::UnitX()}};
  EXPECT_TRUE(local_motion(three, 0.01, 0.06, 0.1));
}

TEST(LocalMotion, IsNowhereAtTheEndsAndInHoles) {
  PointPath path;
  for (int i = 0; i < 60; ++i) {
    path.time_s.push_back(i / 30.0);
    path.position_m.push_back(i > 25 && i < 32 ? Vector3d::Constant(kNaN) : Vector3d::Zero());
  }
  EXPECT_FALSE(local_motion(path, -0.01, 0.06, 0.1));
  EXPECT_FALSE(local_motion(path, 2.1, 0.06, 0.1));
  EXPECT_FALSE(local_motion(path, 28.0 / 30.0, 0.06, 0.1));
  EXPECT_TRUE(local_motion(path, 15.0 / 30.0, 0.06, 0.1));
}

}  // namespace
}  // namespace trilat
