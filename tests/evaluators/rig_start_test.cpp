// SPDX-License-Identifier: MIT
#include "evaluators/calibration/rig_start.h"

#include <functional>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using testing::ElementsAre;
using enum SensorPlacement;

const std::vector<RigidTransform> kRig{world_from_sensor_looking_at({2.0, 0.6, 0.0}, {0.0, 1.0, 0.0}),
                                       world_from_sensor_looking_at({0.0, 2.2, 2.0}, {0.0, 1.0, 0.0}),
                                       world_from_sensor_looking_at({-2.0, 0.9, 0.3}, {0.0, 1.0, 0.0})};

std::vector<Vector3d> points_in_a_room(std::size_t count) {
  const RandomStream random{11, Purpose::test, 4};
  std::vector<Vector3d> points;
  for (std::uint32_t i = 0; i < count; ++i)
    points.emplace_back(random.uniform(3 * i, -0.8, 0.8), random.uniform(3 * i + 1, 0.4, 1.7),
                        random.uniform(3 * i + 2, -0.8, 0.8));
  return points;
}

// What each of so many sensors of the rig measures of the points it sees, without noise.
RigProblem seen_by(std::size_t sensors, const std::vector<Vector3d>& points,
                   const std::function<bool(std::size_t sensor, std::size_t point)>& sees) {
  RigProblem problem{sensors, points.size(), {}};
  for (std::size_t s = 0; s < sensors; ++s)
    for (std::size_t p = 0; p < points.size(); ++p)
      if (sees(s, p)) problem.observations.push_back({s, p, kRig[s].inverse() * points[p]});
  return problem;
}

bool always(std::size_t, std::size_t) { return true; }

void expect_exact(const RigStart& start, std::size_t sensor) {
  const RigidTransform truth = kRig[start.reference].inverse() * kRig[sensor];
  const RigidTransform& got = start.reference_from_sensor[sensor];
  EXPECT_LT((got.translation_m - truth.translation_m).norm(), 1e-9) << sensor;
  EXPECT_LT((got.rotation.toRotationMatrix() - truth.rotation.toRotationMatrix()).norm(), 1e-9) << sensor;
}

TEST(RigStart, ExactPointsGiveExactPoses) {
  const RigStart start = initial_poses(seen_by(3, points_in_a_room(10), always), {});
  EXPECT_TRUE(start.complete());
  for (std::size_t s = 0; s < 3; ++s) expect_exact(start, s);
  EXPECT_EQ(start.reference_from_sensor[start.reference].translation_m, Vector3d::Zero());
}

TEST(RigStart, TheOrderOfTheObservationsDoesNotMatter) {
  RigProblem problem = seen_by(3, points_in_a_room(10), always);
  const RigStart start = initial_poses(problem, {});
  std::ranges::reverse(problem.observations);
  const RigStart again = initial_poses(problem, {});
  for (std::size_t s = 0; s < 3; ++s)
    EXPECT_EQ(again.reference_from_sensor[s].translation_m, start.reference_from_sensor[s].translation_m);
}

TEST(RigStart, CommonPointsOnALineAreSaidOfTheSensorThatHasThem) {
  std::vector<Vector3d> points = points_in_a_room(8);
  for (int i = 0; i < 6; ++i) points.emplace_back(0.1 * i, 1.0 + 0.05 * i, 0.0);
  const RigStart start =
      initial_poses(seen_by(3, points, [](std::size_t s, std::size_t p) { return s < 2 || p >= 8; }), {});
  EXPECT_THAT(start.placement, ElementsAre(placed, placed, points_on_line));
  EXPECT_FALSE(start.complete());
  expect_exact(start, 1);
}

TEST(RigStart, PointsOfAThinLineAreOnALine) {
  std::vector<Vector3d> points = points_in_a_room(8);
  for (int i = 0; i < 6; ++i) points.emplace_back(0.1 * i, 1.0 + 0.05 * i, 1e-4 * (i % 3));
  const RigStart start =
      initial_poses(seen_by(3, points, [](std::size_t s, std::size_t p) { return s < 2 || p >= 8; }), {});
  EXPECT_THAT(start.placement, ElementsAre(placed, placed, points_on_line));
}

TEST(RigStart, TwoCommonPointsAreNoCommonView) {
  const RigStart start = initial_poses(
      seen_by(3, points_in_a_room(10), [](std::size_t s, std::size_t p) { return s < 2 || p < 2; }), {});
  EXPECT_THAT(start.placement, ElementsAre(placed, placed, no_common_view));
}

TEST(RigStart, ASensorWithoutAnObservationHasSeenNothing) {
  const RigStart start =
      initial_poses(seen_by(3, points_in_a_room(10), [](std::size_t s, std::size_t) { return s != 1; }), {});
  EXPECT_THAT(start.placement, ElementsAre(placed, nothing_seen, placed));
  EXPECT_THAT(initial_poses(RigProblem{2, 5, {}}, {}).placement, ElementsAre(nothing_seen, nothing_seen));
  EXPECT_TRUE(initial_poses(RigProblem{}, {}).placement.empty());
}

// The first sensor sees more than any other and shares nothing with the third.
TEST(RigStart, PosesAreChainedThroughASensorInBetween) {
  const RigStart start =
      initial_poses(seen_by(3, points_in_a_room(32),
                            [](std::size_t s, std::size_t p) {
                              return s == 0 ? p < 8 || p >= 16 : s == 1 ? p < 16 : p >= 8 && p < 16;
                            }),
                    {});
  EXPECT_EQ(start.reference, 0u);
  EXPECT_TRUE(start.complete());
  for (std::size_t s = 0; s < 3; ++s) expect_exact(start, s);
}

TEST(RigStart, ThirtyPercentOfWrongPointsDoNotMatter) {
  const std::size_t points = 20;
  RigProblem problem = seen_by(2, points_in_a_room(points), always);
  const RandomStream random{5, Purpose::test, 9};
  for (std::uint32_t i = 0; i < 6; ++i)
    problem.observations[points + 3 * i].point_in_sensor_m +=
        0.5 * Vector3d(random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)).normalized();
  const RigStart start = initial_poses(problem, {});
  EXPECT_TRUE(start.complete());
  expect_exact(start, 0);
  expect_exact(start, 1);
}

// The corners of a cube of 1 m, which one sensor measures half as far again as they are.
TEST(RigStart, PointsOfAnotherScaleDisagree) {
  std::vector<Vector3d> corners;
  for (int c = 0; c < 8; ++c) corners.emplace_back(c & 1 ? 0.5 : -0.5, c & 2 ? 1.5 : 0.5, c & 4 ? 0.5 : -0.5);
  RigProblem problem = seen_by(2, corners, always);
  for (PointObservation& o : problem.observations)
    if (o.sensor == 1) o.point_in_sensor_m *= 1.5;
  const RigStart start = initial_poses(problem, {});
  EXPECT_THAT(start.placement, ElementsAre(placed, disagrees));
}

}  // namespace
}  // namespace trilat
