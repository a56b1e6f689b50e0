// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "evaluators/wand/ball_fit.h"
#include "evaluators/wand/find_wand.h"
#include "tests/support/depth_pictures.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kBall_m = 0.075;
const FindWandOptions kOptions;

const DepthRays& rays() {
  static const DepthRays result = depth_rays(DepthIntrinsics{});
  return result;
}

// A ball of the wand's size in front of a wall 1 m behind it.
PictureScene ball_at(const Vector3d& centre) {
  PictureScene scene;
  scene.balls.push_back({centre, kBall_m});
  scene.planes.push_back({Vector3d::UnitZ(), centre.z() + 1.0});
  return scene;
}

// In the direction of a pixel.
Vector3d point_behind(double column, double row, double depth_m) {
  const auto ray = ray_through(rays().intrinsics, {column, row});
  return depth_m * Vector3d(ray->x(), ray->y(), 1.0);
}

WandSighting found_in(const PictureScene& scene, const AxialNoise* noise = nullptr, std::uint64_t item = 0) {
  return find_wand(picture_of(scene, rays(), noise, item).view(), rays(), kOptions);
}

// As a Kinect does: of the pixels at a step of more than 5 cm four in five are lost.
DepthPicture without_most_edges(const DepthPicture& sharp) {
  const RandomStream random{23, Purpose::test, 0};
  DepthPicture picture = sharp;
  for (int row = 1; row + 1 < sharp.height_px; ++row)
    for (int column = 1; column + 1 < sharp.width_px; ++column) {
      const auto is_step = [&](int other_column, int other_row) {
        return std::abs(sharp.view().at_mm(column, row) - sharp.view().at_mm(other_column, other_row)) > 50;
      };
      if ((is_step(column - 1, row) || is_step(column + 1, row) || is_step(column, row - 1) ||
           is_step(column, row + 1)) &&
          random.uniform(static_cast<std::uint32_t>(rays().index(column, row))) < 0.8)
        picture.at(column, row) = 0;
    }
  return picture;
}

double error_m(const WandSighting& sighting, const Vector3d& truth) {
  return (sighting.centre_in_sensor_m - truth).norm();
}

TEST(BallFit, IsExactOnPointsOfASphere) {
  for (const Vector3d& centre :
       {Vector3d(0.0, 0.0, 2.0), Vector3d(0.9, -0.7, 1.6), Vector3d(-0.2, 0.1, 0.6)}) {
    std::vector<RayDepth> pixels;
    PictureScene scene;
    scene.balls.push_back({centre, kBall_m});
    for (double x = -0.15; x <= 0.15; x += 0.004)
      for (double y = -0.15; y <= 0.15; y += 0.004) {
        const Vector3d ray(centre.x() / centre.z() + x, centre.y() / centre.z() + y, 1.0);
        const RayHit hit = first_hit(scene, ray);
        pixels.push_back({ray.x(), ray.y(), std::isfinite(hit.depth_m) ? hit.depth_m : 0.0});
      }
    const BallFit fit = fit_ball(pixels, centre + Vector3d(0.02, -0.015, 0.02), {.pixel_rad = 0.004});
    ASSERT_EQ(fit.status, BallFitStatus::fitted) << centre.transpose();
    EXPECT_LT((fit.centre_in_sensor_m - centre).norm(), 1e-9);
    EXPECT_LT(fit.rms_m, 1e-9);
    EXPECT_LT(std::abs(fit.radius_excess_m), 1e-9);
    EXPECT_EQ(fit.inner_agreeing, fit.inner);
  }
}

