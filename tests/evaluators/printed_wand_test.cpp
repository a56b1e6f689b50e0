// SPDX-License-Identifier: MIT
// The paper's recognition by pencil, on images of a far background and one near block.
#include "evaluators/wand/printed_wand.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "tests/support/depth_pictures.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

const DepthRays& printed_rays() {
  static const DepthRays result = depth_rays(DepthIntrinsics{});
  return result;
}

DepthPicture filled_with(std::uint16_t depth_mm) {
  return {512, 424, std::vector<std::uint16_t>(512 * 424, depth_mm)};
}

void put_block(DepthPicture& picture, int left, int top, int right, int bottom, std::uint16_t depth_mm) {
  for (int row = top; row <= bottom; ++row)
    for (int column = left; column <= right; ++column) picture.at(column, row) = depth_mm;
}

// 21 x 11 pixels at 1 m in front of a wall at 4 m; the middle is the pixel (310, 105).
DepthPicture block_before_a_wall() {
  DepthPicture picture = filled_with(4000);
  put_block(picture, 300, 100, 320, 110, 1000);
  return picture;
}

PrintedWandOptions all_equations_corrected() {
  return {.invalid_pixels = Variant::corrected,
          .binarisation = ThresholdRule::corrected,
          .projection = Variant::corrected,
          .centre = Variant::corrected};
}

TEST(PrintedWand, AsPrintedItNeverEndsButLeavesTheBlock) {
  const WandSighting sighting = find_wand_as_printed(block_before_a_wall().view(), printed_rays(), {});
  EXPECT_EQ(sighting.status, WandStatus::not_ended);
  EXPECT_EQ(sighting.pixels, 21 * 11);
  // Eq. 4 at 1 m, then eq. 5: 20 pixels become 20 centimetres; y is up in our frame.
  EXPECT_NEAR(sighting.centre_in_sensor_m.x(), std::tan(70.0 * kRadPerDegree * 54.0 / 512.0), 1e-12);
  EXPECT_NEAR(sighting.centre_in_sensor_m.y(), std::tan(60.0 * kRadPerDegree * 107.0 / 424.0), 1e-12);
  EXPECT_NEAR(sighting.centre_in_sensor_m.z(), 1.20, 1e-12);
  EXPECT_TRUE(std::isnan(sighting.covariance_m2(0, 0)));
}

TEST(PrintedWand, TheCorrectedStopRuleEndsWithTheSamePixels) {
  const WandSighting printed = find_wand_as_printed(block_before_a_wall().view(), printed_rays(), {});
  const WandSighting sighting = find_wand_as_printed(block_before_a_wall().view(), printed_rays(),
                                                     {.binarisation = ThresholdRule::corrected});
  EXPECT_EQ(sighting.status, WandStatus::found);
  EXPECT_EQ(sighting.pixels, 21 * 11);
  EXPECT_EQ(sighting.centre_in_sensor_m, printed.centre_in_sensor_m);
}

TEST(PrintedWand, TheLastPixelsOfThePrintedRuleAreThoseOfTheCorrectedOne) {
  DepthPicture picture = filled_with(4500);
  put_block(picture, 0, 0, 200, 423, 2200);  // someone beside it
  put_block(picture, 300, 100, 320, 110, 900);
  for (const ThresholdRule binarisation : {ThresholdRule::printed, ThresholdRule::corrected})
    EXPECT_EQ(find_wand_as_printed(picture.view(), printed_rays(), {.binarisation = binarisation}).pixels,
              21 * 11);
}

TEST(PrintedWand, AnImageInWhichNothingWasSeenShowsNoWand) {
  for (const ThresholdRule binarisation : {ThresholdRule::printed, ThresholdRule::corrected})
    EXPECT_EQ(find_wand_as_printed(filled_with(0).view(), printed_rays(),
                                   {.invalid_pixels = Variant::corrected, .binarisation = binarisation})
                  .status,
              WandStatus::no_wand);
}

