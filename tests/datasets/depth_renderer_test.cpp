// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/depth_renderer.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <hwy/highway.h>

#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/wand_motion.h"
#include "tests/support/plain_depth_renderer.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kPixels = 512 * 424;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const RigidTransform kHere;  // the sensor's frame is the world's

RandomStream key_of(std::uint64_t frame) { return {7, Purpose::depth_pixel, random_item(0, 0, 0, frame)}; }

std::size_t at(int column, int row) {
  return static_cast<std::size_t>(row) * 512 + static_cast<std::size_t>(column);
}

std::vector<std::uint16_t> rendered(const DepthRenderer& renderer, const DepthScene& scene,
                                    std::uint64_t frame = 0, const RigidTransform& pose = kHere) {
  std::vector<std::uint16_t> image(kPixels, 7);
  renderer.render(scene, pose, key_of(frame), image);
  return image;
}

std::vector<float> exact(const DepthScene& scene, const RigidTransform& pose = kHere) {
  std::vector<float> image(kPixels);
  DepthRenderer({}, noise_free_depth(), {}).render_exact(scene, pose, image);
  return image;
}

// A plane at z = depth that faces the sensor, turned about the vertical by `angle_rad`.
ScenePlane facing_plane(double depth_m, double angle_rad = 0.0) {
  const Vector3d normal(std::sin(angle_rad), 0.0, -std::cos(angle_rad));
  return {normal, normal.z() * depth_m};
}

// Somebody with a wand in a room, and a sensor that sees them.
struct Lab {
  DepthScene scene;
  RigidTransform pose = world_from_sensor_looking_at({1.4, 0.6, 1.4}, {0.0, 1.0, 0.0});
  DepthUnit unit{0.012, 0.004, 1.3, 2.0};

  Lab() {
    const WandInstant instant = WandMotion({}, 1, {0.0, 1.0, 0.0}, Person{}).at(7.0);
    append_room(scene, {}, {0.0, 1.0, 0.0});
    append_person(scene, instant.person);
    append_wand(scene, instant.ball_in_world_m, instant.stick_direction, {});
  }
};

struct Moments {
  double n = 0.0, sum = 0.0, squares = 0.0;
  void add(double value) {
    n += 1.0;
    sum += value;
    squares += value * value;
  }
  double mean() const { return sum / n; }
  double sigma() const { return std::sqrt(squares / n - mean() * mean()); }
};

TEST(DepthRenderer, APlaneAcrossTheAxisHasItsDepthInEveryPixel) {
  const DepthScene scene{{facing_plane(2.345)}, {}, {}};
  for (const std::uint16_t mm : rendered({{}, noise_free_depth(), {}}, scene)) ASSERT_EQ(mm, 2345);
  for (const float m : exact(scene)) ASSERT_NEAR(m, 2.345, 1e-6);
}

TEST(DepthRenderer, ATiltedPlaneIsMetByThePixelsUndistortedRay) {
  const double angle = 0.5;
  const auto depth_m = exact({{facing_plane(2.0, angle)}, {}, {}});
  for (const auto& [column, row] : {std::pair{10, 20}, {255, 205}, {500, 30}, {40, 400}, {480, 410}}) {
    const Eigen::Vector2d ray = *ray_through({}, Eigen::Vector2d(column, row));
    // sin(a) x z - cos(a) z = -2 cos(a)
    const double expected = 2.0 * std::cos(angle) / (std::cos(angle) - std::sin(angle) * ray.x());
    EXPECT_NEAR(depth_m[at(column, row)], expected, 2e-6) << column << " " << row;
  }
}

TEST(DepthRenderer, APlaneIsSeenFromItsFrontOnly) {
  ScenePlane turned = facing_plane(2.0);
  turned.normal = -turned.normal;
  turned.offset_m = -turned.offset_m;
  for (const float m : exact({{turned}, {}, {}})) ASSERT_TRUE(std::isnan(m));
  for (const std::uint16_t mm : rendered({{}, {}, {}}, {{turned}, {}, {}})) ASSERT_EQ(mm, 0);
}

