// SPDX-License-Identifier: MIT
#include "evaluators/fusion/bone_smoother.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <iterator>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "evaluators/fusion/kalman.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kSceneSensors = 2;
constexpr double kSceneRate_hz = 30.0;
constexpr double kNever = std::numeric_limits<double>::infinity();
const std::vector<Joint> kArm{Joint::wrist_left, Joint::shoulder_left, Joint::elbow_left};

// Joints over time and what two sensors see of them, with white errors.
struct Scene {
  std::vector<std::int64_t> time_ns;
  std::vector<Joint> joints;
  std::vector<Vector3d> truth_m;
  std::vector<JointObservation> seen;

  BodyPath path() const {
    return {time_ns, joints, kSceneSensors, [this](std::size_t i, std::size_t joint, auto observations) {
              std::ranges::copy_n(&seen[slot(i, joint) * kSceneSensors], kSceneSensors, observations.begin());
            }};
  }
  JointObservation& at(std::size_t i, std::size_t joint, std::size_t sensor) {
    return seen[(i * joints.size() + joint) * kSceneSensors + sensor];
  }
  std::size_t slot(std::size_t i, std::size_t joint) const { return i * joints.size() + joint; }
  void hide(std::size_t joint, std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      for (std::size_t s = 0; s < kSceneSensors; ++s) at(i, joint, s) = {};
  }
};

// A shoulder that sways, an upper arm of 0.3 m and a forearm of 0.25 m that swing.
Vector3d arm_joint_m(Joint joint, double t) {
  const Vector3d shoulder(0.1 * std::sin(2.0 * t), 1.4, 0.5 * t);
  if (joint == Joint::shoulder_left) return shoulder;
  const auto along = [](double angle) { return Vector3d(0.0, -std::cos(angle), std::sin(angle)); };
  const Vector3d elbow = shoulder + 0.3 * along(0.6 * std::sin(5.0 * t));
  if (joint == Joint::elbow_left) return elbow;
  return elbow + 0.25 * along(0.4 + 0.9 * std::sin(5.0 * t + 0.5));
}

Scene scene_of(std::size_t instants, double noise_m, const std::vector<Joint>& joints = kArm,
               std::uint64_t seed = 1, bool moves = true) {
  Scene scene;
  scene.joints = joints;
  for (std::size_t i = 0; i < instants; ++i) {
    scene.time_ns.push_back(std::llround(1e9 * static_cast<double>(i) / kSceneRate_hz));
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const RandomStream random{seed, Purpose::test, i * joints.size() + j};
      scene.truth_m.push_back(arm_joint_m(joints[j], moves ? static_cast<double>(i) / kSceneRate_hz : 0.0));
      for (std::uint32_t s = 0; s < kSceneSensors; ++s) {
        const Vector3d noise(random.normal(10 * s), random.normal(10 * s + 1), random.normal(10 * s + 2));
        scene.seen.push_back({true, TrackingState::tracked, scene.truth_m.back() + noise_m * noise, 2.0});
      }
    }
  }
  return scene;
}

std::vector<PointEstimate> estimates_of(const SmoothedBody& body) {
  std::vector<PointEstimate> estimates;
  for (std::size_t slot = 0; slot < body.status.size(); ++slot) {
    estimates.push_back(failed_estimate(body.status[slot]));
    estimates.back().position_m = body.position_m[slot];
  }
  return estimates;
}

std::vector<PointEstimate> solve(const Scene& scene, const BoneSmootherOptions& options) {
  return estimates_of(smooth_bones(scene.path(), options));
}

std::vector<PointEstimate> smoothed(const Scene& scene, std::size_t joint,
                                    const BoneSmootherOptions& options) {
  const KalmanOptions smoother{.gate_sigma = kNever, .longest_gap_s = options.longest_gap_s, .smooth = true};
  const auto observe = scene.path().observe;
  return solve_kalman(
      {scene.time_ns, kSceneSensors,
       [&](std::size_t instant, auto observations) { observe(instant, joint, observations); }},
      smoother);
}

TEST(BoneSmoother, ExactPositionsOfAPersonWhoStandsGiveTheTruth) {
  const Scene scene = scene_of(100, 0.0, kArm, 1, false);
  const auto estimates = solve(scene, {});
  ASSERT_FALSE(estimates.empty());
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    ASSERT_EQ(estimates[k].status, SolveStatus::converged);
    EXPECT_LT((estimates[k].position_m - scene.truth_m[k]).norm(), 1e-9);
  }
}