// One invalid pixel is the nearest of all as printed: in the end only it is left.
TEST(PrintedWand, AsPrintedOneInvalidPixelTakesTheWandsPlace) {
  DepthPicture picture = block_before_a_wall();
  picture.at(20, 30) = 0;
  const WandSighting printed =
      find_wand_as_printed(picture.view(), printed_rays(), {.binarisation = ThresholdRule::corrected});
  // The first label map holds block and pixel: 0.5 m is less than C times 1 m, and the average is 0.998 m.
  EXPECT_EQ(printed.pixels, 1);
  EXPECT_NEAR(printed.centre_in_sensor_m.z(), 0.5, 1e-12);
  EXPECT_LT(printed.centre_in_sensor_m.x(), 0.0);
  const WandSighting corrected =
      find_wand_as_printed(picture.view(), printed_rays(),
                           {.invalid_pixels = Variant::corrected, .binarisation = ThresholdRule::corrected});
  EXPECT_EQ(corrected.pixels, 21 * 11);
}

TEST(PrintedWand, LinearAnglesAndThePinholeDifferByTheHandComputedNumber) {
  const DepthIntrinsics pinhole{
      .fx_px = 365.0, .fy_px = 365.0, .cx_px = 256.0, .cy_px = 212.0, .k1 = 0, .k2 = 0, .k3 = 0};
  const DepthRays pinhole_rays = depth_rays(pinhole);
  DepthPicture picture = filled_with(6000);
  put_block(picture, 380, 207, 388, 217, 2000);  // the middle is the pixel (384, 212)
  PrintedWandOptions options = {.binarisation = ThresholdRule::corrected};
  const WandSighting printed = find_wand_as_printed(picture.view(), pinhole_rays, options);
  options.projection = Variant::corrected;
  const WandSighting corrected = find_wand_as_printed(picture.view(), pinhole_rays, options);
  // 128 pixels: 2 m tan(17.5 degrees) = 0.630597 m against 2 m * 128 / 365 = 0.701370 m.
  EXPECT_NEAR(printed.centre_in_sensor_m.x(), 0.630597, 1e-6);
  EXPECT_NEAR(corrected.centre_in_sensor_m.x(), 0.701370, 1e-6);
  EXPECT_NEAR(printed.centre_in_sensor_m.y(), 0.0, 1e-12);
  EXPECT_NEAR(corrected.centre_in_sensor_m.y(), 0.0, 1e-12);
}

TEST(PrintedWand, ThePrintedCentreAddsTheWidthInPixelsAndTheCorrectedOneTheRadiusAlongTheRay) {
  PrintedWandOptions options = {.binarisation = ThresholdRule::corrected, .projection = Variant::corrected};
  const WandSighting printed = find_wand_as_printed(block_before_a_wall().view(), printed_rays(), options);
  options.centre = Variant::corrected;
  const WandSighting corrected = find_wand_as_printed(block_before_a_wall().view(), printed_rays(), options);
  const Vector3d surface = printed.centre_in_sensor_m - Vector3d(0.0, 0.0, 0.20);
  EXPECT_NEAR(surface.z(), 1.0, 1e-12);
  EXPECT_LT((corrected.centre_in_sensor_m - surface - 0.075 * surface.normalized()).norm(), 1e-12);
}

TEST(PrintedWand, AnInvalidMiddleTakesTheDepthOfTheNearestLabelledPixel) {
  DepthPicture picture = block_before_a_wall();
  put_block(picture, 309, 104, 311, 106, 0);
  picture.at(310, 107) = 1010;
  const WandSighting sighting =
      find_wand_as_printed(picture.view(), printed_rays(),
                           {.invalid_pixels = Variant::corrected, .binarisation = ThresholdRule::corrected});
  // Two pixels away lie (310, 103), (308, 105), (312, 105) and (310, 107); the first in reading order is
  // taken.
  EXPECT_EQ(sighting.pixels, 21 * 11 - 9);
  EXPECT_NEAR(sighting.centre_in_sensor_m.z(), 1.0 + 0.20, 1e-12);
}

