// SPDX-License-Identifier: MIT
#include "evaluators/ceres/rig_refinement.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "datasets/base/philox.h"
#include "datasets/base/units.h"
#include "evaluators/calibration/rig_start.h"

namespace trilat {
namespace {

// A rig of four sensors around a volume in which a ball is held at many places, as numbers: what each sensor
// measures with the noise and the depth errors asked for.
struct SimulatedRig {
  std::vector<RigidTransform> world_from_sensor;
  std::vector<Eigen::Vector3d> position_m;
  RigProblem problem;
};

struct RigErrors {
  double noise_m = 0.0;
  double offset_limit_m = 0.0;
  double wiggle_low_m = 0.0, wiggle_high_m = 0.0;
};

RigidTransform wand_from_world(const std::vector<Eigen::Vector3d>& p) {
  Eigen::Matrix3d axes;
  axes.row(0) = (p[1] - p[0]).normalized();
  axes.row(2) = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  const Eigen::Quaterniond rotation(axes);
  return {rotation, -(rotation * p[0])};
}

SimulatedRig simulated_rig(std::uint64_t seed, const RigErrors& errors, std::size_t positions = 50) {
  SimulatedRig rig;
  const RandomStream random{seed, Purpose::test, 77};
  std::uint32_t draw = 0;
  const double heights_m[] = {0.6, 2.2, 0.9, 1.9};
  for (int s = 0; s < 4; ++s) {
    const double angle = (s + 0.5) * std::numbers::pi / 2.0;
    rig.world_from_sensor.push_back(world_from_sensor_looking_at(
        {2.0 * std::sin(angle), heights_m[s], 2.0 * std::cos(angle)}, {0.0, 1.0, 0.0}));
  }
  rig.position_m = {{0.0, 1.0, 0.0}, {0.7, 1.0, 0.1}, {0.1, 1.6, 0.0}};
  while (rig.position_m.size() < positions) {
    const double x = random.uniform(draw, -0.9, 0.9), z = random.uniform(draw + 1, -0.9, 0.9);
    rig.position_m.emplace_back(x, random.uniform(draw + 2, 0.4, 1.7), z);
    draw += 3;
  }
  rig.problem.sensors = 4;
  rig.problem.points = positions;
  draw = 10'000;
  for (std::size_t s = 0; s < 4; ++s) {
    const double offset_m = random.uniform(draw++, -errors.offset_limit_m, errors.offset_limit_m);
    const double wiggle_m = random.uniform(draw++, errors.wiggle_low_m, errors.wiggle_high_m);
    const double length_m = random.uniform(draw++, 0.6, 2.0);
    const double phase = random.uniform(draw++, 0.0, 2.0 * std::numbers::pi);
    for (std::size_t p = 0; p < positions; ++p) {
      const Eigen::Vector3d truth = rig.world_from_sensor[s].inverse() * rig.position_m[p];
      const double surface_m = truth.z() - 0.075 * truth.z() / truth.norm();
      const double error_m =
          offset_m + wiggle_m * std::sin(2.0 * std::numbers::pi * surface_m / length_m + phase);
      Eigen::Vector3d measured = truth + error_m * truth / truth.z();
      for (int axis = 0; axis < 3; ++axis) measured[axis] += errors.noise_m * random.normal(draw++);
      const double sigma_m = std::max(errors.noise_m, 1e-6);
      rig.problem.observations.push_back({s,
                                          p,
                                          measured,
                                          sigma_m * sigma_m * Eigen::Matrix3d::Identity(),
                                          {surface_m + error_m, truth / truth.z(), Eigen::Vector3d::Zero()}});
    }
  }
  return rig;
}

RigRefinement refine(const RigProblem& problem, const RigRefinementOptions& options) {
  const RigStart start = initial_poses(problem, {});
  EXPECT_TRUE(start.complete());
  RigGauge gauge;
  gauge.first_points = GaugePoints{{0, 1, 2}};
  return bundle_adjust(problem, start.reference_from_sensor, start.reference, gauge, options);
}

struct PoseError {
  Eigen::Vector3d position_m;
  Eigen::Vector3d rotation_rad;
};

PoseError error_of(const SimulatedRig& rig, const RigRefinement& refined, std::size_t sensor) {
  const RigidTransform truth = wand_from_world(rig.position_m) * rig.world_from_sensor[sensor];
  const RigidTransform& got = refined.sensors[sensor].world_from_sensor;
  const Eigen::AngleAxisd turn(got.rotation * truth.rotation.conjugate());
  return {got.translation_m - truth.translation_m, turn.angle() * turn.axis()};
}

TEST(RigRefinement, RecoversPosesExactlyWithoutNoise) {
  const SimulatedRig rig = simulated_rig(1, {});
  RigRefinementOptions options;
  options.depth_correction = DepthCorrectionOptions{};
  const RigRefinement refined = refine(rig.problem, options);
  ASSERT_EQ(refined.status, RigStatus::converged);
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_LT(error_of(rig, refined, s).position_m.norm(), 1e-9);
    EXPECT_LT(error_of(rig, refined, s).rotation_rad.norm(), 1e-9);
    EXPECT_NEAR(refined.sensors[s].depth_offset_m, 0.0, 1e-9);
  }
}

TEST(RigRefinement, StatedIntervalsCoverTheTruthWithDepthOffsetsAndWiggle) {
  int covered = 0, asked = 0;
  double worst_m = 0.0, worst_rad = 0.0, position_z2 = 0.0, rotation_z2 = 0.0, reduced_chi2 = 0.0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const SimulatedRig rig = simulated_rig(seed, {0.0001, 0.024, 0.002, 0.005});
    RigRefinementOptions options;
    options.depth_correction = DepthCorrectionOptions{};
    const RigRefinement refined = refine(rig.problem, options);
    ASSERT_EQ(refined.status, RigStatus::converged);
    reduced_chi2 += refined.reduced_chi2 / 60.0;
    for (std::size_t s = 0; s < 4; ++s) {
      const PoseError error = error_of(rig, refined, s);
      worst_m = std::max(worst_m, error.position_m.norm());
      worst_rad = std::max(worst_rad, error.rotation_rad.norm());
      for (int axis = 0; axis < 3; ++axis) {
        covered += std::abs(error.position_m[axis]) <
                   1.96 * std::sqrt(refined.sensors[s].covariance(3 + axis, 3 + axis));
        covered +=
            std::abs(error.rotation_rad[axis]) < 1.96 * std::sqrt(refined.sensors[s].covariance(axis, axis));
        asked += 2;
        position_z2 += error.position_m[axis] * error.position_m[axis] /
                       refined.sensors[s].covariance(3 + axis, 3 + axis);
        rotation_z2 +=
            error.rotation_rad[axis] * error.rotation_rad[axis] / refined.sensors[s].covariance(axis, axis);
      }
    }
  }
  EXPECT_GT(covered, asked * 0.93);
  EXPECT_LT(covered, asked * 0.97);
  EXPECT_NEAR(std::sqrt(2.0 * position_z2 / asked), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(2.0 * rotation_z2 / asked), 1.0, 0.2);
  EXPECT_NEAR(reduced_chi2, 1.0, 0.15);
  EXPECT_LT(worst_m, 0.005);
  EXPECT_LT(worst_rad, 0.2 * kRadPerDegree);
}