TEST(BoneSmoother, ExactPositionsOfAPersonWhoMovesGiveTheTruth) {
  const Scene scene = scene_of(150, 0.0);
  const auto estimates = solve(scene, {.sigma_m = 1e-4});
  ASSERT_FALSE(estimates.empty());
  for (std::size_t k = 0; k < estimates.size(); ++k)
    EXPECT_LT((estimates[k].position_m - scene.truth_m[k]).norm(), 2e-4) << k;
}

TEST(BoneSmoother, BonesKeepTheirLengths) {
  const Scene scene = scene_of(120, 0.03);
  const BoneSmootherOptions options{.bone_sigma_m = 0.001};
  const SmoothedBody body = smooth_bones(scene.path(), options);
  ASSERT_EQ(body.bones.size(), 2u);
  const auto estimates = estimates_of(body);
  std::vector<std::vector<PointEstimate>> alone;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) alone.push_back(smoothed(scene, j, options));
  for (const MedianBone& bone : body.bones) {
    const bool forearm = scene.joints[bone.child] == Joint::wrist_left;
    EXPECT_NEAR(bone.length_m, forearm ? 0.25 : 0.3, 0.006);
    double worst_m = 0.0, worst_smoothed_m = 0.0;
    for (std::size_t i = 0; i < scene.time_ns.size(); ++i) {
      const auto length_m = [&](const auto& at) { return (at(bone.child) - at(bone.parent)).norm(); };
      const auto estimate = [&](std::size_t j) { return estimates[scene.slot(i, j)].position_m; };
      const auto start = [&](std::size_t j) { return alone[j][i].position_m; };
      worst_m = std::max(worst_m, std::abs(length_m(estimate) - bone.length_m));
      worst_smoothed_m = std::max(worst_smoothed_m, std::abs(length_m(start) - bone.length_m));
    }
    EXPECT_LT(worst_m, 0.001);
    EXPECT_GT(worst_smoothed_m, 0.01);
  }
}

TEST(BoneSmoother, WithoutBonesAndLossItIsTheSmoother) {
  Scene scene = scene_of(40, 0.03, {Joint::wrist_left, Joint::shoulder_left});
  scene.hide(0, 10, 13);
  scene.at(20, 1, 0).state = TrackingState::inferred;
  const BoneSmootherOptions options{.loss_scale_m = kNever, .step_tolerance_m = 1e-12};
  const auto estimates = solve(scene, options);
  for (std::size_t j = 0; j < 2; ++j) {
    const auto expected = smoothed(scene, j, options);
    for (std::size_t i = 0; i < 40; ++i)
      EXPECT_LT((estimates[scene.slot(i, j)].position_m - expected[i].position_m).norm(), 1e-8) << i;
  }
}

// All residuals of a small problem of two joints, written out from the equations.
Eigen::VectorXd plain_residuals(const Scene& scene, const BoneSmootherOptions& options, double length_m,
                                const Eigen::VectorXd& x) {
  std::vector<double> r;
  const auto part = [&](std::size_t i, std::size_t j, int half) -> Vector3d {
    return x.segment<3>(static_cast<int>(6 * scene.slot(i, j)) + 3 * half);
  };
  const double dt = 1.0 / kSceneRate_hz;
  Eigen::Matrix2d noise;
  noise << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
  const Eigen::Matrix2d factor = (options.acceleration_density_m2_s3 * noise).llt().matrixL();
  for (std::size_t i = 0; i < scene.time_ns.size(); ++i) {
    r.push_back(((part(i, 0, 0) - part(i, 1, 0)).norm() - length_m) / options.bone_sigma_m);
    for (std::size_t j = 0; j < 2; ++j)
      for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t s = 0; s < kSceneSensors; ++s)
          r.push_back((part(i, j, 0)[axis] -
                       scene.seen[scene.slot(i, j) * kSceneSensors + s].point_in_world_m[axis]) /
                      options.sigma_m);
        if (i == 0) {
          r.push_back(part(0, j, 1)[axis] / options.speed_sigma_m_s);
          continue;
        }
        const Eigen::Vector2d step(
            part(i, j, 0)[axis] - part(i - 1, j, 0)[axis] - dt * part(i - 1, j, 1)[axis],
            part(i, j, 1)[axis] - part(i - 1, j, 1)[axis]);
        const Eigen::Vector2d white = factor.triangularView<Eigen::Lower>().solve(step);
        r.insert(r.end(), {white[0], white[1]});
      }
  }
  return Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<int>(r.size()));
}

