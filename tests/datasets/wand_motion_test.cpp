// SPDX-License-Identifier: MIT
#include "datasets/synthetic/wand_motion.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace trilat {
namespace {

using Eigen::Vector3d;

const Vector3d kCentre(0.4, 1.2, -0.3);

double horizontal_m(const Vector3d& a, const Vector3d& b) { return std::hypot(a.x() - b.x(), a.z() - b.z()); }

TEST(WandMotion, TheFirstThreePositionsDefineAFrame) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto holds = WandMotion({}, seed, kCentre, Person{}).holds();
    EXPECT_LE(horizontal_m(holds[0].ball_in_world_m, kCentre), 0.7);
    EXPECT_NEAR(holds[0].ball_in_world_m.y(), 1.0, 0.05);
    EXPECT_GE(horizontal_m(holds[1].ball_in_world_m, holds[0].ball_in_world_m), 1.2);
    EXPECT_LE(horizontal_m(holds[1].ball_in_world_m, kCentre), 0.9);
    EXPECT_LT((holds[2].ball_in_world_m - holds[0].ball_in_world_m - Vector3d(0.0, 0.6, 0.0)).norm(), 1e-12);
  }
}

TEST(WandMotion, TheOthersFillTheCylinder) {
  const auto holds = WandMotion({1000, 1.0, 0.8}, 1, kCentre, Person{}).holds();
  ASSERT_EQ(holds.size(), 1000u);
  double lowest = 9.0, highest = 0.0, farthest = 0.0, inner = 0.0;
  for (std::size_t i = 3; i < holds.size(); ++i) {
    const Vector3d& ball = holds[i].ball_in_world_m;
    lowest = std::min(lowest, ball.y());
    highest = std::max(highest, ball.y());
    farthest = std::max(farthest, horizontal_m(ball, kCentre));
    inner += horizontal_m(ball, kCentre) < 0.45;
  }
  EXPECT_NEAR(lowest, 0.4, 0.01);
  EXPECT_NEAR(highest, 1.7, 0.01);
  EXPECT_NEAR(farthest, 0.9, 0.01);
  EXPECT_NEAR(inner / 997.0, 0.25, 0.05);  // by area
}

TEST(WandMotion, TheBallIsStillWhileHeldAndMovesWithoutJumps) {
  const WandMotionSpec spec{8, 0.7, 0.5};
  const WandMotion wand(spec, 3, kCentre, Person{});
  EXPECT_NEAR(wand.duration_s(), 8 * 0.7 + 7 * 0.5, 1e-12);
  ASSERT_FALSE(wand.holds().empty());
  for (const WandHold& hold : wand.holds()) {
    EXPECT_NEAR(hold.to_s - hold.from_s, 0.7, 1e-12);
    for (const double t : {hold.from_s + 1e-9, 0.5 * (hold.from_s + hold.to_s), hold.to_s})
      EXPECT_LT((wand.at(t).ball_in_world_m - hold.ball_in_world_m).norm(), 1e-9);
  }
  const double step_s = 0.001;
  for (double t = 0.0; t < wand.duration_s(); t += step_s) {
    const WandInstant before = wand.at(t), after = wand.at(t + step_s);
    // at most 1.8 m and half a turn in half a second, 1.875 times as fast in the middle of the way
    EXPECT_LT((after.ball_in_world_m - before.ball_in_world_m).norm(), 2.3 / 0.5 * 1.9 * step_s);
    for (std::size_t j = 0; j < kJointCount; ++j)
      EXPECT_LT((after.person.joint_in_world_m[j] - before.person.joint_in_world_m[j]).norm(), 0.05);
  }
  EXPECT_EQ(wand.at(-1.0).ball_in_world_m, wand.holds().front().ball_in_world_m);
  EXPECT_EQ(wand.at(1e6).ball_in_world_m, wand.holds().back().ball_in_world_m);
}