// A constant and a slope, of balls on the optical axis and far off it, where a slope moves the centre
// sideways.
TEST(BallFit, AnErrorOfTheDepthMovesTheCentreAsItsInfluenceSays) {
  for (const Vector3d& centre : {Vector3d(0.0, 0.0, 2.0), Vector3d(0.5, -0.3, 1.2)}) {
    const BallFitOptions options{.pixel_rad = 0.002};
    const DepthSensitivity influence = depth_influence(centre, options);
    const double error_m = 0.004, slope = 0.02;
    std::vector<RayDepth> pixels;
    PictureScene scene;
    scene.balls.push_back({centre, kBall_m});
    for (double x = -0.12; x <= 0.12; x += 0.002)
      for (double y = -0.12; y <= 0.12; y += 0.002) {
        const Vector3d ray(centre.x() / centre.z() + x, centre.y() / centre.z() + y, 1.0);
        const RayHit hit = first_hit(scene, ray);
        if (std::isfinite(hit.depth_m))
          pixels.push_back(
              {ray.x(), ray.y(), hit.depth_m + error_m + slope * (hit.depth_m - influence.depth_m)});
      }
    const BallFit fit = fit_ball(pixels, centre, options);
    ASSERT_EQ(fit.status, BallFitStatus::fitted);
    const Vector3d moved_m = fit.centre_in_sensor_m - centre;
    EXPECT_LT((moved_m - influence.by_error * error_m - influence.by_slope_m * slope).norm(), 6e-5)
        << moved_m.transpose();
    EXPECT_NEAR(influence.by_error.normalized().dot(centre.normalized()), 1.0, 1e-3);
    EXPECT_EQ(influence.by_slope_m.head<2>().norm() > 0.002, centre.x() > 0.0);
  }
}

TEST(BallFit, SeesByHowMuchTheRadiusIsWrong) {
  std::vector<RayDepth> pixels;
  PictureScene scene;
  scene.balls.push_back({Vector3d(0.0, 0.0, 1.0), 0.076});
  for (double x = -0.1; x <= 0.1; x += 0.002)
    for (double y = -0.1; y <= 0.1; y += 0.002)
      if (const RayHit hit = first_hit(scene, {x, y, 1.0}); std::isfinite(hit.depth_m))
        pixels.push_back({x, y, hit.depth_m});
  const BallFit fit = fit_ball(pixels, {0.0, 0.0, 1.0}, {.pixel_rad = 0.002});
  EXPECT_NEAR(fit.radius_excess_m, 0.001, 5e-5);
}

TEST(BallFit, RefusesTooFewPixels) {
  const std::vector<RayDepth> pixels(kMinBallPixels - 1, RayDepth{0.0, 0.0, 0.925});
  EXPECT_EQ(fit_ball(pixels, {0.0, 0.0, 1.0}, {}).status, BallFitStatus::too_few_pixels);
}

TEST(BallFit, RefusesPixelsOnOneRay) {
  const std::vector<RayDepth> pixels(100, RayDepth{0.0, 0.0, 0.925});
  EXPECT_EQ(fit_ball(pixels, {0.0, 0.0, 1.0}, {}).status, BallFitStatus::rank_deficient);
}

TEST(FindWand, RecoversTheCentreFromRoundedDepthsAtEveryDistanceAndAngle) {
  for (const double depth_m : {0.6, 1.0, 2.0, 3.0, 4.0, 4.45})
    for (const auto& [column, row] :
         {std::pair{256.0, 212.0}, {100.0, 212.0}, {420.0, 300.0}, {256.0, 80.0}}) {
      const Vector3d centre = point_behind(column, row, depth_m);
      const WandSighting sighting = found_in(ball_at(centre));
      ASSERT_EQ(sighting.status, WandStatus::found) << depth_m << " m, pixel " << column << ", " << row;
      EXPECT_LT(error_m(sighting, centre), 2e-4) << depth_m << " m, pixel " << column << ", " << row;
      EXPECT_LT(sighting.rms_m, 4e-4);
    }
}

TEST(FindWand, NearSearchAgreesWithTheFullSearch) {
  const AxialNoise noise;
  for (const double depth_m : {0.6, 1.0, 2.0, 3.5, 4.4}) {
    const Vector3d centre = point_behind(300, 180, depth_m);
    const DepthPicture picture = picture_of(ball_at(centre), rays(), &noise);
    const WandSighting full = find_wand(picture.view(), rays(), kOptions);
    const WandSighting near =
        find_wand(picture.view(), rays(), kOptions, Vector3d(centre + Vector3d(0.05, 0.04, -0.05)));
    ASSERT_EQ(full.status, WandStatus::found) << depth_m;
    ASSERT_EQ(near.status, WandStatus::found) << depth_m;
    EXPECT_LT((full.centre_in_sensor_m - near.centre_in_sensor_m).norm(), 1e-6) << depth_m;
  }
}

