// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/movement_lag.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

constexpr double kRate_hz = 30.0;

// Two joints that swing with two periods each, seen `late_s` later, with noise of its own.
Movements swinging(double duration_s, double late_s, std::uint64_t seed) {
  const RandomStream random{seed, Purpose::test, 0};
  Movements movements{{}, 2};
  std::uint32_t draw = 0;
  for (int i = 0; i < static_cast<int>(duration_s * kRate_hz); ++i)
    for (const double period_s : {1.7, 2.3}) {
      const double phase = 2.0 * std::numbers::pi * (i / kRate_hz - late_s) / period_s;
      Eigen::Vector3d moved_m(0.1 * std::cos(phase), 0.05 * std::sin(0.61 * phase),
                              0.03 * std::cos(1.37 * phase));
      for (double& axis_m : moved_m) axis_m += 0.005 * random.normal(draw++);
      movements.moved_m.push_back(moved_m);
    }
  return movements;
}

TEST(MovementLag, IsFoundToAPartOfAFrameWithItsUncertainty) {
  for (const double late_s : {-1.2, -1.0, -0.4, -0.11, 0.25, 0.8}) {
    const MovementLag found = lag_of(swinging(30.0, late_s, 1), swinging(30.0, 0.0, 2), kRate_hz);
    EXPECT_NEAR(found.lag_s, late_s, 0.01);
    EXPECT_LT(found.sigma_s, 0.02);
    EXPECT_GT(found.sigma_s, 0.0);
  }
}

TEST(MovementLag, IsUnknownWithoutOneAndWhereStreamsAreShortOrHaveNothingInCommon) {
  EXPECT_TRUE(std::isnan(lag_of(swinging(30.0, 0.0, 1), swinging(30.0, 0.0, 2), kRate_hz).lag_s));
  EXPECT_TRUE(std::isnan(lag_of(swinging(5.9, 0.25, 1), swinging(5.9, 0.0, 2), kRate_hz).lag_s));
  Movements noise = swinging(30.0, 0.0, 1);
  const RandomStream random{3, Purpose::test, 0};
  std::uint32_t draw = 0;
  for (Eigen::Vector3d& moved_m : noise.moved_m)
    for (double& axis_m : moved_m) axis_m = 0.1 * random.normal(draw++);
  EXPECT_TRUE(std::isnan(lag_of(noise, swinging(30.0, 0.0, 2), kRate_hz).lag_s));
}

}  // namespace
}  // namespace trilat