TEST(DepthRenderer, TheRayAtASpheresCentreMeetsItItsRadiusBefore) {
  for (const auto& [column, row] : {std::pair{255, 205}, {60, 100}, {430, 330}}) {
    const Eigen::Vector2d ray = *ray_through({}, Eigen::Vector2d(column, row));
    const Vector3d direction = Vector3d(ray.x(), ray.y(), 1.0).normalized();
    const auto depth_m = exact({{}, {{2.5 * direction, 0.075}}, {}});
    EXPECT_NEAR(depth_m[at(column, row)], (2.5 - 0.075) * direction.z(), 1e-5);
    EXPECT_TRUE(std::isnan(depth_m[at(column + 20, row)]));  // 0.137 m aside
    EXPECT_FALSE(std::isnan(depth_m[at(column + 8, row)]));
  }
}

TEST(DepthRenderer, ACapsuleHasASideTwoRoundEndsAndNoMore) {
  const auto ray_at = [](const Vector3d& p) {
    const Eigen::Vector2d px = *project({}, p);
    return at(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
  };
  const auto depth_m = exact({{}, {}, {{{-0.3, 0.0, 2.0}, {0.3, 0.0, 2.0}, 0.1}}});
  EXPECT_NEAR(depth_m[ray_at({0.0, 0.0, 2.0})], 1.9, 1e-4);
  EXPECT_NEAR(depth_m[ray_at({0.25, 0.0, 2.0})], 1.9, 1e-3);
  EXPECT_GT(depth_m[ray_at({0.35, 0.0, 2.0})], 1.9f);  // on the round end
  EXPECT_LT(depth_m[ray_at({0.35, 0.0, 2.0})], 2.0f);
  EXPECT_TRUE(std::isnan(depth_m[ray_at({0.42, 0.0, 2.0})]));
  EXPECT_TRUE(std::isnan(depth_m[ray_at({0.0, 0.12, 2.0})]));
  // seen from its end, and one without length
  EXPECT_NEAR(exact({{}, {}, {{{0.0, 0.0, 3.0}, {0.0, 0.0, 2.0}, 0.1}}})[at(255, 205)], 1.9, 1e-4);
  EXPECT_NEAR(exact({{}, {}, {{{0.0, 0.0, 2.0}, {0.0, 0.0, 2.0}, 0.1}}})[at(255, 205)], 1.9, 1e-4);
}

TEST(DepthRenderer, TheNearestSurfaceIsSeenAndNothingBehindTheLens) {
  const DepthScene scene{{facing_plane(3.0)},
                         {{{0.0, 0.0, 2.0}, 0.2}, {{0.0, 0.0, 2.5}, 0.2}, {{0.0, 0.0, -1.0}, 0.2}},
                         {{{0.0, -1.0, -1.0}, {0.0, 1.0, -1.0}, 0.2}}};
  const auto depth_m = exact(scene);
  EXPECT_NEAR(depth_m[at(255, 205)], 1.8, 1e-4);
  EXPECT_NEAR(depth_m[at(20, 205)], 3.0, 1e-5);
}

// Double precision, every ray against every surface: any object that a box cuts off would show, here in all
// pixels of a jittered image.
TEST(DepthRenderer, JitteredRaysMeetWhatEveryRayAgainstEverySurfaceMeets) {
  const Lab lab;
  DepthNoiseSpec noise = noise_free_depth();
  noise.lateral_sigma_m = 0.005;
  DepthScene scene = lab.scene;
  scene.spheres.push_back({lab.pose * Vector3d(-0.5, 0.3, 0.9), 0.3});  // large, near and in the corner
  scene.capsules.push_back({lab.pose * Vector3d(0.2, 0.2, -0.5), lab.pose * Vector3d(0.9, 0.5, 2.0), 0.05});
  // along the image's sides, where a box fits tightly
  scene.capsules.push_back({lab.pose * Vector3d(0.1, -0.4, 1.0), lab.pose * Vector3d(0.1, 0.4, 1.0), 0.03});
  scene.capsules.push_back({lab.pose * Vector3d(-0.5, 0.1, 1.0), lab.pose * Vector3d(0.5, 0.1, 1.0), 0.03});
  const auto ours = rendered({{}, noise, lab.unit}, scene, 3, lab.pose);
  const auto plain = PlainDepthRenderer({}, noise, lab.unit).render(scene, lab.pose, key_of(3));
  std::size_t differing = 0, seen = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    differing += std::abs(int{ours[i]} - int{plain[i]}) > 1;
    seen += plain[i] != 0;
  }
  EXPECT_LE(differing, 5u);  // rays that touch a rim, where single precision may miss
  EXPECT_GT(seen, kPixels / 2);
}

