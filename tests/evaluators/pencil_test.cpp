// SPDX-License-Identifier: MIT
// Solvers and baselines against values that one can compute by hand.
#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "evaluators/fusion/baselines.h"
#include "evaluators/fusion/joint_observation.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/sensor_plane.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

TEST(SolveStatus, NamesAreUniqueAndOnlyAnswersAreUsable) {
  std::vector<std::string_view> names;
  int usable = 0;
  for (int i = 0; i < kSolveStatusCount; ++i) {
    const auto status = static_cast<SolveStatus>(i);
    EXPECT_THAT(names, testing::Not(testing::Contains(name_of(status))));
    names.push_back(name_of(status));
    usable += is_usable(status) ? 1 : 0;
  }
  EXPECT_EQ(usable, 4);
  EXPECT_FALSE(is_usable(SolveStatus::iteration_limit));
  EXPECT_FALSE(is_usable(SolveStatus::mirror_ambiguous));
  EXPECT_FALSE(is_usable(PointEstimate{}.status));
}

// Sensors at the origin and one metre along each axis. Ranges 1, 1, 1, 1 + e from the origin's point of view:
// 2 x_k = 1 + r_0^2 - r_k^2.
TEST(Linear, GivesTheHandSolutionOfACornerOfACube) {
  RangeProblem problem = problem_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0.25, 0.5, 0.75});
  PointEstimate estimate = solve_linear(problem, {});
  EXPECT_EQ(estimate.status, SolveStatus::closed_form);
  EXPECT_LT((estimate.position_m - Vector3d(0.25, 0.5, 0.75)).norm(), 1e-15);
  problem.range_m = {1, 1, 1, 2, 0, 0, 0, 0};
  estimate = solve_linear(problem, {});
  EXPECT_LT((estimate.position_m - Vector3d(0.5, 0.5, -1.0)).norm(), 1e-15);
  EXPECT_NEAR(estimate.cost_m2,
              std::pow(std::sqrt(1.5) - 1.0, 2) + 2.0 * std::pow(std::sqrt(1.5) - 1.0, 2) +
                  std::pow(std::sqrt(4.5) - 2.0, 2),
              1e-14);
}

TEST(Linear, TheReferenceMattersWhenRangesDisagree) {
  RangeProblem problem =
      problem_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {0.25, 0.5, 0.75});
  problem.range_m[2] += 0.05;
  LinearOptions by_first;
  LinearOptions by_third;
  by_third.reference_sensor = 2;
  const LinearOptions by_pairs{LinearReference::all_pairs, 0, 1e-6};
  const Vector3d first_m = solve_linear(problem, by_first).position_m;
  const Vector3d third_m = solve_linear(problem, by_third).position_m;
  EXPECT_GT((first_m - third_m).norm(), 1e-3);
  EXPECT_GT((solve_linear(problem, by_pairs).position_m - third_m).norm(), 1e-3);
}

TEST(Linear, TheReferenceIsANumberOfTheRigAndTheNextOneStandsIn) {
  RangeProblem problem =
      problem_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {0.25, 0.5, 0.75});
  problem.range_m[2] += 0.05;
  problem.rig_index = {6, 2, 4, 0, 1, 0, 0, 0};
  const auto by = [&](int sensor) {
    return solve_linear(problem, {LinearReference::one_sensor, sensor, 1e-6}).position_m;
  };
  EXPECT_EQ(by(3), by(4));
  EXPECT_EQ(by(5), by(6));
  EXPECT_EQ(by(7), by(0));
  EXPECT_NE(by(4), by(6));
}

