// SPDX-License-Identifier: MIT
#include "evaluators/bodies/occlusion.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::Each;
using enum OcclusionVariant;

void put(ObservedBody& body, Joint joint, const Vector3d& point_m) {
  const auto i = static_cast<std::size_t>(joint);
  body.joint_in_sensor_m[i] = point_m.cast<float>();
  body.state[i] = TrackingState::tracked;
}

int at(const std::array<int, kJointCount>& counts, Joint joint) {
  return counts[static_cast<std::size_t>(joint)];
}

// Two bones that share no joint: the left forearm and the right thigh.
ObservedBody two_bones(const Vector3d& elbow_m, const Vector3d& wrist_m, const Vector3d& hip_m,
                       const Vector3d& knee_m) {
  ObservedBody body;
  put(body, Joint::elbow_left, elbow_m);
  put(body, Joint::wrist_left, wrist_m);
  put(body, Joint::hip_right, hip_m);
  put(body, Joint::knee_right, knee_m);
  return body;
}

// The forearm level at 2 m, the thigh upright at `depth_m`, both through the middle of the image.
ObservedBody cross_at(double depth_m) {
  return two_bones({-0.2, 0.0, 2.0}, {0.2, 0.0, 2.0}, {0.0, 0.3, depth_m}, {0.0, -0.3, depth_m});
}

TEST(Occlusion, TheFartherOfTwoBonesThatCrossIsOccludedAtBothItsEnds) {
  for (const OcclusionVariant variant : {printed, corrected}) {
    const auto thigh_behind = count_occlusions(cross_at(2.2), variant);
    EXPECT_EQ(at(thigh_behind, Joint::hip_right), 1);
    EXPECT_EQ(at(thigh_behind, Joint::knee_right), 1);
    EXPECT_EQ(at(thigh_behind, Joint::elbow_left), 0);
    EXPECT_EQ(at(thigh_behind, Joint::wrist_left), 0);
    const auto forearm_behind = count_occlusions(cross_at(1.8), variant);
    EXPECT_EQ(at(forearm_behind, Joint::hip_right), 0);
    EXPECT_EQ(at(forearm_behind, Joint::wrist_left), 1);
    EXPECT_THAT(count_occlusions(cross_at(2.0), variant), Each(0));
  }
}

TEST(Occlusion, ABoneWithoutBothEndsIsLeftOut) {
  ObservedBody body = cross_at(2.2);
  body.state[static_cast<std::size_t>(Joint::wrist_left)] = TrackingState::not_tracked;
  EXPECT_THAT(count_occlusions(body, printed), Each(0));
  EXPECT_THAT(count_occlusions(body, corrected), Each(0));
  EXPECT_THAT(count_occlusions(ObservedBody{}, corrected), Each(0));
}

TEST(Occlusion, BonesThatOnlyTouchDoNotCross) {
  const ObservedBody body = two_bones({-0.2, 0.0, 2.0}, {0.2, 0.0, 2.0}, {0.0, 0.0, 2.2}, {0.0, -0.3, 2.2});
  EXPECT_THAT(count_occlusions(body, printed), Each(0));
  EXPECT_THAT(count_occlusions(body, corrected), Each(0));
}

TEST(Occlusion, BonesOnOneLineDoNotCross) {
  const ObservedBody body = two_bones({0.0, 0.4, 2.0}, {0.0, 0.0, 2.0}, {0.0, 0.2, 2.2}, {0.0, -0.3, 2.2});
  EXPECT_THAT(count_occlusions(body, printed), Each(0));
  EXPECT_THAT(count_occlusions(body, corrected), Each(0));
}

TEST(Occlusion, AJointThatEndsSeveralOccludedBonesCountsThemAll) {
  ObservedBody body = cross_at(2.2);
  put(body, Joint::ankle_right, {0.1, 0.3, 2.2});  // the shank goes back up behind the forearm
  for (const OcclusionVariant variant : {printed, corrected}) {
    const auto counts = count_occlusions(body, variant);
    EXPECT_EQ(at(counts, Joint::hip_right), 1);
    EXPECT_EQ(at(counts, Joint::knee_right), 2);
    EXPECT_EQ(at(counts, Joint::ankle_right), 1);
  }
}

TEST(Occlusion, BonesThatShareAJointNeverCount) {
  ObservedBody body;
  put(body, Joint::elbow_left, {0.0, 0.0, 2.0});
  put(body, Joint::wrist_left, {0.1, 0.0, 2.0});
  put(body, Joint::hand_left, {0.0, 0.0, 2.3});
  EXPECT_THAT(count_occlusions(body, printed), Each(0));
  EXPECT_THAT(count_occlusions(body, corrected), Each(0));
}

// x = 0.5 at 2 m and x = 0.75 at 3 m are one place in the image.
TEST(Occlusion, PrintedSeesACrossingThatTheImageDoesNotShowAndMissesOneThatItDoes) {
  const ObservedBody in_metres =
      two_bones({0.4, 0.0, 2.0}, {0.6, 0.0, 2.0}, {0.5, 0.3, 3.0}, {0.5, -0.3, 3.0});
  EXPECT_EQ(at(count_occlusions(in_metres, printed), Joint::knee_right), 1);
  EXPECT_THAT(count_occlusions(in_metres, corrected), Each(0));
  const ObservedBody in_image =
      two_bones({0.4, 0.0, 2.0}, {0.6, 0.0, 2.0}, {0.75, 0.3, 3.0}, {0.75, -0.3, 3.0});
  EXPECT_THAT(count_occlusions(in_image, printed), Each(0));
  EXPECT_EQ(at(count_occlusions(in_image, corrected), Joint::knee_right), 1);
}