PoseError difference(const RigidTransform& a, const RigidTransform& b) {
  const Eigen::AngleAxisd turn(a.rotation * b.rotation.conjugate());
  return {a.translation_m - b.translation_m, turn.angle() * turn.axis()};
}

RigRefinement refine_with(const RigProblem& problem, const RigGauge& gauge,
                          const RigRefinementOptions& options = {}) {
  const RigStart start = initial_poses(problem, {});
  EXPECT_TRUE(start.complete());
  return bundle_adjust(problem, start.reference_from_sensor, start.reference, gauge, options);
}

TEST(RigRefinement, AWrongSightingIsLeftOutAndThePosesAreAsWithoutIt) {
  const RigProblem right = simulated_rig(4, {.noise_m = 0.0003}).problem;
  const std::size_t wrong_one = 2 * 50 + 17;  // of the third sensor
  RigProblem wrong = right, without = right;
  wrong.observations[wrong_one].point_in_sensor_m.x() += 0.05;
  without.observations.erase(without.observations.begin() + wrong_one);
  const RigRefinement got = refine(wrong, {}), expected = refine(without, {});
  ASSERT_EQ(got.status, RigStatus::converged);
  for (std::size_t i = 0; i < wrong.observations.size(); ++i) EXPECT_EQ(got.used[i], i != wrong_one) << i;
  EXPECT_GT(got.chi2[wrong_one], 1000.0);
  EXPECT_EQ(got.sensors[2].rejected, 1u);
  EXPECT_EQ(got.sensors[2].used, 49u);
  EXPECT_EQ(got.sensors[0].rejected, 0u);
  for (std::size_t s = 0; s < 4; ++s) {
    const PoseError error =
        difference(got.sensors[s].world_from_sensor, expected.sensors[s].world_from_sensor);
    EXPECT_LT(error.position_m.norm(), 1e-7);
    EXPECT_LT(error.rotation_rad.norm(), 1e-7);
  }
}