TEST(PrintedWand, AMiddleBetweenPixelsIsProjectedAsSuch) {
  DepthPicture picture = filled_with(4000);
  put_block(picture, 256, 212, 257, 213, 1000);
  const WandSighting sighting =
      find_wand_as_printed(picture.view(), printed_rays(), {.binarisation = ThresholdRule::corrected});
  EXPECT_NEAR(sighting.centre_in_sensor_m.x(), std::tan(70.0 * kRadPerDegree * 0.5 / 512.0), 1e-12);
  EXPECT_NEAR(sighting.centre_in_sensor_m.z(), 1.01, 1e-12);
}

TEST(PrintedWand, NearerThanHalfTheAverageOrItIsNotSeen) {
  DepthPicture picture = filled_with(3000);
  put_block(picture, 300, 100, 320, 110, 1600);  // C times the average is 1.505 m
  EXPECT_EQ(find_wand_as_printed(picture.view(), printed_rays(), all_equations_corrected()).status,
            WandStatus::no_wand);
  put_block(picture, 300, 100, 320, 110, 1490);
  EXPECT_EQ(find_wand_as_printed(picture.view(), printed_rays(), all_equations_corrected()).status,
            WandStatus::found);
}

// The ball 1 m away, somebody 1.8 m, a wall 5 m: the nearest of both is not half as near as the other, so the
// corrected rule is content with both of them.
TEST(PrintedWand, ByTheMidRangeOnlyTheBallIsLeftWhereTheMeanKeepsAPersonToo) {
  const Vector3d ball(-0.1, 0.05, 1.0);
  const DepthPicture picture = picture_of({.balls = {{ball, 0.075}},
                                           .discs = {{{0.5, 0.0, 1.8}, Vector3d::UnitZ(), 0.3}},
                                           .sticks = {},
                                           .planes = {{Vector3d::UnitZ(), 5.0}}},
                                          printed_rays());
  PrintedWandOptions options = all_equations_corrected();
  const WandSighting by_mean = find_wand_as_printed(picture.view(), printed_rays(), options);
  ASSERT_EQ(by_mean.status, WandStatus::found);
  EXPECT_GT((by_mean.centre_in_sensor_m - ball).norm(), 0.2);
  options.binarisation = ThresholdRule::mid_range;
  const WandSighting by_mid_range = find_wand_as_printed(picture.view(), printed_rays(), options);
  ASSERT_EQ(by_mid_range.status, WandStatus::found);
  EXPECT_LT((by_mid_range.centre_in_sensor_m - ball).norm(), 0.015);
}

// A ball at 2.6 m before a wall at 4 m: half of the mean is nearer than either.
TEST(PrintedWand, ByTheMidRangeABallInFrontOfANearWallIsFound) {
  const Vector3d ball(0.1, 0.0, 2.6);
  const DepthPicture picture =
      picture_of({{{ball, 0.075}}, {}, {}, {{Vector3d::UnitZ(), 4.0}}}, printed_rays());
  PrintedWandOptions options = all_equations_corrected();
  EXPECT_EQ(find_wand_as_printed(picture.view(), printed_rays(), options).status, WandStatus::no_wand);
  options.binarisation = ThresholdRule::mid_range;
  const WandSighting sighting = find_wand_as_printed(picture.view(), printed_rays(), options);
  ASSERT_EQ(sighting.status, WandStatus::found);
  EXPECT_LT((sighting.centre_in_sensor_m - ball).norm(), 0.015);
}

// 1.000, 1.010 and 1.011 m: with C = 0.5025 the first two end, for 1.0101 times 1 m is no less than 1.01 m;
// of all three the last is taken off first (2.011 m times C is 1.0105 m).
TEST(PrintedWand, ByTheMidRangeItEndsWhenTheNextThresholdLeavesNothingOut) {
  DepthPicture picture = filled_with(4000);
  put_block(picture, 300, 100, 319, 109, 1000);
  put_block(picture, 300, 110, 319, 119, 1010);
  put_block(picture, 300, 120, 319, 129, 1011);
  const WandSighting sighting =
      find_wand_as_printed(picture.view(), printed_rays(), {.binarisation = ThresholdRule::mid_range});
  EXPECT_EQ(sighting.status, WandStatus::found);
  EXPECT_EQ(sighting.pixels, 400);
}

}  // namespace
}  // namespace trilat