// A forearm from 1 m to 3 m: half-way in the image it is 1.5 m away, half-way in metres 2 m.
TEST(Occlusion, TheDepthOfACrossingIsTakenOnTheViewingRay) {
  const ObservedBody body = two_bones({-0.1, 0.0, 1.0}, {0.3, 0.0, 3.0}, {0.0, 0.3, 1.6}, {0.0, -0.3, 1.6});
  const auto counts = count_occlusions(body, corrected);
  EXPECT_EQ(at(counts, Joint::knee_right), 1);
  EXPECT_EQ(at(counts, Joint::wrist_left), 0);
}

TEST(Occlusion, AJointBehindTheLensIsNotThere) {
  EXPECT_THAT(count_occlusions(cross_at(-2.2), corrected), Each(0));
  EXPECT_EQ(at(count_occlusions(cross_at(-2.2), printed), Joint::wrist_left), 1);
}

// -1, 0 or 1: the first bone is behind, no crossing, the second is behind; by looking at many points of both
// bones for the two that are nearest in the image. Nothing when that is too close to call.
std::optional<int> by_sampling(const std::array<Vector3d, 4>& point_m) {
  constexpr int kSteps = 300;
  const auto on = [](const Vector3d& a, const Vector3d& b, int i) -> Vector3d {
    return a + (static_cast<double>(i) / kSteps) * (b - a);
  };
  std::array<Vector2d, kSteps + 1> second;
  for (int j = 0; j <= kSteps; ++j) second[j] = on(point_m[2], point_m[3], j).hnormalized();
  double nearest = 1e9;
  int best_i = 0, best_j = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const Vector2d first = on(point_m[0], point_m[1], i).hnormalized();
    for (int j = 0; j <= kSteps; ++j) {
      if (const double distance = (first - second[j]).squaredNorm(); distance < nearest) {
        nearest = distance;
        best_i = i;
        best_j = j;
      }
    }
  }
  const double grain = ((point_m[1].hnormalized() - point_m[0].hnormalized()).norm() +
                        (point_m[3].hnormalized() - point_m[2].hnormalized()).norm()) /
                       kSteps * 2.0;
  if (std::sqrt(nearest) > grain) return 0;
  const bool at_an_end = best_i < 3 || best_j < 3 || best_i > kSteps - 3 || best_j > kSteps - 3;
  const Vector3d first = on(point_m[0], point_m[1], best_i), other = on(point_m[2], point_m[3], best_j);
  if (at_an_end || std::abs(first.z() - other.z()) < 0.03) return std::nullopt;
  return first.z() > other.z() ? -1 : 1;
}

TEST(Occlusion, CorrectedAgreesWithDenseSamplingOfTheImage) {
  int crossings = 0, decided = 0;
  for (std::uint64_t trial = 0; trial < 4000; ++trial) {
    const RandomStream random{7, Purpose::test, trial};
    std::array<Vector3d, 4> point_m;
    for (std::uint32_t k = 0; k < 4; ++k)
      point_m[k] = {random.uniform(3 * k, -0.4, 0.4), random.uniform(3 * k + 1, -0.4, 0.4),
                    random.uniform(3 * k + 2, 1.0, 3.0)};
    const auto expected = by_sampling(point_m);
    if (!expected) continue;
    ++decided;
    crossings += *expected != 0;
    const auto counts =
        count_occlusions(two_bones(point_m[0], point_m[1], point_m[2], point_m[3]), corrected);
    ASSERT_EQ(at(counts, Joint::elbow_left), *expected == -1) << "trial " << trial;
    ASSERT_EQ(at(counts, Joint::knee_right), *expected == 1) << "trial " << trial;
  }
  EXPECT_GT(decided, 3500);
  EXPECT_GT(crossings, 500);
}

SensorMask mask(unsigned long bits) { return SensorMask(bits); }

TEST(SelectUnoccluded, OnlySensorsWithoutOcclusionWhenThereIsOne) {
  EXPECT_EQ(select_unoccluded(std::array{1, 0, 2, 0}, kAllSensors), mask(0b1010));
  EXPECT_EQ(select_unoccluded(std::array{1, 0, 2, 0}, mask(0b0111)), mask(0b0010));
}

TEST(SelectUnoccluded, ElseAllWithTheFewestCrossings) {
  EXPECT_EQ(select_unoccluded(std::array{2, 1, 3, 1}, kAllSensors), mask(0b1010));
  EXPECT_EQ(select_unoccluded(std::array{2, 0, 3, 2}, mask(0b1101)), mask(0b1001));
}

TEST(SelectUnoccluded, NobodySeesNobodyIsSelected) {
  EXPECT_TRUE(select_unoccluded(std::array{0, 0}, {}).none());
  EXPECT_TRUE(select_unoccluded({}, kAllSensors).none());
}

TEST(SelectUnoccluded, TheNextFewestJoinWithAllTheirEqualsUntilThereAreEnough) {
  const std::array occlusions{0, 2, 1, 2, 5};
  EXPECT_EQ(select_unoccluded(occlusions, kAllSensors, 1), mask(0b00001));
  EXPECT_EQ(select_unoccluded(occlusions, kAllSensors, 2), mask(0b00101));
  EXPECT_EQ(select_unoccluded(occlusions, kAllSensors, 3), mask(0b01111));
  EXPECT_EQ(select_unoccluded(occlusions, kAllSensors, 9), mask(0b11111));
}

}  // namespace
}  // namespace trilat
