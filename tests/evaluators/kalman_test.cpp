// SPDX-License-Identifier: MIT
#include "evaluators/fusion/kalman.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "datasets/base/philox.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kSensors = 2;
constexpr double kRate_hz = 30.0;

std::vector<std::int64_t> times(std::size_t instants) {
  std::vector<std::int64_t> time_ns;
  for (std::size_t i = 0; i < instants; ++i)
    time_ns.push_back(std::llround(1e9 * static_cast<double>(i) / kRate_hz));
  return time_ns;
}

// A joint that moves as the model says, and what two sensors see of it.
struct Walk {
  std::vector<Vector3d> truth_m;
  std::vector<JointObservation> seen;
};

Walk random_walk(std::uint64_t seed, std::size_t instants, const KalmanOptions& options) {
  Walk walk;
  Vector3d position = Vector3d::Zero(), velocity = Vector3d::Zero();
  const double step = 1.0 / kRate_hz, q = options.acceleration_density_m2_s3;
  for (std::size_t i = 0; i < instants; ++i) {
    const RandomStream random{seed, Purpose::test, i};
    if (i > 0)
      for (int axis = 0; axis < 3; ++axis) {
        // the exact covariance of the step: q [dt^3/3 dt^2/2; dt^2/2 dt]
        const auto n = random.normal_pair(static_cast<std::uint32_t>(axis));
        const double dv = std::sqrt(q * step) * n[0];
        position[axis] += velocity[axis] * step + 0.5 * step * dv + std::sqrt(q * step / 12.0) * step * n[1];
        velocity[axis] += dv;
      }
    walk.truth_m.push_back(position);
    for (std::size_t s = 0; s < kSensors; ++s) {
      const bool inferred = random.uniform(static_cast<std::uint32_t>(50 + s)) < 0.2;
      const double sigma = options.sigma_m * (inferred ? options.inferred_factor : 1.0);
      Vector3d noise;
      for (int axis = 0; axis < 3; ++axis)
        noise[axis] =
            random.normal(static_cast<std::uint32_t>(100 + 10 * s) + static_cast<std::uint32_t>(axis));
      walk.seen.push_back(
          {true, inferred ? TrackingState::inferred : TrackingState::tracked, position + sigma * noise, 2.0});
    }
  }
  return walk;
}

std::vector<PointEstimate> solve(const std::vector<JointObservation>& seen, const KalmanOptions& options) {
  const auto time_ns = times(seen.size() / kSensors);
  return solve_kalman({time_ns, kSensors,
                       [&](std::size_t instant, std::span<JointObservation> observations) {
                         std::ranges::copy_n(&seen[instant * kSensors], kSensors, observations.begin());
                       }},
                      options);
}
std::vector<PointEstimate> solve(const Walk& walk, const KalmanOptions& options) {
  return solve(walk.seen, options);
}

TEST(Kalman, ErrorsAreAsLargeAsItsCovarianceSays) {
  for (const bool smooth : {false, true}) {
    KalmanOptions options{.smooth = smooth};
    double normalised = 0.0, count = 0.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Walk walk = random_walk(seed, 200, options);
      const auto estimates = solve(walk, options);
      for (std::size_t i = 30; i < 170; ++i) {
        ASSERT_EQ(estimates[i].status, SolveStatus::closed_form);
        normalised +=
            (estimates[i].position_m - walk.truth_m[i]).squaredNorm() / estimates[i].covariance(0, 0);
        count += 3.0;
      }
    }
    EXPECT_NEAR(normalised / count, 1.0, 0.06) << (smooth ? "smoother" : "filter");
  }
}

TEST(Kalman, TheSmootherEqualsTheBatchSolution) {
  // the whole path as one least-squares problem: prior, motion and measurements of one axis
  const KalmanOptions options{.gate_sigma = 1e3, .smooth = true};
  const std::size_t instants = 12;
  const Walk walk = random_walk(3, instants, options);
  const double step = 1.0 / kRate_hz, q = options.acceleration_density_m2_s3;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(2 * instants, 2 * instants);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(2 * instants);
  information(1, 1) = 1.0 / (options.speed_sigma_m_s * options.speed_sigma_m_s);
  Eigen::Matrix2d noise;
  noise << step * step * step / 3, step * step / 2, step * step / 2, step;
  const Eigen::Matrix2d weight = (q * noise).inverse();
  Eigen::Matrix<double, 2, 4> motion;
  motion << -1, -step, 1, 0, 0, -1, 0, 1;
  for (std::size_t i = 0; i + 1 < instants; ++i)
    information.block<4, 4>(static_cast<int>(2 * i), static_cast<int>(2 * i)) +=
        motion.transpose() * weight * motion;
  for (std::size_t i = 0; i < instants; ++i)
    for (std::size_t s = 0; s < kSensors; ++s) {
      const JointObservation& o = walk.seen[i * kSensors + s];
      const double sigma =
          options.sigma_m * (o.state == TrackingState::tracked ? 1.0 : options.inferred_factor);
      const auto row = static_cast<int>(2 * i);
      information(row, row) += 1.0 / (sigma * sigma);
      vector(row) += o.point_in_world_m.y() / (sigma * sigma);
    }
  const Eigen::MatrixXd covariance = information.inverse();
  const Eigen::VectorXd batch = covariance * vector;
  const auto estimates = solve(walk, options);
  for (std::size_t i = 0; i < instants; ++i) {
    const auto row = static_cast<int>(2 * i);
    EXPECT_NEAR(estimates[i].position_m.y(), batch(row), 1e-9) << i;
    EXPECT_NEAR(estimates[i].covariance(1, 1), covariance(row, row), 1e-9) << i;
  }
}