TEST(FindWand, AnImageThatIsNotOfTheCamerasSizeIsOurBug) {
  const DepthPicture picture = picture_of(ball_at({0.0, 0.0, 2.0}), rays());
  DepthImageView narrow = picture.view(), low = picture.view();
  --narrow.width_px;
  --low.height_px;
  EXPECT_THROW(find_wand(narrow, rays(), kOptions), InternalError);
  EXPECT_THROW(find_wand(low, rays(), kOptions), InternalError);
}

TEST(FindWand, NearSearchDoesNotLookElsewhere) {
  const DepthPicture picture = picture_of(ball_at({0.5, 0.0, 2.0}), rays());
  EXPECT_EQ(find_wand(picture.view(), rays(), kOptions, Vector3d(-0.5, 0.0, 2.0)).status,
            WandStatus::no_wand);
  EXPECT_EQ(find_wand(picture.view(), rays(), kOptions, Vector3d(0.0, 0.0, -2.0)).status,
            WandStatus::no_wand);
  EXPECT_EQ(find_wand(picture.view(), rays(), kOptions, Vector3d(9.0, 0.0, 2.0)).status, WandStatus::no_wand);
}

// The mean of e' C^-1 e over n frames has mean 3 and variance 6 / n: within four standard deviations, and a
// tenth more above for the trimming of residuals. A small camera, since only the ball matters.
TEST(FindWand, CovarianceAgreesWithTheScatterOfNoisyFrames) {
  const DepthRays small_rays = depth_rays({.width_px = 128, .height_px = 96, .cx_px = 40.0, .cy_px = 50.0});
  const AxialNoise noise;
  FindWandOptions options;
  options.lateral_sigma_m = 0.0;  // the pictures have none
  for (const double depth_m : {1.0, 2.0, 4.0}) {
    const Vector3d centre = depth_m * Vector3d(0.05, -0.03, 1.0);
    constexpr int kFrames = 200;
    double sum = 0.0;
    Vector3d bias_m = Vector3d::Zero();
    for (std::uint64_t frame = 0; frame < kFrames; ++frame) {
      const DepthPicture picture = picture_of(ball_at(centre), small_rays, &noise, frame);
      const WandSighting sighting = find_wand(picture.view(), small_rays, options, centre);
      ASSERT_EQ(sighting.status, WandStatus::found) << depth_m << " m, frame " << frame;
      const Vector3d e = sighting.centre_in_sensor_m - centre;
      bias_m += e / kFrames;
      sum += e.dot(sighting.covariance_m2.inverse() * e);
    }
    const double four_sigma = 4.0 * std::sqrt(6.0 / kFrames);
    EXPECT_GT(sum / kFrames, 3.0 - four_sigma) << depth_m;
    EXPECT_LT(sum / kFrames, 3.3 + four_sigma) << depth_m;
    EXPECT_LT(bias_m.norm(), 5e-4) << depth_m;
  }
}

TEST(FindWand, NoiseAtTwoMetresCostsAFewTenthsOfAMillimetre) {
  const AxialNoise noise;
  const WandSighting sighting = found_in(ball_at({0.1, 0.1, 2.0}), &noise);
  ASSERT_EQ(sighting.status, WandStatus::found);
  EXPECT_LT(std::sqrt(sighting.covariance_m2.trace() / 3.0), 3e-4);
  EXPECT_GT(std::sqrt(sighting.covariance_m2.trace() / 3.0), 3e-5);
}

TEST(FindWand, TakesNoneOfTwoBalls) {
  PictureScene scene = ball_at({0.4, 0.0, 2.0});
  scene.balls.push_back({{-0.4, 0.1, 2.2}, kBall_m});
  EXPECT_EQ(found_in(scene).status, WandStatus::several_candidates);
}

// A mirror at 3 m shows the ball once more, behind its plane; nothing else stands there.
TEST(FindWand, TakesNoneWhenAMirrorShowsTheBallAgain) {
  PictureScene scene;
  scene.balls.push_back({{0.3, 0.0, 2.2}, kBall_m});
  scene.balls.push_back({{0.3 - 0.5, 0.0, 3.8}, kBall_m});
  EXPECT_EQ(found_in(scene).status, WandStatus::several_candidates);
}

