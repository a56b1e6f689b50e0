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
      rig.problem.observations.push_back(
          {s, p, measured, sigma_m * sigma_m * Eigen::Matrix3d::Identity(), surface_m + error_m});
    }
  }
  return rig;
}

RigRefinement refine(const RigProblem& problem, const RigRefinementOptions& options) {
  const RigStart start = start_rig(problem, {});
  EXPECT_TRUE(start.complete());
  RigGauge gauge;
  gauge.first_points = FirstPoints{{0, 1, 2}};
  return refine_rig(problem, start.reference_from_sensor, start.reference, gauge, options);
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
  double worst_m = 0.0, worst_rad = 0.0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const SimulatedRig rig = simulated_rig(seed, {0.0003, 0.024, 0.002, 0.005});
    RigRefinementOptions options;
    options.depth_correction = DepthCorrectionOptions{};
    const RigRefinement refined = refine(rig.problem, options);
    ASSERT_EQ(refined.status, RigStatus::converged);
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
      }
    }
  }
  EXPECT_GT(covered, asked * 0.90);
  EXPECT_LT(covered, asked * 0.99);
  EXPECT_LT(worst_m, 0.005);
  EXPECT_LT(worst_rad, 0.2 * kRadPerDegree);
}

}  // namespace
}  // namespace trilat