TEST(WandMotion, ThePersonStandsBesideTheBallFacesItAndHoldsTheStick) {
  const WandMotion wand({}, 5, kCentre, Person{});
  for (const WandHold& hold : wand.holds()) {
    const WandInstant instant = wand.at(0.5 * (hold.from_s + hold.to_s));
    const SkeletonPose& person = instant.person;
    const Vector3d base = person.at(Joint::spine_base);
    EXPECT_NEAR(horizontal_m(base, instant.ball_in_world_m), 1.2, 0.03);
    const double across_m = horizontal_m(instant.ball_in_world_m, kCentre);
    EXPECT_NEAR(horizontal_m(base, kCentre), std::hypot(1.2, across_m), 0.03);
    const Vector3d to_ball = (instant.ball_in_world_m - base).cwiseProduct(Vector3d(1.0, 0.0, 1.0));
    const Vector3d facing(std::sin(person.heading_rad), 0.0, std::cos(person.heading_rad));
    EXPECT_GT(facing.dot(to_ball.normalized()), 0.999);
    EXPECT_GT((person.at(Joint::shoulder_left) - person.at(Joint::shoulder_right))
                  .dot(Vector3d(std::cos(person.heading_rad), 0.0, -std::sin(person.heading_rad))),
              0.3);
    const Vector3d hand = person.at(Joint::hand_right) - instant.ball_in_world_m;
    EXPECT_NEAR(instant.stick_direction.norm(), 1.0, 1e-12);
    EXPECT_LT(hand.cross(instant.stick_direction).norm(), 1e-9);
    EXPECT_GT(hand.dot(instant.stick_direction), 0.6);
    EXPECT_LT(hand.dot(instant.stick_direction), 1.15);
  }
}

// The elbow hangs 8 cm below the line to the hand; the thumb is up.
TEST(WandMotion, TheArmThatHoldsTheStickIsAPersons) {
  const WandMotion wand({}, 5, kCentre, Person{});
  for (const WandHold& hold : wand.holds()) {
    const SkeletonPose person = wand.at(0.5 * (hold.from_s + hold.to_s)).person;
    const Vector3d hand = person.at(Joint::hand_right);
    EXPECT_LT((person.at(Joint::thumb_right) - hand - Vector3d(0.0, 0.04, 0.0)).norm(), 1e-9);
    EXPECT_NEAR((person.at(Joint::wrist_right) - hand).norm(), 0.08, 1e-9);
    EXPECT_NEAR((person.at(Joint::hand_tip_right) - hand).norm(), 0.06, 1e-9);
    const Vector3d middle = 0.5 * (person.at(Joint::shoulder_right) + hand);
    EXPECT_LT((person.at(Joint::elbow_right) - middle + Vector3d(0.0, 0.08, 0.0)).norm(), 1e-9);
  }
}

TEST(WandMotion, AScenePutsDownWhatNobodyHolds) {
  const WandMotion wand({}, 5, kCentre, Person{});
  const auto scene_of = [&](bool is_held, bool shows_person) {
    WandInstant instant = wand.at(0.1);
    instant.is_held = is_held;
    DepthScene scene;
    append_wand_instant(scene, instant, {}, shows_person);
    return scene;
  };
  const auto parts = [](const DepthScene& scene) { return scene.spheres.size() + scene.capsules.size(); };
  EXPECT_EQ(parts(scene_of(false, true)), 1u);  // the ball alone
  EXPECT_EQ(parts(scene_of(false, false)), 1u);
  EXPECT_GT(parts(scene_of(true, false)), 1u);
  EXPECT_GT(parts(scene_of(true, true)), parts(scene_of(true, false)) + 10u);
}

TEST(WandMotion, OtherSeedsGiveOtherPositions) {
  const WandMotion one({}, 1, kCentre, Person{}), again({}, 1, kCentre, Person{}),
      two({}, 2, kCentre, Person{});
  EXPECT_EQ(one.holds()[7].ball_in_world_m, again.holds()[7].ball_in_world_m);
  EXPECT_NE(one.holds()[7].ball_in_world_m, two.holds()[7].ball_in_world_m);
}

}  // namespace
}  // namespace trilat