TEST(DepthRenderer, AllTheNoiseTogetherIsThatOfThePlainRenderer) {
  const Lab lab;
  const auto ours = rendered({{}, {}, lab.unit}, lab.scene, 11, lab.pose);
  const auto plain = PlainDepthRenderer({}, {}, lab.unit).render(lab.scene, lab.pose, key_of(11));
  std::size_t differing = 0, lost = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    differing += std::abs(int{ours[i]} - int{plain[i]}) > 1;
    lost += plain[i] == 0;
  }
  EXPECT_LE(differing, 10u);
  EXPECT_GT(lost, 1000u);
  EXPECT_LT(lost, kPixels / 2);
}

// A plane across the view; its depth noise in a pixel over many frames.
Moments noise_at(const DepthNoiseSpec& noise, double depth_m, double angle_rad, int column, int row) {
  const DepthRenderer renderer({}, noise, {});
  Moments moments;
  for (std::uint64_t frame = 0; frame < 40; ++frame) {
    const auto image = rendered(renderer, {{facing_plane(depth_m, angle_rad)}, {}, {}}, frame);
    for (int r = row - 4; r <= row + 4; ++r)
      for (int c = column - 4; c <= column + 4; ++c) {
        const Eigen::Vector2d ray = *ray_through({}, Eigen::Vector2d(c, r));
        const double expected =
            depth_m * std::cos(angle_rad) / (std::cos(angle_rad) - std::sin(angle_rad) * ray.x());
        moments.add(1e-3 * image[at(c, r)] - expected);
      }
  }
  return moments;
}

TEST(DepthRenderer, TheAxialNoiseIsThatOfTheFormulaAndGrowsTowardsTheCorner) {
  DepthNoiseSpec noise = noise_free_depth();
  noise.axial = {};
  constexpr double kRounding_m2 = 1e-6 / 12.0;
  for (const double depth_m : {1.0, 2.0, 4.0}) {
    const Moments m = noise_at(noise, depth_m, 0.0, 255, 205);
    const double sigma_m = std::hypot(noise.axial.sigma_m(depth_m, 0.0), std::sqrt(kRounding_m2));
    EXPECT_NEAR(m.sigma(), sigma_m, 0.05 * sigma_m) << depth_m;
    EXPECT_NEAR(m.mean(), 0.0, 5.0 * sigma_m / std::sqrt(m.n)) << depth_m;
  }
  // 60 degrees: 0.1 z^1.5 (60 / 30)^2 = 1.13 mm more than 1.7 mm
  const Moments tilted = noise_at(noise, 2.0, std::numbers::pi / 3.0, 255, 205);
  const double tilted_m =
      std::hypot(noise.axial.sigma_m(2.0, std::numbers::pi / 3.0), std::sqrt(kRounding_m2));
  EXPECT_NEAR(tilted_m, 0.00285, 1e-4);
  EXPECT_NEAR(tilted.sigma(), tilted_m, 0.05 * tilted_m);
  noise.corner_noise_factor = 3.0;
  const Moments corner = noise_at(noise, 2.0, 0.0, 505, 417);
  const double angle = std::atan(ray_through({}, Eigen::Vector2d(505, 417))->norm());
  EXPECT_GT(corner.sigma(), 2.4 * noise.axial.sigma_m(2.0, angle));
  EXPECT_LT(corner.sigma(), 3.1 * noise.axial.sigma_m(2.0, angle));
}

// The depth of a plane tilted by 60 degrees changes by z tan(60) for the tangent of the ray: sideways jitter
// of 1.6 mm gives 1.6 tan(60) mm.
TEST(DepthRenderer, LateralJitterMovesTheRayAtTheSurface) {
  DepthNoiseSpec noise = noise_free_depth();
  noise.lateral_sigma_m = 0.0016;
  for (const double depth_m : {1.0, 3.0})
    EXPECT_NEAR(noise_at(noise, depth_m, std::numbers::pi / 3.0, 255, 205).sigma(),
                0.0016 * std::tan(std::numbers::pi / 3.0), 1.2e-4);
}

TEST(DepthRenderer, AUnitHasItsOffsetAndWiggle) {
  const DepthUnit unit{0.020, 0.004, 1.5, 0.7};
  const DepthRenderer renderer({}, noise_free_depth(), unit);
  for (double depth_m = 0.6; depth_m < 6.0; depth_m += 0.17) {
    const double expected_m =
        depth_m + 0.020 + 0.004 * std::sin(2.0 * std::numbers::pi * depth_m / 1.5 + 0.7);
    EXPECT_NEAR(rendered(renderer, {{facing_plane(depth_m)}, {}, {}})[at(300, 100)], 1e3 * expected_m, 0.51);
  }
}