// Two sensors that disagree about a point do not say which of them is wrong.
TEST(RigRefinement, OfAPointThatOnlyTwoSensorsSeeBothSightingsAreLeftOut) {
  RigProblem problem = simulated_rig(4, {.noise_m = 0.0003}).problem;
  std::erase_if(problem.observations,
                [](const PointObservation& o) { return o.point == 17 && o.sensor >= 2; });
  for (PointObservation& o : problem.observations)
    if (o.point == 17 && o.sensor == 1) o.point_in_sensor_m.y() += 0.05;
  const RigRefinement got = refine(problem, {});
  ASSERT_EQ(got.status, RigStatus::converged);
  for (std::size_t i = 0; i < problem.observations.size(); ++i)
    EXPECT_EQ(got.used[i], problem.observations[i].point != 17);
  EXPECT_TRUE(got.point_in_world_m[17].array().isNaN().all());
}

TEST(RigRefinement, KnownPointsGiveTheWorldsFrame) {
  const SimulatedRig rig = simulated_rig(2, {});
  RigGauge gauge;
  for (std::size_t p : {4u, 9u, 20u, 31u}) gauge.control_points.push_back({p, rig.position_m[p]});
  const RigRefinement refined = refine_with(rig.problem, gauge);
  ASSERT_EQ(refined.status, RigStatus::converged);
  for (std::size_t s = 0; s < 4; ++s) {
    const PoseError error = difference(refined.sensors[s].world_from_sensor, rig.world_from_sensor[s]);
    EXPECT_LT(error.position_m.norm(), 1e-8);
    EXPECT_LT(error.rotation_rad.norm(), 1e-8);
  }
}

TEST(RigRefinement, KnownPointsOnALineDoNotDetermineTheWorld) {
  const SimulatedRig rig = simulated_rig(2, {});
  RigGauge gauge;
  for (std::size_t p : {4u, 9u, 20u})
    gauge.control_points.push_back({p, {0.3 * static_cast<double>(p), 1.0, 0.0}});
  EXPECT_EQ(refine_with(rig.problem, gauge).status, RigStatus::gauge_undetermined);
}

TEST(RigRefinement, WithoutAnyWorldTheReferenceStaysAtItsPose) {
  const SimulatedRig rig = simulated_rig(3, {.noise_m = 0.0003});
  const RigStart start = initial_poses(rig.problem, {});
  RigGauge gauge;
  gauge.world_from_reference = rig.world_from_sensor[start.reference];
  const RigRefinement refined =
      bundle_adjust(rig.problem, start.reference_from_sensor, start.reference, gauge, {});
  ASSERT_EQ(refined.status, RigStatus::converged);
  for (std::size_t s = 0; s < 4; ++s) {
    const PoseError error = difference(refined.sensors[s].world_from_sensor, rig.world_from_sensor[s]);
    EXPECT_LT(error.position_m.norm(), s == start.reference ? 1e-12 : 0.002) << s;
    EXPECT_LT(error.rotation_rad.norm(), s == start.reference ? 1e-12 : 0.001) << s;
  }
  EXPECT_EQ(refined.sensors[start.reference].covariance.norm(), 0.0);
}

TEST(RigRefinement, ThreeFirstPointsOnALineDoNotDetermineTheWorld) {
  const SimulatedRig rig = simulated_rig(1, {});
  RigProblem problem = rig.problem;
  const Eigen::Vector3d between = 0.5 * (rig.position_m[0] + rig.position_m[1]);
  for (PointObservation& o : problem.observations)
    if (o.point == 2) o.point_in_sensor_m = rig.world_from_sensor[o.sensor].inverse() * between;
  EXPECT_EQ(refine(problem, {}).status, RigStatus::gauge_undetermined);
}

