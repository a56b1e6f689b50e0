// SPDX-License-Identifier: MIT
#include <numbers>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/rig/depth_camera.h"
#include "datasets/rig/rigid_transform.h"

namespace trilat {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTight = 1e-12;

TEST(RigidTransform, ComposesAndInverts) {
  const RigidTransform b_from_a{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized())),
                                {1, 2, 3}};
  const RigidTransform c_from_b{Eigen::Quaterniond(Eigen::AngleAxisd(-1.1, Vector3d::UnitX())), {0, -1, 4}};
  const Vector3d p(0.5, -0.25, 2.0);
  EXPECT_LT(((c_from_b * b_from_a) * p - c_from_b * (b_from_a * p)).norm(), kTight);
  EXPECT_LT((b_from_a.inverse() * (b_from_a * p) - p).norm(), kTight);
}

// A sensor in front of the world's origin, on the +z side, looking back at it: its left is the world's -x.
TEST(Frames, AVerticalViewIsRefused) {
  EXPECT_THROW(world_from_sensor_looking_at({0, 2, 0}, {0, 0, 0}), InternalError);
}

TEST(Frames, ImageColumnsGrowWithSensorXAndRowsAgainstY) {
  const DepthIntrinsics in;
  const Vector2d centre = *project(in, {0, 0, 2});
  EXPECT_NEAR(centre.x(), in.cx_px, kTight);
  EXPECT_NEAR(centre.y(), in.cy_px, kTight);
  EXPECT_GT(project(in, {0.1, 0, 2})->x(), centre.x());
  EXPECT_LT(project(in, {0, 0.1, 2})->y(), centre.y());
}

TEST(DepthCamera, WithoutDistortionIsThePinholeFormula) {
  DepthIntrinsics in;
  in.k1 = in.k2 = in.k3 = 0.0;
  const Vector2d pixel = *project(in, {0.5, -0.25, 2.0});
  EXPECT_NEAR(pixel.x(), 254.878 + 365.456 * 0.25, kTight);
  EXPECT_NEAR(pixel.y(), 205.395 + 365.456 * 0.125, kTight);
}

TEST(DepthCamera, AFocalLengthThatNoKinectHasIsDoubted) {
  const auto doubt = [](double fx_px, double fy_px, int width_px = 512) {
    DepthIntrinsics in;
    in.width_px = width_px;
    in.fx_px = fx_px;
    in.fy_px = fy_px;
    return doubt_about(in).value_or("");
  };
  EXPECT_EQ(doubt(365.456, 365.456), "");
  EXPECT_EQ(doubt(341.0, 389.0), "");
  EXPECT_EQ(
      doubt(1081.37, 1081.37),
      "has a focal length of 1081 px, where depth cameras of a Kinect v2 have about 365: it is that of its "
      "colour camera");
  EXPECT_EQ(doubt(339.0, 365.0),
            "has a focal length of 339 px, where depth cameras of a Kinect v2 have about 365");
  EXPECT_EQ(doubt(365.0, 391.0),
            "has a focal length of 391 px, where depth cameras of a Kinect v2 have about 365");
  EXPECT_EQ(doubt(504.0, 504.0, 640), "");
}

TEST(DepthCamera, IsBelievedToTheLimitsThatAreStated) {
  DepthIntrinsics in;
  for (const double widths : {0.3, 3.0}) {
    in.fx_px = in.fy_px = widths * in.width_px;
    EXPECT_EQ(problem_with(in), "");
    in.fx_px *= widths < 1.0 ? 0.999 : 1.001;
    EXPECT_EQ(problem_with(in), "has a focal length outside 0.3 to 3 image widths");
  }
}

TEST(DepthCamera, ImagesHaveSixteenTo8192PixelsASide) {
  const auto problem = [](int width_px, int height_px) {
    DepthIntrinsics in;
    in.width_px = width_px, in.height_px = height_px;
    in.fx_px = in.fy_px = width_px, in.cx_px = 0.5 * width_px, in.cy_px = 0.5 * height_px;
    return problem_with(in);
  };
  for (const int size_px : {16, 8192}) {
    EXPECT_EQ(problem(size_px, 424), "");
    EXPECT_EQ(problem(512, size_px), "");
  }
  for (const int size_px : {15, 8193}) {
    EXPECT_EQ(problem(size_px, 424), "has an image size outside 16 to 8192 pixels");
    EXPECT_EQ(problem(512, size_px), "has an image size outside 16 to 8192 pixels");
  }
}

TEST(DepthCamera, RayUndoesProjectionAllOverTheImage) {
  DepthIntrinsics in;
  in.p1 = 1e-3;
  in.p2 = -7e-4;
  for (int u = 0; u < in.width_px; u += 17) {
    for (int v = 0; v < in.height_px; v += 13) {
      const auto ray = ray_through(in, Vector2d(u, v));
      // the typical lens model folds in the extreme corners, where a Kinect sees nothing
      const double radius = std::hypot((u - in.cx_px) / in.fx_px, (v - in.cy_px) / in.fy_px);
      if (!ray) {
        EXPECT_GT(radius, 0.85);
        continue;
      }
      const auto pixel = project(in, Vector3d(2 * ray->x(), 2 * ray->y(), 2));
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - Vector2d(u, v)).norm(), 1e-9);
    }
  }
}

TEST(DepthCamera, APointBehindTheLensHasNoPixel) {
  EXPECT_FALSE(project(DepthIntrinsics{}, {0, 0, 0}));
  EXPECT_FALSE(project(DepthIntrinsics{}, {0, 0, -1}));
  EXPECT_FALSE(project(DepthIntrinsics{}, {9, 0, 1}));
}

// Erratum E2: at 2 m the printed model differs from a pinhole of the same 70 degree field by up to 7.6 cm.
TEST(DepthCamera, PrintedAnglesAreUpToSevenCentimetresOffAPinhole) {
  EXPECT_NEAR(printed_linear_angle_point({256, 212}, 2.0).norm(), 2.0, kTight);
  const double edge = std::tan(35.0 * std::numbers::pi / 180.0);
  double worst = 0.0;
  for (int u = 0; u <= 512; ++u) {
    const double pinhole = 2.0 * edge * (u - 256.0) / 256.0;
    worst = std::max(worst, std::abs(printed_linear_angle_point({u, 212.0}, 2.0).x() - pinhole));
  }
  EXPECT_NEAR(worst, 0.0725, 0.0001);
}

TEST(DepthCamera, ImplausibleIntrinsicsAreSaidToBeSo) {
  DepthIntrinsics in;
  EXPECT_EQ(problem_with(in), "");
  in.fx_px = 0.36;
  EXPECT_THAT(problem_with(in), testing::HasSubstr("focal"));
  in = {};
  in.k2 = kNaN;
  EXPECT_THAT(problem_with(in), testing::HasSubstr("finite"));
  in = {};
  in.cx_px = 500;
  EXPECT_THAT(problem_with(in), testing::HasSubstr("principal"));
}

}  // namespace
}  // namespace trilat