TEST(DepthRenderer, UnitsAreDrawnWithinTheDeclaredLimits) {
  const DepthNoiseSpec spec;
  Moments offset;
  std::array<double, 3>
      shares{};  // of units in which two of amplitude, length and phase lie both high or low
  for (std::uint64_t sensor = 0; sensor < 1000; ++sensor) {
    const DepthUnit unit = draw_depth_unit(spec, 3, sensor);
    const std::array above{unit.wiggle_amplitude_m > 0.0035, unit.wiggle_length_m > 1.3,
                           unit.wiggle_phase_rad > std::numbers::pi};
    for (std::size_t k = 0; k < 3; ++k) shares[k] += above[k] == above[(k + 1) % 3] ? 1e-3 : 0.0;
    EXPECT_LE(std::abs(unit.offset_m), 0.024);
    EXPECT_GE(unit.wiggle_amplitude_m, 0.002);
    EXPECT_LE(unit.wiggle_amplitude_m, 0.005);
    EXPECT_GE(unit.wiggle_length_m, 0.6);
    EXPECT_LE(unit.wiggle_length_m, 2.0);
    offset.add(unit.offset_m);
  }
  EXPECT_NEAR(offset.sigma(), 0.024 / std::sqrt(3.0), 0.001);
  for (const double share : shares)
    EXPECT_NEAR(share, 0.5, 0.06) << "amplitude, length and phase are drawn each by itself";
  EXPECT_NE(draw_depth_unit(spec, 3, 1).offset_m, draw_depth_unit(spec, 4, 1).offset_m);
}

// A ball before a wall: its rim pixels and the wall's beside them.
TEST(DepthRenderer, FourFifthsOfEdgePixelsAreLostAndTheOthersLieBetweenBothSurfaces) {
  DepthNoiseSpec noise = noise_free_depth();
  noise.edge_step_m = 0.05;
  noise.edge_dropped_share = 0.8;
  const DepthScene scene{{facing_plane(3.0)}, {{{0.0, 0.0, 2.0}, 0.4}}, {}};
  const auto exact_m = exact(scene);
  const DepthRenderer renderer({}, noise, {});
  double edges = 0.0, lost = 0.0;
  Moments place;
  for (std::uint64_t frame = 0; frame < 20; ++frame) {
    const auto image = rendered(renderer, scene, frame);
    for (int r = 1; r < 423; ++r)
      for (int c = 1; c < 511; ++c) {
        const float own = exact_m[at(c, r)];
        const bool edge =
            std::abs(exact_m[at(c - 1, r)] - own) > 0.05f || std::abs(exact_m[at(c + 1, r)] - own) > 0.05f ||
            std::abs(exact_m[at(c, r - 1)] - own) > 0.05f || std::abs(exact_m[at(c, r + 1)] - own) > 0.05f;
        const std::uint16_t mm = image[at(c, r)];
        if (!edge) {
          ASSERT_NEAR(mm, 1e3f * own, 0.51) << c << " " << r;
          continue;
        }
        edges += 1.0;
        lost += mm == 0;
        if (mm == 0) continue;
        ASSERT_GT(mm, 1600);
        ASSERT_LE(mm, 3000);
        if (own > 2.9f) place.add(1e-3 * mm);
      }
  }
  EXPECT_GT(edges, 5000.0);
  EXPECT_NEAR(lost / edges, 0.8, 4.0 * std::sqrt(0.8 * 0.2 / edges));
  EXPECT_NEAR(place.mean(), 2.45, 0.06);  // between 3.0 and some 1.9 m
}

TEST(DepthRenderer, TheDarkCornersAreInvalidAndNothingElse) {
  DepthNoiseSpec noise = noise_free_depth();
  noise.valid_radius = 0.84;
  const auto image = rendered({{}, noise, {}}, {{facing_plane(2.0)}, {}, {}});
  for (int r = 0; r < 424; ++r)
    for (int c = 0; c < 512; ++c) {
      const double radius = ray_through({}, Eigen::Vector2d(c, r))->norm();
      if (std::abs(radius - 0.84) > 1e-6) {
        ASSERT_EQ(image[at(c, r)], radius < 0.84 ? 2000 : 0) << c << " " << r;
      }
    }
  EXPECT_EQ(image[at(511, 423)], 0);
}