TEST(BoneSmoother, EqualsThePlainBatchSolution) {
  const Scene scene = scene_of(8, 0.03, {Joint::elbow_left, Joint::shoulder_left});
  const BoneSmootherOptions options{
      .loss_scale_m = kNever, .step_tolerance_m = 1e-12, .max_iterations = 5000};
  const SmoothedBody body = smooth_bones(scene.path(), options);
  const auto residuals = [&](const Eigen::VectorXd& x) {
    return plain_residuals(scene, options, body.bones.at(0).length_m, x);
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(6 * 16);
  for (int k = 0; k < 16; ++k) x.segment<3>(6 * k) = scene.truth_m[static_cast<std::size_t>(k)];
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Eigen::VectorXd r = residuals(x);
    Eigen::MatrixXd jacobian(r.size(), x.size());
    for (int c = 0; c < x.size(); ++c) {
      const double h = 1e-5;
      Eigen::VectorXd forth = x, back = x;
      forth[c] += h;
      back[c] -= h;
      jacobian.col(c) = (residuals(forth) - residuals(back)) / (2.0 * h);
    }
    x -= jacobian.colPivHouseholderQr().solve(r);
  }
  for (int k = 0; k < 16; ++k)
    EXPECT_LT((body.position_m[static_cast<std::size_t>(k)] - x.segment<3>(6 * k)).norm(), 1e-7) << k;
}

// The elbow is away for half a second; shoulder and wrist are seen.
TEST(BoneSmoother, FindsAHiddenJointBetterThanTheSmoother) {
  const BoneSmootherOptions options{.longest_gap_s = 1.0};
  double squares_m2 = 0.0, smoothed_squares_m2 = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Scene scene = scene_of(120, 0.03, kArm, seed);
    scene.hide(2, 50, 65);
    const auto estimates = solve(scene, options);
    const auto smoother = smoothed(scene, 2, options);
    for (std::size_t i = 50; i < 65; ++i) {
      const Vector3d& truth_m = scene.truth_m[scene.slot(i, 2)];
      squares_m2 += (estimates[scene.slot(i, 2)].position_m - truth_m).squaredNorm();
      smoothed_squares_m2 += (smoother[i].position_m - truth_m).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(squares_m2), 0.7 * std::sqrt(smoothed_squares_m2));
}

TEST(BoneSmoother, ASensorThatIsFarOffHardlyCounts) {
  Scene scene = scene_of(120, 0.005, kArm, 3);
  scene.at(60, 0, 1).point_in_world_m += Vector3d(1.0, 0.0, 0.0);
  const auto estimates = solve(scene, {});
  EXPECT_LT((estimates[scene.slot(60, 0)].position_m - scene.truth_m[scene.slot(60, 0)]).norm(), 0.03);
}

TEST(BoneSmoother, AJointIsCarriedThroughSecondsWhenTheGapMayBeSoLong) {
  Scene scene = scene_of(150, 0.005);
  scene.hide(0, 40, 110);
  const auto estimates = solve(scene, {.longest_gap_s = 10.0});
  for (std::size_t i = 0; i < 150; ++i)
    EXPECT_EQ(estimates[scene.slot(i, 0)].status, SolveStatus::converged) << i;
}

TEST(BoneSmoother, AJointThatIsNeverSeenLeavesTheOthersAlone) {
  Scene scene = scene_of(60, 0.01);
  scene.hide(2, 0, 60);
  EXPECT_TRUE(smooth_bones(scene.path(), {}).bones.empty());
  const auto estimates = solve(scene, {});
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(estimates[scene.slot(i, 2)].status, SolveStatus::no_observation);
    EXPECT_EQ(estimates[scene.slot(i, 0)].status, SolveStatus::converged);
  }
}

TEST(BoneSmoother, NothingAtAllIsNoObservation) {
  Scene scene = scene_of(20, 0.0);
  for (std::size_t j = 0; j < 3; ++j) scene.hide(j, 0, 20);
  for (const PointEstimate& estimate : solve(scene, {}))
    EXPECT_EQ(estimate.status, SolveStatus::no_observation);
  EXPECT_TRUE(solve(scene_of(0, 0.0), {}).empty());
}

TEST(BoneSmoother, OneInstantIsEnough) {
  const Scene scene = scene_of(1, 0.0);
  const auto estimates = solve(scene, {});
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_EQ(estimates[j].status, SolveStatus::converged);
    EXPECT_LT((estimates[j].position_m - scene.truth_m[j]).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace trilat
