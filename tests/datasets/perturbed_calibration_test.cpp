// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "datasets/synthetic/simulation_spec.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

Calibration calibration_of(std::size_t sensors, const Eigen::Quaterniond& rotation) {
  Calibration calibration;
  for (std::size_t s = 0; s < sensors; ++s) {
    SensorPose pose{"k" + std::to_string(s + 1), {}};
    pose.world_from_sensor.rotation = rotation;
    pose.world_from_sensor.translation_m = {1.0, 2.0, static_cast<double>(s)};
    calibration.sensors.push_back(pose);
  }
  return calibration;
}

// Rotation vector in world axes, and shift.
struct Offset {
  Vector3d turn_rad, shift_m;
};
std::vector<Offset> offsets(const Calibration& from, const Calibration& to) {
  std::vector<Offset> result;
  for (std::size_t s = 0; s < from.sensors.size(); ++s) {
    const RigidTransform &a = from.sensors[s].world_from_sensor, &b = to.sensors[s].world_from_sensor;
    const Eigen::AngleAxisd turn(b.rotation * a.rotation.conjugate());
    result.push_back({turn.angle() * turn.axis(), b.translation_m - a.translation_m});
  }
  return result;
}

TEST(PerturbedCalibration, ErrorsAreOfTheStatedSizeOnEveryAxis) {
  constexpr std::size_t kSensors = 4000;
  constexpr double kSigma_m = 0.005, kSigma_rad = 0.02;
  const Calibration exact = calibration_of(kSensors, Eigen::Quaterniond::Identity());
  const Calibration off = perturbed(exact, kSigma_m, kSigma_rad, 1);
  Vector3d turn = Vector3d::Zero(), turn2 = turn, shift = turn, shift2 = turn;
  double together = 0.0;
  for (const Offset& o : offsets(exact, off)) {
    turn += o.turn_rad / (kSensors * kSigma_rad);
    shift += o.shift_m / (kSensors * kSigma_m);
    turn2 += o.turn_rad.cwiseAbs2() / (kSensors * kSigma_rad * kSigma_rad);
    shift2 += o.shift_m.cwiseAbs2() / (kSensors * kSigma_m * kSigma_m);
    together += o.turn_rad.x() * o.shift_m.x() / (kSensors * kSigma_rad * kSigma_m);
  }
  for (int axis = 0; axis < 3; ++axis) {  // standard errors are 0.016 and 0.022
    EXPECT_NEAR(turn[axis], 0.0, 0.06);
    EXPECT_NEAR(shift[axis], 0.0, 0.06);
    EXPECT_NEAR(turn2[axis], 1.0, 0.09);
    EXPECT_NEAR(shift2[axis], 1.0, 0.09);
  }
  EXPECT_NEAR(together, 0.0, 0.06);
  EXPECT_EQ(off.sensors[0].position_sigma_m, kSigma_m);
  EXPECT_EQ(off.sensors[0].rotation_sigma_rad, kSigma_rad);
}

// Only a rotation in world axes is the same for sensors that look elsewhere.
TEST(PerturbedCalibration, TurnsInWorldAxesAboutTheSensorsOwnPlace) {
  const Eigen::Quaterniond looking(Eigen::AngleAxisd(2.0, Vector3d(1.0, 2.0, -0.5).normalized()));
  const Calibration a = calibration_of(20, Eigen::Quaterniond::Identity()), b = calibration_of(20, looking);
  const auto of_a = offsets(a, perturbed(a, 0.01, 0.05, 4)), of_b = offsets(b, perturbed(b, 0.01, 0.05, 4));
  for (std::size_t s = 0; s < of_a.size(); ++s) {
    EXPECT_LT((of_a[s].turn_rad - of_b[s].turn_rad).norm(), 1e-12);
    EXPECT_LT((of_a[s].shift_m - of_b[s].shift_m).norm(), 1e-12);
    EXPECT_GT(of_a[s].turn_rad.norm(), 1e-4);
  }
}

TEST(PerturbedCalibration, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const Calibration exact = calibration_of(3, Eigen::Quaterniond::Identity());
  const auto once = offsets(exact, perturbed(exact, 0.01, 0.05, 4)),
             again = offsets(exact, perturbed(exact, 0.01, 0.05, 4)),
             other = offsets(exact, perturbed(exact, 0.01, 0.05, 5));
  for (std::size_t s = 0; s < once.size(); ++s) {
    EXPECT_EQ(once[s].shift_m, again[s].shift_m);
    EXPECT_EQ(once[s].turn_rad, again[s].turn_rad);
    EXPECT_NE(once[s].shift_m, other[s].shift_m);
    EXPECT_NE(once[s].turn_rad, other[s].turn_rad);
  }
  EXPECT_NE(once[0].shift_m, once[1].shift_m);
  for (const Offset& none : offsets(exact, perturbed(exact, 0.0, 0.0, 4))) {
    EXPECT_EQ(none.shift_m, Vector3d::Zero());
    EXPECT_EQ(none.turn_rad.norm(), 0.0);
  }
}

}  // namespace
}  // namespace trilat