TEST(RigRefinement, AFirstPointThatNoSensorSeesDoesNotDetermineTheWorld) {
  RigProblem problem = simulated_rig(2, {}).problem;
  std::erase_if(problem.observations, [](const PointObservation& o) { return o.point == 2; });
  EXPECT_EQ(refine(problem, {}).status, RigStatus::gauge_undetermined);
}

// Relative to the reference sensor the uncertainty falls with the root of the number of positions.
TEST(RigRefinement, FourTimesThePositionsHalveTheStatedUncertainty) {
  const auto sigma_m = [](std::size_t positions) {
    const RigRefinement refined = refine_with(simulated_rig(6, {.noise_m = 0.001}, positions).problem, {});
    EXPECT_EQ(refined.status, RigStatus::converged);
    double variance_m2 = 0.0;
    for (const RefinedSensor& sensor : refined.sensors)
      variance_m2 += sensor.covariance.bottomRightCorner<3, 3>().trace();
    return std::sqrt(variance_m2);
  };
  EXPECT_NEAR(sigma_m(80) / sigma_m(20), 0.5, 0.15);
}

TEST(RigRefinement, ADepthOffsetOfOneSensorIsFoundAndDoesNotMoveThePoses) {
  SimulatedRig rig = simulated_rig(8, {.noise_m = 0.0003});
  for (PointObservation& o : rig.problem.observations)
    if (o.sensor == 1) {
      o.point_in_sensor_m += 0.02 * o.point_in_sensor_m / o.point_in_sensor_m.z();
      o.depth.depth_m += 0.02;
    }
  RigRefinementOptions options;
  options.depth_correction = DepthCorrectionOptions{};
  const RigRefinement refined = refine(rig.problem, options);
  ASSERT_EQ(refined.status, RigStatus::converged);
  for (std::size_t s = 0; s < 4; ++s) {
    const RefinedSensor& sensor = refined.sensors[s];
    EXPECT_GT(sensor.depth_offset_sigma_m, 0.0);
    EXPECT_LT(sensor.depth_offset_sigma_m, 0.005);
    EXPECT_NEAR(sensor.depth_offset_m, s == 1 ? 0.02 : 0.0, 3.0 * sensor.depth_offset_sigma_m) << s;
    EXPECT_LT(error_of(rig, refined, s).position_m.norm(), 0.005);
  }
}

// Three sightings of one sensor that agree to centimetres only: enough to start from, too few to be left.
TEST(RigRefinement, ASensorWithFewerThanThreeGoodSightingsIsUndeterminedAndItsCountSaysSo) {
  RigProblem problem = simulated_rig(9, {.noise_m = 0.0003}).problem;
  std::erase_if(problem.observations, [](const PointObservation& o) { return o.sensor == 3 && o.point > 3; });
  for (PointObservation& o : problem.observations)
    if (o.sensor == 3) o.point_in_sensor_m.z() += o.point % 2 == 0 ? 0.03 : -0.03;
  const RigRefinement refined = refine_with(problem, {});
  ASSERT_EQ(refined.status, RigStatus::sensor_undetermined);
  EXPECT_LT(refined.sensors[3].used, 3u);
  EXPECT_EQ(refined.sensors[3].used + refined.sensors[3].rejected, 4u);
  for (std::size_t s = 0; s < 3; ++s) EXPECT_GE(refined.sensors[s].used, 3u);
}

// Whatever lies in memory meanwhile.
TEST(RigRefinement, EqualProblemsGiveEqualBits) {
  const RigProblem problem = simulated_rig(3, {0.0003, 0.024, 0.002, 0.005}, 20).problem;
  RigRefinementOptions options;
  options.depth_correction = DepthCorrectionOptions{};
  const RigRefinement first = refine(problem, options);
  std::vector<std::vector<char>> in_the_way;
  for (std::size_t i = 0; i < 40; ++i) {
    for (std::size_t k = 0; k < 20; ++k) in_the_way.emplace_back(16 + (i * 37 + k * 101) % 600);
    for (std::size_t k = i % 3; k < in_the_way.size(); k += 3) in_the_way[k] = {};
    const RigRefinement again = refine(problem, options);
    for (std::size_t s = 0; s < 4; ++s) {
      EXPECT_EQ(again.sensors[s].world_from_sensor.translation_m,
                first.sensors[s].world_from_sensor.translation_m);
      EXPECT_EQ(again.sensors[s].covariance, first.sensors[s].covariance);
    }
  }
}

}  // namespace
}  // namespace trilat