TEST(FindWand, TakesNoHeadForABall) {
  const AxialNoise noise;
  for (const double depth_m : {1.0, 2.0, 3.0, 4.0, 4.4})
    for (const std::uint64_t item : {0u, 1u, 2u, 3u}) {
      PictureScene scene;
      scene.balls.push_back({{0.2, 0.3, depth_m}, 0.1});
      const DepthPicture sharp = picture_of(scene, rays(), &noise, item);
      EXPECT_EQ(find_wand(sharp.view(), rays(), kOptions).status, WandStatus::no_wand) << depth_m;
      EXPECT_EQ(find_wand(without_most_edges(sharp).view(), rays(), kOptions).status, WandStatus::no_wand)
          << depth_m;
    }
}

TEST(FindWand, TakesNoSmallerBallOrFistForTheWand) {
  const AxialNoise noise;
  for (const double radius_m : {0.045, 0.055})
    for (const double depth_m : {1.0, 2.0, 3.0, 4.4}) {
      PictureScene scene;
      scene.balls.push_back({{0.2, 0.3, depth_m}, radius_m});
      EXPECT_EQ(found_in(scene, &noise).status, WandStatus::no_wand) << radius_m << " " << depth_m;
    }
}

TEST(FindWand, FindsTheBallBesideAHeadAndLimbs) {
  const AxialNoise noise;
  const Vector3d centre(-0.5, 0.2, 2.4);
  PictureScene scene = ball_at(centre);
  scene.balls.push_back({{0.5, 0.5, 2.5}, 0.1});
  scene.sticks.push_back({{0.5, 0.4, 2.5}, {0.5, -0.4, 2.5}, 0.15});
  scene.sticks.push_back({{0.4, 0.3, 2.4}, {0.2, 0.0, 2.3}, 0.05});
  scene.sticks.push_back({{0.4, -0.4, 2.5}, {0.35, -1.2, 2.5}, kBall_m});
  scene.sticks.push_back({{0.6, -0.4, 2.5}, {0.65, -1.2, 2.5}, kBall_m});
  const WandSighting sighting = found_in(scene, &noise);
  ASSERT_EQ(sighting.status, WandStatus::found) << name_of(sighting.status);
  EXPECT_LT(error_m(sighting, centre), 0.0015);
}

TEST(FindWand, TakesNoLimbForABall) {
  const AxialNoise noise;
  for (const double radius_m : {0.06, kBall_m, 0.09})
    for (const double depth_m : {1.0, 2.0, 4.0}) {
      PictureScene scene;
      scene.sticks.push_back({{-0.25, -0.3, depth_m}, {0.1, 0.25, depth_m + 0.1}, radius_m});
      EXPECT_EQ(found_in(scene, &noise).status, WandStatus::no_wand) << radius_m << " " << depth_m;
    }
}

TEST(FindWand, TakesNoFlatDiscForABall) {
  const AxialNoise noise;
  for (const double depth_m : {0.7, 1.0, 2.0, 3.0, 4.0, 4.4})
    for (const Vector3d& normal : {Vector3d(0, 0, 1), Vector3d(0.5, 0.2, 0.8)})
      for (const std::uint64_t item : {0u, 1u, 2u}) {
        PictureScene scene;
        scene.discs.push_back({{0.1, 0.1, depth_m}, normal.normalized(), kBall_m});
        EXPECT_EQ(found_in(scene, &noise, item).status, WandStatus::no_wand) << depth_m;
      }
}

TEST(FindWand, TakesNoCornerOfARoomForABall) {
  const AxialNoise noise;
  for (const double depth_m : {1.0, 2.0, 4.0}) {
    PictureScene scene;  // the far corner, and the floor
    scene.planes.push_back({Vector3d(0.6, 0.0, 0.8), 0.8 * depth_m});
    scene.planes.push_back({Vector3d(-0.6, 0.0, 0.8), 0.8 * depth_m});
    scene.planes.push_back({Vector3d(0.0, -1.0, 0.0), 1.0});
    EXPECT_EQ(found_in(scene, &noise).status, WandStatus::no_wand) << depth_m;
  }
}