// All pairs of spheres, written out, solved by plain normal equations.
TEST(Linear, AllPairsIsTheLeastSquaresOfEveryDifference) {
  RangeProblem problem =
      problem_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {0.25, 0.5, 0.75});
  add_noise(problem, RandomStream{1, Purpose::test, 0}, 0.05);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (int i = 0; i < 5; ++i) {
    for (int j = i + 1; j < 5; ++j) {
      const Vector3d row = 2.0 * (problem.sensor_m[i] - problem.sensor_m[j]);
      normal += row * row.transpose();
      right += row * (problem.range_m[j] * problem.range_m[j] - problem.range_m[i] * problem.range_m[i] +
                      problem.sensor_m[i].squaredNorm() - problem.sensor_m[j].squaredNorm());
    }
  }
  const Vector3d expected_m = normal.inverse() * right;
  EXPECT_LT((solve_linear(problem, {LinearReference::all_pairs, 0, 1e-6}).position_m - expected_m).norm(),
            1e-12);
}

// Spheres around (0,0,0), (2,0,0), (0,2,0) with squared ranges 3 meet at (1, 1, +-1).
TEST(Geometric, GivesBothHandSolutionsAndTheHintChooses) {
  RangeProblem problem = problem_of({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {1, 1, 1});
  problem.guess_m = Vector3d(1, 1, 0.9);
  PointEstimate estimate = solve_geometric(problem, {});
  EXPECT_EQ(estimate.status, SolveStatus::closed_form);
  EXPECT_LT((estimate.position_m - Vector3d(1, 1, 1)).norm(), 1e-14);
  problem.guess_m = Vector3d(1, 1, -2);
  estimate = solve_geometric(problem, {});
  EXPECT_LT((estimate.position_m - Vector3d(1, 1, -1)).norm(), 1e-14);
  problem.guess_m = Vector3d(1, 1, 0.3);  // 0.7 and 1.3: not twice as far
  EXPECT_EQ(solve_geometric(problem, {}).status, SolveStatus::mirror_ambiguous);
}

TEST(Geometric, SpheresThatDoNotMeetAreClampedToThePlane) {
  RangeProblem problem = problem_of({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {1, 1, 1});
  problem.range_m = {1, 1, 1, 0, 0, 0, 0, 0};
  const PointEstimate estimate = solve_geometric(problem, {});
  EXPECT_EQ(estimate.status, SolveStatus::clamped);
  EXPECT_LT((estimate.position_m - Vector3d(1, 1, 0)).norm(), 1e-15);
  EXPECT_NEAR(estimate.cost_m2, 3.0 * std::pow(std::sqrt(2.0) - 1.0, 2), 1e-15);
  EXPECT_TRUE(std::isinf(estimate.gdop));
}

TEST(Geometric, UsesTheSensorsOfTheRigThatItIsTold) {
  const Vector3d joint_m(0.1, 0.8, -0.2);
  RangeProblem problem = problem_of(well_posed_sensors_m(), joint_m);
  problem.guess_m = joint_m;
  problem.range_m[1] += 0.5;  // must not be read
  const PointEstimate estimate = solve_geometric(problem, {{3, 0, 2}});
  EXPECT_LT((estimate.position_m - joint_m).norm(), 1e-12);
  problem.rig_index = {0, 1, 2, 5, 0, 0, 0, 0};
  EXPECT_EQ(solve_geometric(problem, {{3, 0, 2}}).status, SolveStatus::too_few_ranges);
  EXPECT_EQ(solve_geometric(problem, {{0, 0, 0}}).status, SolveStatus::rank_deficient);
}

TEST(SensorPlane, IsTheBestFitAndMirrorsThroughIt) {
  const SensorPlane plane = plane_of(problem_of(ring_m(0.9, 0.9, 0.9, 0.9), {0, 2, 0}));
  EXPECT_TRUE(plane.exact);
  EXPECT_LT((plane.mirrored({0.3, 1.5, 0.2}) - Vector3d(0.3, 0.3, 0.2)).norm(), 1e-14);
  const SensorPlane wavy = plane_of(problem_of(ring_m(0.8, 1.0, 0.8, 1.0), {0, 2, 0}));
  EXPECT_FALSE(wavy.exact);
  EXPECT_NEAR(std::abs(wavy.normal().y()), 1.0, 1e-12);
  EXPECT_TRUE(plane_of(problem_of({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {0, 2, 0})).collinear);
}

RigidTransform pose_at(const Vector3d& position_m) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitY())), position_m};
}

