// SPDX-License-Identifier: MIT
#include "evaluators/metrics/body_metrics.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> body() {
  return {{0.0, 1.7, 0.1}, {-0.2, 1.4, 0.0}, {0.2, 1.4, 0.0}, {-0.3, 1.1, 0.1}, {0.3, 1.1, -0.1}};
}

double pa_mpjpe_m(const std::vector<Vector3d>& estimate_m, const std::vector<Vector3d>& truth_m) {
  return ProcrustesTruth(truth_m).pa_mpjpe_m(estimate_m);
}

TEST(BodyMetrics, PaMpjpeForgivesRotationTranslationAndScaleAndNothingElse) {
  const std::vector<Vector3d> truth = body();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.5, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vector3d> estimate, mirrored;
  for (const Vector3d& t : truth) {
    estimate.push_back(1.3 * (turn * t) + Vector3d(4, 5, 6));
    mirrored.push_back({-t.x(), t.y(), t.z()});
  }
  EXPECT_NEAR(pa_mpjpe_m(estimate, truth), 0.0, 1e-12);
  EXPECT_GT(pa_mpjpe_m(mirrored, truth), 0.01);
  estimate[3] += Vector3d(0, 0.1, 0);
  EXPECT_GT(pa_mpjpe_m(estimate, truth), 0.01);
}

// Umeyama's by singular values; from bodies of full rank to flat and mirrored ones.
TEST(BodyMetrics, PaMpjpeIsThatOfUmeyama) {
  const RandomStream random{41, Purpose::test, 0};
  std::uint32_t draw = 0;
  const auto somewhere = [&](const Vector3d& size) {
    Vector3d point;
    for (int axis = 0; axis < 3; ++axis) point[axis] = random.uniform(draw++, -size[axis], size[axis]);
    return point;
  };
  for (int trial = 0; trial < 400; ++trial) {
    const double depth = trial % 4 == 0 ? 0.0 : std::pow(10.0, -(trial % 10));
    const double noise = trial % 3 == 0 ? 0.5 : 0.02, mirror = trial % 5 == 0 ? -1.0 : 1.0;
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.01 * trial, somewhere(Vector3d::Ones()).normalized()).toRotationMatrix();
    Eigen::Matrix3Xd truth(3, 9), estimate(3, 9);
    std::vector<Vector3d> truths, estimates;
    for (int j = 0; j < 9; ++j) {
      truth.col(j) = somewhere({0.4, 0.9, depth});
      const Vector3d hand(mirror * truth(0, j), truth(1, j), truth(2, j));
      estimate.col(j) = turn * (hand + somewhere({noise, noise, noise * depth})) + Vector3d(1, 2, 3);
      truths.push_back(truth.col(j));
      estimates.push_back(estimate.col(j));
    }
    const Eigen::Matrix4d best = Eigen::umeyama(estimate, truth);
    const Eigen::Matrix3Xd laid =
        (best.topLeftCorner<3, 3>() * estimate).colwise() + best.topRightCorner<3, 1>();
    EXPECT_NEAR(pa_mpjpe_m(estimates, truths), (laid - truth).colwise().norm().mean(), 1e-9) << trial;
  }
}

TEST(BodyMetrics, PaMpjpeOfASmallerTriangleIsNothing) {
  const double h = std::sqrt(3.0) / 2.0;
  const std::vector<Vector3d> truth{{0, 0, 0}, {1, 0, 0}, {0.5, h, 0}};
  const std::vector<Vector3d> estimate{{0, 0, 0}, {0.5, 0, 0}, {0.25, h / 2.0, 0}};
  EXPECT_NEAR(pa_mpjpe_m(estimate, truth), 0.0, 1e-12);
}

TEST(BodyMetrics, PaMpjpeNeedsThreeJointsThatAreNotOnALine) {
  const std::vector<Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  const std::vector<Vector3d> plane{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  EXPECT_TRUE(std::isnan(pa_mpjpe_m(line, plane)));
  EXPECT_TRUE(std::isnan(pa_mpjpe_m(plane, line)));
  EXPECT_NEAR(pa_mpjpe_m(plane, plane), 0.0, 1e-12);
  EXPECT_TRUE(std::isnan(pa_mpjpe_m({plane[0], plane[1]}, {plane[0], plane[1]})));
  const std::vector<Vector3d> point(4, Vector3d(1, 2, 3));
  EXPECT_TRUE(std::isnan(pa_mpjpe_m(point, plane)));
}

TEST(BodyMetrics, LengthSpreadByPencil) {
  LengthSpread spread;
  EXPECT_TRUE(std::isnan(spread.standard_deviation_m()));
  spread.add(0.30);
  EXPECT_TRUE(std::isnan(spread.standard_deviation_m()));
  spread.add(0.32);
  spread.add(0.34);
  EXPECT_NEAR(spread.standard_deviation_m(), 0.02, 1e-15);
}

TEST(BodyMetrics, JerkOfACubicIsSixTimesItsCoefficient) {
  const double rate_hz = 30.0;
  const auto at = [&](int i) {
    const double t = i / rate_hz;
    return Vector3d(2.0 * t * t * t + t * t, 1.0 - t, 4.0);
  };
  EXPECT_NEAR(jerk_m_s3(at(0), at(1), at(2), at(3), rate_hz), 12.0, 1e-9);
}

}  // namespace
}  // namespace trilat