TEST(FindWand, SaysWhenTheImageCutsTheBall) {
  for (const Vector3d& centre :
       {point_behind(3, 212, 1.5), point_behind(256, 420, 1.5), point_behind(508, 200, 1.0)})
    EXPECT_EQ(found_in(ball_at(centre)).status, WandStatus::cut_by_edge) << centre.transpose();
}

TEST(FindWand, SaysWhenTheDarkCornerCutsTheBall) {
  DepthPicture picture = picture_of(ball_at(point_behind(256, 212, 1.5)), rays());
  for (int row = 0; row < 424; ++row)
    for (int column = 0; column < 248; ++column) picture.at(column, row) = 0;
  EXPECT_EQ(find_wand(picture.view(), rays(), kOptions).status, WandStatus::cut_by_edge);
}

TEST(FindWand, SaysWhenTheBallIsOutOfRange) {
  EXPECT_EQ(found_in(ball_at({0.0, 0.0, 0.5})).status, WandStatus::out_of_range);
  EXPECT_EQ(found_in(ball_at({0.0, 0.0, 4.8})).status, WandStatus::out_of_range);
  EXPECT_EQ(found_in(ball_at({0.0, 0.0, 0.58})).status, WandStatus::found);
}

TEST(FindWand, ABallOutOfRangeDoesNotHideOneInRange) {
  PictureScene scene = ball_at({0.3, 0.0, 2.0});
  scene.planes.clear();
  scene.balls.push_back({{-0.5, 0.0, 5.0}, kBall_m});
  EXPECT_EQ(found_in(scene).status, WandStatus::found);
}

TEST(FindWand, AnArmBeforeAQuarterOfTheBallDoesNotShiftIt) {
  const AxialNoise noise;
  for (const double depth_m : {1.2, 2.0, 3.0})
    for (const double aside_m : {0.075, 0.08, 0.09}) {
      const Vector3d centre(0.1, 0.1, depth_m);
      PictureScene scene = ball_at(centre);
      const Vector3d arm = centre + Vector3d(aside_m, 0.0, -0.3);
      scene.sticks.push_back({arm - Vector3d(0, 0.4, 0), arm + Vector3d(0, 0.4, 0), 0.04});
      const WandSighting sighting = found_in(scene, &noise);
      ASSERT_EQ(sighting.status, WandStatus::found) << depth_m << " " << aside_m;
      EXPECT_LT(error_m(sighting, centre), 0.0012 * depth_m) << depth_m << " " << aside_m;
    }
}

TEST(FindWand, LostEdgesNeitherHideTheBallNorMakeItLookCut) {
  const AxialNoise noise;
  for (const double depth_m : {1.2, 2.0, 3.0, 4.4})
    for (const double arm_m : {1.0, 0.075}) {  // beside the ball, and before a part of it
      const Vector3d centre(0.05, 0.1, depth_m);
      PictureScene scene = ball_at(centre);
      const Vector3d arm = centre + Vector3d(arm_m, 0.0, -0.2);
      scene.sticks.push_back({arm - Vector3d(0, 0.4, 0), arm + Vector3d(0, 0.4, 0), 0.04});
      const DepthPicture picture = without_most_edges(picture_of(scene, rays(), &noise));
      const WandSighting sighting = find_wand(picture.view(), rays(), kOptions);
      ASSERT_EQ(sighting.status, WandStatus::found) << depth_m << " " << arm_m << name_of(sighting.status);
      EXPECT_LT(error_m(sighting, centre), 0.0012 * depth_m) << depth_m << " " << arm_m;
    }
}

TEST(FindWand, TakesNoHandAtTheEndOfAnArmForABall) {
  const AxialNoise noise;
  for (const double depth_m : {1.0, 2.0, 2.5, 3.0, 4.0}) {
    PictureScene scene;
    const Vector3d hand(-0.3, -0.2, depth_m);
    scene.planes.push_back({Vector3d::UnitZ(), 5.5});
    scene.balls.push_back({hand, 0.05});
    scene.sticks.push_back({hand, hand + Vector3d(0.2, -0.05, 0.05), 0.045});
    const DepthPicture picture = without_most_edges(picture_of(scene, rays(), &noise));
    EXPECT_EQ(find_wand(picture.view(), rays(), kOptions).status, WandStatus::no_wand) << depth_m;
  }
}