TEST(JointObservation, RangeIsTheLengthInTheSensorsOwnFrame) {
  const JointObservation seen = observe({1, 2, 2}, TrackingState::inferred, pose_at({5, 6, 7}));
  EXPECT_TRUE(seen.seen);
  EXPECT_NEAR(seen.range_m, 3.0, 1e-15);
  EXPECT_NEAR((seen.point_in_world_m - Vector3d(5, 6, 7)).norm(), 3.0, 1e-14);
  EXPECT_FALSE(observe({0, 0, 0}, TrackingState::not_tracked, pose_at({5, 6, 7})).seen);
  EXPECT_FALSE(observe({kNaN, 0, 0}, TrackingState::tracked, pose_at({5, 6, 7})).seen);
}

TEST(JointObservation, RangesOfTheAllowedSensorsThatSeeTheJoint) {
  const std::vector<RigidTransform> poses{pose_at({1, 0, 0}), pose_at({2, 0, 0}), pose_at({3, 0, 0}),
                                          pose_at({4, 0, 0})};
  std::vector<JointObservation> observations;
  for (const RigidTransform& pose : poses)
    observations.push_back(observe({0, 0, 2}, TrackingState::tracked, pose));
  observations[1] = {};
  RangeProblem problem = ranges_of(observations, poses);
  EXPECT_EQ(problem.count, 3);
  EXPECT_EQ(problem.rig_index[1], 2);
  EXPECT_EQ(problem.sensor_m[2], Vector3d(4, 0, 0));
  problem = ranges_of(observations, poses, SensorMask(0b1011));
  EXPECT_EQ(problem.count, 2);
  EXPECT_LT(
      (*problem.guess_m - 0.5 * (observations[0].point_in_world_m + observations[3].point_in_world_m)).norm(),
      1e-15);
  problem = ranges_of(observations, poses, SensorMask(0b0010));
  EXPECT_EQ(problem.count, 0);
  EXPECT_FALSE(problem.guess_m);
  EXPECT_THROW(ranges_of(observations, {poses.data(), 3}), InternalError);
}

TEST(Baselines, MeanTrackedMeanAndSingleSensor) {
  std::vector<JointObservation> observations{{true, TrackingState::tracked, {1, 0, 0}, 1},
                                             {true, TrackingState::inferred, {4, 0, 0}, 1},
                                             {false, TrackingState::not_tracked, {100, 0, 0}, 1},
                                             {true, TrackingState::tracked, {4, 3, 0}, 1}};
  EXPECT_EQ(solve_mean(observations, {}).position_m, Vector3d(3, 1, 0));
  EXPECT_EQ(solve_mean(observations, {kAllSensors, true}).position_m, Vector3d(2.5, 1.5, 0));
  EXPECT_EQ(solve_mean(observations, {SensorMask(0b0110), true}).position_m, Vector3d(4, 0, 0));
  EXPECT_EQ(solve_mean(observations, {SensorMask(0b0100)}).status, SolveStatus::no_observation);
  EXPECT_EQ(solve_mean({}, {}).status, SolveStatus::no_observation);
  EXPECT_EQ(solve_single_sensor(observations, {3}).position_m, Vector3d(4, 3, 0));
  EXPECT_EQ(solve_single_sensor(observations, {2}).status, SolveStatus::no_observation);
  EXPECT_THROW((void)solve_single_sensor(observations, {4}), InternalError);
  observations[0].point_in_world_m.x() = kNaN;
  EXPECT_EQ(solve_mean(observations, {}).status, SolveStatus::non_finite_input);
}

}  // namespace
}  // namespace trilat