TEST(DepthRenderer, WhatGrazesOrIsOutOfRangeIsInvalid) {
  DepthNoiseSpec noise = noise_free_depth();
  noise.grazing_limit_rad = 75.0 * std::numbers::pi / 180.0;
  const auto centre = [&](double depth_m, double angle_deg) {
    const double angle = angle_deg * std::numbers::pi / 180.0;
    return rendered({{}, noise, {}}, {{facing_plane(depth_m, angle)}, {}, {}})[at(255, 205)];
  };
  EXPECT_NEAR(centre(2.0, 74.5), 2000, 2);
  EXPECT_EQ(centre(2.0, 75.5), 0);
  noise.nearest_m = 0.5;
  noise.farthest_m = 4.5;
  EXPECT_EQ(centre(0.499, 0.0), 0);
  EXPECT_EQ(centre(0.501, 0.0), 501);
  EXPECT_EQ(centre(4.499, 0.0), 4499);
  EXPECT_EQ(centre(4.501, 0.0), 0);
}

TEST(DepthRenderer, AFrameIsAFunctionOfItsKeyInAnyOrder) {
  const Lab lab;
  const DepthRenderer renderer({}, {}, lab.unit);
  const auto third = rendered(renderer, lab.scene, 3, lab.pose);
  const auto fourth = rendered(renderer, lab.scene, 4, lab.pose);
  EXPECT_EQ(rendered(renderer, lab.scene, 3, lab.pose), third);
  EXPECT_NE(fourth, third);
  EXPECT_EQ(rendered(DepthRenderer({}, {}, lab.unit), lab.scene, 4, lab.pose), fourth);
}

// 0 stands for plain C++, without vectors.
TEST(DepthRenderer, EveryInstructionSetGivesTheSameBits) {
  const Lab lab;
  const DepthRenderer renderer({}, {}, lab.unit);
  const auto widest = rendered(renderer, lab.scene, 3, lab.pose);
  for (const std::int64_t target :
       {std::int64_t{0}, std::int64_t{HWY_SSE4}, std::int64_t{HWY_AVX2}, std::int64_t{HWY_AVX3}}) {
    if (target != 0 && (hwy::SupportedTargets() & target) == 0) continue;
    hwy::GetChosenTarget().Update(target);
    const auto narrow = rendered(renderer, lab.scene, 3, lab.pose);
    hwy::GetChosenTarget().DeInit();
    EXPECT_EQ(narrow, widest) << target;
  }
}

TEST(DepthRenderer, AnImageOfAnyWidthIsWhole) {
  DepthIntrinsics small;
  small.width_px = 53;
  small.height_px = 19;
  small.fx_px = small.fy_px = 60.0;
  small.cx_px = 25.0;
  small.cy_px = 9.0;
  std::vector<std::uint16_t> image(53 * 19);
  DepthRenderer(small, noise_free_depth(), {})
      .render({{facing_plane(1.25)}, {}, {}}, kHere, key_of(0), image);
  ASSERT_FALSE(image.empty());
  for (const std::uint16_t mm : image) EXPECT_EQ(mm, 1250);
}

TEST(RoomScene, ARoomSurroundsTheSensorsAndAPersonIsAsBigAsAPerson) {
  DepthScene room;
  append_room(room, {3.0, 2.5, 4}, {0.5, 1.0, -0.5});
  ASSERT_EQ(room.planes.size(), 5u);
  const Vector3d inside(0.5, 1.0, -0.5);
  const double expected_m[] = {1.0, 2.5, 3.0, 3.0, 2.5};
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(room.planes[i].normal.dot(inside) - room.planes[i].offset_m, expected_m[i], 1e-12);
  DepthScene scene;
  const SkeletonPose pose = generated_motion(Person{}, Activity::standing)(0.0);
  append_person(scene, pose);
  EXPECT_EQ(scene.capsules.size(), 24u);
  ASSERT_EQ(scene.spheres.size(), 1u);
  EXPECT_EQ(scene.spheres[0].radius_m, 0.10);
  EXPECT_EQ(scene.spheres[0].centre_m, pose.at(Joint::head));
  for (const SceneCapsule& capsule : scene.capsules) {
    EXPECT_GE(capsule.radius_m, 0.02);
    EXPECT_LE(capsule.radius_m, 0.15);
  }
  DepthScene nobody;
  append_person(nobody, SkeletonPose{});
  EXPECT_TRUE(nobody.capsules.empty() && nobody.spheres.empty());
}

}  // namespace
}  // namespace trilat