TEST(FindWand, ABallMostlyHiddenIsNotTaken) {
  PictureScene scene = ball_at({0.1, 0.1, 2.0});
  scene.sticks.push_back({{0.13, -0.4, 1.7}, {0.13, 0.6, 1.7}, 0.05});
  EXPECT_NE(found_in(scene).status, WandStatus::found);
}

TEST(FindWand, AStickFromAnyDirectionDoesNotShiftTheBall) {
  for (const double depth_m : {0.7, 2.0, 4.2})
    for (int direction = 0; direction < 12; ++direction)
      for (const double towards_sensor : {-0.7, 0.0, 0.7}) {
        const double angle_rad = 2.0 * std::numbers::pi * direction / 12;
        const Vector3d along =
            Vector3d(std::cos(angle_rad), std::sin(angle_rad), -towards_sensor).normalized();
        const Vector3d centre(0.05, -0.05, depth_m);
        PictureScene scene = ball_at(centre);
        const double length_m = towards_sensor > 0.5 ? std::min(1.2, 0.5 * depth_m) : 1.2;
        scene.sticks.push_back({centre + 0.07 * along, centre + length_m * along, 0.01});
        const WandSighting sighting = found_in(scene);
        ASSERT_EQ(sighting.status, WandStatus::found)
            << depth_m << " m, along " << along.transpose() << ": " << name_of(sighting.status);
        EXPECT_LT(error_m(sighting, centre), 0.001) << depth_m << " m, along " << along.transpose();
      }
}

// Where a stick comes out of the ball it is too near the ball's surface to be told from it.
TEST(FindWand, TheFootOfAStickBeforeTheBallDoesNotPullTheCentreTowardsIt) {
  double pull_m = 0.0;
  for (int direction = 0; direction < 24; ++direction) {
    const double angle_rad = 2.0 * std::numbers::pi * direction / 24;
    const Vector3d aside(std::cos(angle_rad), std::sin(angle_rad), 0.0), centre(0.0, 0.0, 2.6);
    const Vector3d along = (aside - Vector3d::UnitZ()).normalized();
    PictureScene scene = ball_at(centre);
    scene.sticks.push_back({centre + 0.07 * along, centre + 1.2 * along, 0.01});
    const WandSighting sighting = found_in(scene);
    ASSERT_EQ(sighting.status, WandStatus::found) << angle_rad;
    pull_m += (sighting.centre_in_sensor_m - centre).dot(aside) / 24.0;
  }
  EXPECT_LT(std::abs(pull_m), 0.00005);
}

TEST(FindWand, ScatteredLostPixelsDoNotHideTheBall) {
  const RandomStream random{3, Purpose::test, 1};
  DepthPicture picture = picture_of(ball_at({0.1, 0.0, 2.0}), rays());
  for (std::size_t i = 0; i < picture.depth_mm.size(); ++i)
    if (random.uniform(static_cast<std::uint32_t>(i)) < 0.02) picture.depth_mm[i] = 0;
  const WandSighting sighting = find_wand(picture.view(), rays(), kOptions);
  ASSERT_EQ(sighting.status, WandStatus::found);
  EXPECT_LT(error_m(sighting, {0.1, 0.0, 2.0}), 2e-4);
}

TEST(FindWand, SeesNothingInImagesWithoutABall) {
  EXPECT_EQ(found_in({}).status, WandStatus::no_wand);
  PictureScene wall;
  wall.planes.push_back({Vector3d(0.1, 0.1, 0.9).normalized(), 2.0});
  const AxialNoise noise;
  const WandSighting sighting = found_in(wall, &noise);
  EXPECT_EQ(sighting.status, WandStatus::no_wand);
  EXPECT_TRUE(std::isnan(sighting.centre_in_sensor_m.x()));
  EXPECT_TRUE(std::isnan(sighting.covariance_m2(0, 0)));
  EXPECT_EQ(sighting.pixels, 0);
}

}  // namespace
}  // namespace trilat
