// SPDX-License-Identifier: MIT
// The paper's calibration from two wand positions by pencil.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "datasets/base/units.h"
#include "evaluators/calibration/wand_positions.h"

namespace trilat {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMovement_m = 0.7;

TwoPositionOptions all_corrected() {
  return {.trajectory_axis = TrajectoryAxis::z, .signed_angle = true, .translation = true};
}

// A sensor turned about the vertical, then nodding and leaning by as much as asked.
RigidTransform wand_from_sensor(double turn_deg, double nod_deg, double lean_deg) {
  const Eigen::Quaterniond rotation = AngleAxisd(turn_deg * kRadPerDegree, Vector3d::UnitY()) *
                                      AngleAxisd(nod_deg * kRadPerDegree, Vector3d::UnitX()) *
                                      AngleAxisd(lean_deg * kRadPerDegree, Vector3d::UnitZ());
  return {rotation, {0.4, -0.3, -1.9}};
}

TwoPositionPose solve_for(const RigidTransform& truth, const TwoPositionOptions& options) {
  return solve_two_positions(truth.inverse() * Vector3d::Zero(),
                             truth.inverse() * Vector3d(kMovement_m, 0.0, 0.0), kMovement_m, options);
}

void expect_pose(const TwoPositionPose& got, const RigidTransform& truth) {
  ASSERT_EQ(got.status, TwoPositionStatus::solved);
  EXPECT_LT((got.wand_from_sensor.rotation.toRotationMatrix() - truth.rotation.toRotationMatrix()).norm(),
            1e-12);
  EXPECT_LT((got.wand_from_sensor.translation_m - truth.translation_m).norm(), 1e-12);
}

TEST(TwoPositions, CorrectedTheyRecoverALevelSensorWhereverItLooks) {
  for (int turn_deg = -180; turn_deg < 180; turn_deg += 15) {
    const RigidTransform truth = wand_from_sensor(turn_deg, 0.0, 0.0);
    expect_pose(solve_for(truth, all_corrected()), truth);
  }
}

TEST(TwoPositions, CorrectedTheyRecoverATiltedSensorThatKnowsWhereUpIs) {
  for (int turn_deg = -180; turn_deg < 180; turn_deg += 40) {
    const RigidTransform truth = wand_from_sensor(turn_deg, 25.0, -10.0);
    TwoPositionOptions options = all_corrected();
    options.up_in_sensor = truth.rotation.conjugate() * Vector3d::UnitY();
    expect_pose(solve_for(truth, options), truth);
    options.up_in_sensor *= 3.0;  // only its direction counts
    expect_pose(solve_for(truth, options), truth);
  }
}

TEST(TwoPositions, TakenToStandUprightATiltedSensorKeepsItsTilt) {
  const RigidTransform truth = wand_from_sensor(0.0, 20.0, 0.0);
  const TwoPositionPose got = solve_for(truth, all_corrected());
  ASSERT_EQ(got.status, TwoPositionStatus::solved);
  EXPECT_LT((got.wand_from_sensor.rotation * Vector3d::UnitY() - Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_NEAR(got.wand_from_sensor.rotation.angularDistance(truth.rotation), 20.0 * kRadPerDegree, 1e-9);
}

// A movement 30 degrees to one side of straight away from the lens; the sensor's x axis is to its left.
TEST(TwoPositions, TheArcCosineTakesAMovementToTheLeftForOneToTheRight) {
  const double angle_rad = 30.0 * kRadPerDegree;
  const Vector3d first(0.0, 0.0, 2.0);
  const Vector3d left = first + kMovement_m * Vector3d(std::sin(angle_rad), 0.0, std::cos(angle_rad));
  const Vector3d right = first + kMovement_m * Vector3d(-std::sin(angle_rad), 0.0, std::cos(angle_rad));
  TwoPositionOptions printed_angle = all_corrected();
  printed_angle.signed_angle = false;
  const auto rotation = [&](const Vector3d& second, const TwoPositionOptions& options) {
    const TwoPositionPose pose = solve_two_positions(first, second, kMovement_m, options);
    EXPECT_EQ(pose.status, TwoPositionStatus::solved);
    return pose.wand_from_sensor.rotation;
  };
  EXPECT_LT(rotation(right, printed_angle).angularDistance(rotation(right, all_corrected())), 1e-7);
  EXPECT_NEAR(rotation(left, printed_angle).angularDistance(rotation(left, all_corrected())), 2.0 * angle_rad,
              1e-9);
  EXPECT_LT(rotation(left, printed_angle).angularDistance(rotation(right, printed_angle)), 1e-7);
}

// With the sign both horizontal axes give the same pose; without it x takes a movement towards the sensor for
// one away from it, as z takes left for right.
TEST(TwoPositions, TheTrajectoryCanBeComparedWithEitherHorizontalAxis) {
  TwoPositionOptions along_x = all_corrected();
  along_x.trajectory_axis = TrajectoryAxis::x;
  for (int turn_deg = -180; turn_deg < 180; turn_deg += 15) {
    const RigidTransform truth = wand_from_sensor(turn_deg, 25.0, -10.0);
    along_x.up_in_sensor = truth.rotation.conjugate() * Vector3d::UnitY();
    expect_pose(solve_for(truth, along_x), truth);
  }
  along_x = all_corrected();
  along_x.trajectory_axis = TrajectoryAxis::x;
  TwoPositionOptions printed_angle = along_x;
  printed_angle.signed_angle = false;
  const double angle_rad = 30.0 * kRadPerDegree;  // from the sensor's right, -x in its own frame
  const Vector3d first(0.0, 0.0, 2.0);
  for (const double side : {1.0, -1.0}) {
    const Vector3d second =
        first + kMovement_m * Vector3d(-std::cos(angle_rad), 0.0, side * std::sin(angle_rad));
    const auto rotation = [&](const TwoPositionOptions& options) {
      return solve_two_positions(first, second, kMovement_m, options).wand_from_sensor.rotation;
    };
    EXPECT_NEAR(rotation(printed_angle).angularDistance(rotation(along_x)),
                side > 0.0 ? 2.0 * angle_rad : 0.0, 1e-7);
  }
}

TEST(TwoPositions, ACosineBeyondOneHasItsStatusAndTheSignedAngleHasNone) {
  const Vector3d first(0.0, 0.0, 2.0), second(0.0, 0.0, 2.0 + kMovement_m + 0.001);  // 1 mm of noise
  TwoPositionOptions options = all_corrected();
  EXPECT_EQ(solve_two_positions(first, second, kMovement_m, options).status, TwoPositionStatus::solved);
  options.signed_angle = false;
  EXPECT_EQ(solve_two_positions(first, second, kMovement_m, options).status,
            TwoPositionStatus::cosine_beyond_one);
  EXPECT_EQ(solve_two_positions(second, first, kMovement_m, options).status,
            TwoPositionStatus::cosine_beyond_one);
  EXPECT_EQ(name_of(TwoPositionStatus::cosine_beyond_one), "cosine_beyond_one");
}

TEST(TwoPositions, WithoutATranslationTheOriginStaysAtTheSensor) {
  const RigidTransform truth = wand_from_sensor(50.0, 0.0, 0.0);
  TwoPositionOptions options = all_corrected();
  options.translation = false;
  expect_pose(solve_for(truth, options), {truth.rotation, Vector3d::Zero()});
}

TEST(TwoPositions, NoMovementAndAVerticalOneDetermineNoTurn) {
  const Vector3d first(0.1, 0.2, 2.0);
  const auto status = [&](const Vector3d& moved, double baseline_m) {
    return solve_two_positions(first, first + moved, baseline_m, all_corrected()).status;
  };
  EXPECT_EQ(status({0.0, 0.0, 0.0}, kMovement_m), TwoPositionStatus::no_movement);
  EXPECT_EQ(status({0.0, 0.7, 0.0}, kMovement_m), TwoPositionStatus::no_movement);
  EXPECT_EQ(status({0.0005, 0.7, 0.0}, kMovement_m), TwoPositionStatus::no_movement);
  EXPECT_EQ(status({0.7, 0.0, 0.0}, 0.0), TwoPositionStatus::no_movement);
  EXPECT_EQ(status({0.7, 0.0, 0.0}, std::nan("")), TwoPositionStatus::no_movement);
  EXPECT_EQ(status({0.7, 0.7, 0.0}, kMovement_m), TwoPositionStatus::solved);
}

// As printed x is right, y is down and z is depth, and the turn is about z: a movement to the right is a
// quarter of a turn from y, and depth becomes the wand's height.
TEST(TwoPositions, AsPrintedTheDepthAxisBecomesTheVertical) {
  const TwoPositionPose pose = solve_two_positions({0, 0, 2}, {-kMovement_m, 0, 2}, kMovement_m, {});
  ASSERT_EQ(pose.status, TwoPositionStatus::solved);
  Matrix3d expected;
  expected << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  EXPECT_LT((pose.wand_from_sensor.rotation.toRotationMatrix() - expected).norm(), 1e-12);
  EXPECT_EQ(pose.wand_from_sensor.translation_m, Vector3d::Zero());
  EXPECT_EQ(solve_two_positions({0, 0, 2}, {0, 0, 2.7}, kMovement_m, {}).status,
            TwoPositionStatus::no_movement);
}

// The turn is about the depth axis, so that one must come out as the vertical; a reflection that a quaternion
// cannot hold would turn it elsewhere.
TEST(TwoPositions, ThePrintedRotationIsAlwaysAProperOne) {
  const RandomStream random{3, Purpose::test, 1};
  int solved = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const auto draw = [&](std::uint32_t k) { return random.uniform(6 * i + k, -1.0, 1.0); };
    const Vector3d first(draw(0), draw(1), 2.0 + draw(2)), second(draw(3), draw(4), 2.0 + draw(5));
    const TwoPositionPose pose = solve_two_positions(first, second, (second - first).norm(), {});
    ASSERT_EQ(pose.status, TwoPositionStatus::solved);
    const Matrix3d rotation = pose.wand_from_sensor.rotation.toRotationMatrix();
    EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
    EXPECT_LT((rotation * Vector3d::UnitZ() - Vector3d::UnitY()).norm(), 1e-12);
    ++solved;
  }
  EXPECT_EQ(solved, 200);
}

}  // namespace
}  // namespace trilat
