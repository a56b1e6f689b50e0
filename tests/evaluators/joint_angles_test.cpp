// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "evaluators/metrics/body_metrics.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
const Vector3d kKnee{0.3, 0.5, 2.0};

TEST(JointAngles, AStraightLegIsNotBentAndARightAngleIsHalfPi) {
  EXPECT_NEAR(flexion_rad(kKnee + Vector3d(0, 0.4, 0), kKnee, kKnee - Vector3d(0, 0.4, 0)), 0.0, 1e-12);
  EXPECT_NEAR(flexion_rad(kKnee + Vector3d(0, 0.4, 0), kKnee, kKnee - Vector3d(0, 0, 0.4)), kPi / 2, 1e-12);
  EXPECT_NEAR(flexion_rad(kKnee + Vector3d(0, 0.4, 0), kKnee, kKnee + Vector3d(0, 0.2, 0)), kPi, 1e-12);
}

TEST(JointAngles, LengthsOfSegmentsDoNotCount) {
  const Vector3d up(0.1, 0.4, 0.0), down(0.2, -0.3, 0.1);
  EXPECT_NEAR(flexion_rad(kKnee + up, kKnee, kKnee + down),
              flexion_rad(kKnee + 3.0 * up, kKnee, kKnee + 0.2 * down), 1e-12);
}

TEST(JointAngles, ATrunkLeansFromTheVertical) {
  const Vector3d hips(0, 1, 0);
  EXPECT_NEAR(inclination_rad(hips, hips + Vector3d(0, 0.5, 0)), 0.0, 1e-12);
  EXPECT_NEAR(inclination_rad(hips, hips + Vector3d(0.5, 0.5, 0)), kPi / 4, 1e-12);
  EXPECT_NEAR(inclination_rad(hips, hips - Vector3d(0, 0.5, 0)), kPi, 1e-12);
}

TEST(JointAngles, PointsInOnePlaceAndMissingPointsHaveNone) {
  const Vector3d other = kKnee + Vector3d(0, 0.4, 0), missing = Vector3d::Constant(std::nan(""));
  EXPECT_TRUE(std::isnan(flexion_rad(kKnee, kKnee, other)));
  EXPECT_TRUE(std::isnan(flexion_rad(other, kKnee, kKnee)));
  EXPECT_TRUE(std::isnan(flexion_rad(missing, kKnee, other)));
  EXPECT_TRUE(std::isnan(flexion_rad(other, kKnee, missing)));
  EXPECT_TRUE(std::isnan(inclination_rad(kKnee, kKnee)));
}

}  // namespace
}  // namespace trilat