TEST(Kalman, GoesOnThroughShortGapsAndEndsInLongOnes) {
  for (const bool smooth : {false, true}) {
    const KalmanOptions options{.longest_gap_s = 0.2, .smooth = smooth};
    Walk walk = random_walk(4, 60, options);
    const auto hide = [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i)
        for (std::size_t s = 0; s < kSensors; ++s) walk.seen[i * kSensors + s] = {};
    };
    hide(0, 3);
    hide(10, 14);  // 0.13 s
    hide(25, 40);  // 0.5 s
    const auto estimates = solve(walk, options);
    const auto answered = [&](std::size_t i) { return is_usable(estimates[i].status); };
    EXPECT_FALSE(answered(2));
    EXPECT_TRUE(answered(3));
    for (std::size_t i = 10; i < 14; ++i) EXPECT_TRUE(answered(i)) << i;
    EXPECT_EQ(answered(26), !smooth);  // a filter predicts, a smoother ends with the last position
    EXPECT_FALSE(answered(35));
    EXPECT_EQ(estimates[35].status, SolveStatus::no_observation);
    for (std::size_t i = 40; i < 60; ++i) EXPECT_TRUE(answered(i)) << i;
  }
}

TEST(Kalman, ASinglePositionFarOffIsLeftOut) {
  const KalmanOptions options{.smooth = true};
  Walk walk = random_walk(5, 60, options);
  const auto clean = solve(walk, options);
  walk.seen[60].point_in_world_m += Vector3d(0.0, 2.0, 0.0);
  const auto spiked = solve(walk, options);
  EXPECT_LT((clean[30].position_m - spiked[30].position_m).norm(), 0.02);
}

// The gate stands where it says: just inside a position counts, just outside it is as if it had not been
// seen.
TEST(Kalman, TheGateIsAsUnlikelyAsSoManyStandardDeviations) {
  const KalmanOptions options;
  constexpr std::size_t kLast = 79;
  const double step = 1.0 / kRate_hz, r = options.sigma_m * options.sigma_m;
  Eigen::Matrix2d p = Eigen::Matrix2d::Identity(), f, q;
  f << 1.0, step, 0.0, 1.0;
  q << step * step * step / 3.0, step * step / 2.0, step * step / 2.0, step;
  double predicted_variance = 0.0;  // of the settled filter
  for (std::size_t i = 0; i < kLast; ++i) {
    p = f * p * f.transpose() + options.acceleration_density_m2_s3 * q;
    predicted_variance = p(0, 0);
    for (std::size_t s = 0; s < kSensors; ++s) {
      const Eigen::Vector2d gain = p.col(0) / (p(0, 0) + r);
      p -= (gain * p.row(0)).eval();
    }
  }
  // of three normal numbers: Q(x) = erfc(sqrt(x / 2)) + sqrt(2 x / pi) exp(-x / 2)
  double low = 25.0, high = 75.0;
  for (int k = 0; k < 60; ++k) {
    const double x = 0.5 * (low + high);
    const double beyond =
        std::erfc(std::sqrt(0.5 * x)) + std::sqrt(2.0 * x / std::numbers::pi) * std::exp(-0.5 * x);
    (beyond > std::erfc(options.gate_sigma / std::sqrt(2.0)) ? low : high) = x;
  }
  const double gate_m = std::sqrt(low * (predicted_variance + r));
  Walk walk = random_walk(7, kLast + 1, options);
  for (std::size_t i = 0; i <= kLast; ++i)  // at rest, so that the prediction is where it is
    for (std::size_t s = 0; s < kSensors; ++s) walk.seen[i * kSensors + s].point_in_world_m.setZero();
  Walk unseen = walk;
  unseen.seen[kLast * kSensors].seen = false;
  const Vector3d without_m = solve(unseen, options)[kLast].position_m;
  const auto with_m = [&](double distance_m) {
    walk.seen[kLast * kSensors].point_in_world_m = Vector3d(0.0, distance_m, 0.0);
    return solve(walk, options)[kLast].position_m;
  };
  EXPECT_GT(with_m(0.99 * gate_m).y(), 0.1 * gate_m);
  EXPECT_EQ(with_m(1.01 * gate_m), without_m);
}

TEST(Kalman, APersonWhoIsSuddenlyElsewhereIsFollowedAfterTheGap) {
  const KalmanOptions options{.longest_gap_s = 0.2};
  Walk walk = random_walk(6, 60, options);
  for (std::size_t i = 30; i < 60; ++i)
    for (std::size_t s = 0; s < kSensors; ++s)
      walk.seen[i * kSensors + s].point_in_world_m += Vector3d(5.0, 0.0, 0.0);
  const auto estimates = solve(walk, options);
  EXPECT_LT((estimates[45].position_m - walk.truth_m[45] - Vector3d(5.0, 0.0, 0.0)).norm(), 0.2);
}

TEST(Kalman, WithoutAnyObservationThereIsNoPath) {
  const auto estimates = solve(std::vector<JointObservation>(20 * kSensors), {});
  EXPECT_EQ(estimates.size(), 20u);
  for (const PointEstimate& estimate : estimates) EXPECT_EQ(estimate.status, SolveStatus::no_observation);
}

}  // namespace
}  // namespace trilat
