// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/joint_visibility.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "datasets/session/session_types.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/simulated_sensor.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
using enum Joint;

std::vector<SimulatedSensor> rig() {
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0}))
    sensors.push_back(draw_sensor({}, {}, sensors.size(), pose));
  return sensors;
}

// A person in poses that differ from case to case.
SkeletonPose person(int number) {
  return generated_motion(draw_person(5, 1, 1.7, 0.17), static_cast<Activity>(number % 3))(0.37 * number);
}

std::vector<float> image_of(const DepthRenderer& renderer, const SimulatedSensor& sensor,
                            const DepthScene& scene) {
  std::vector<float> image(kDepthPixels);
  renderer.render_exact(scene, sensor.pose.world_from_sensor, image);
  return image;
}

TEST(JointVisibility, ARayMeetsWhatTheDepthRendererShowsAtItsPixel) {
  std::size_t surfaces = 0, differing = 0;
  for (const SimulatedSensor& sensor : rig()) {
    JointVisibility visibility(sensor.intrinsics);
    const DepthRenderer renderer(sensor.intrinsics, noise_free_depth(), {});
    std::vector<float> image(kDepthPixels);
    for (int number = 0; number < 12; ++number) {
      const SkeletonPose pose = person(number);
      DepthScene scene;
      append_person(scene, pose);
      renderer.render_exact(scene, sensor.pose.world_from_sensor, image);
      visibility.set_person(pose, sensor.pose.world_from_sensor);
      for (int row = number % 3; row < kDepthHeight; row += 3)
        for (int column = number % 2; column < kDepthWidth; column += 2) {
          const float expected = image[static_cast<std::size_t>(row * kDepthWidth + column)];
          const auto depth_m = visibility.depth_m(column, row);
          if (std::isnan(expected) && !depth_m) continue;
          ++surfaces;
          // a silhouette may pass on either side of a ray within the rounding of floats
          if (std::isnan(expected) || !depth_m || std::abs(*depth_m - static_cast<double>(expected)) > 1e-4)
            ++differing;
        }
    }
  }
  EXPECT_GT(surfaces, 50'000u);
  EXPECT_LE(differing, surfaces / 10'000);
}

struct OwnSurfaces {
  Joint joint;
  std::vector<std::pair<Joint, Joint>> bones;
  bool head_sphere;
};

// The share is what one gets from two images: one of everything and one of the joint's own surfaces alone.
TEST(JointVisibility, TheVisibleShareIsThatOfTheImageOfTheOwnSurfaces) {
  const OwnSurfaces cases[] = {
      {wrist_left,
       {{elbow_left, wrist_left},
        {wrist_left, hand_left},
        {hand_left, hand_tip_left},
        {wrist_left, thumb_left}},
       false},
      {hand_tip_right,
       {{wrist_right, hand_right}, {hand_right, hand_tip_right}, {wrist_right, thumb_right}},
       false},
      {elbow_right, {{shoulder_right, elbow_right}, {elbow_right, wrist_right}}, false},
      {shoulder_left,
       {{spine_shoulder, shoulder_left}, {shoulder_left, elbow_left}, {spine_mid, spine_shoulder}},
       false},
      {hip_right, {{spine_base, hip_right}, {hip_right, knee_right}, {spine_base, spine_mid}}, false},
      {knee_left, {{hip_left, knee_left}, {knee_left, ankle_left}}, false},
      {foot_right, {{ankle_right, foot_right}}, false},
      {head, {{neck, head}}, true}};
  const std::pair<int, int> sides[] = {{0, 0}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
  int partly = 0, fully = 0, none = 0;
  for (const SimulatedSensor& sensor : rig()) {
    JointVisibility visibility(sensor.intrinsics);
    const DepthRenderer renderer(sensor.intrinsics, noise_free_depth(), {});
    for (int number = 0; number < 6; ++number) {
      const SkeletonPose pose = person(number);
      DepthScene scene;
      append_person(scene, pose);
      const std::vector<float> all = image_of(renderer, sensor, scene);
      visibility.set_person(pose, sensor.pose.world_from_sensor);
      for (const OwnSurfaces& own : cases) {
        const Vector3d at = sensor.pose.world_from_sensor.inverse() * pose.at(own.joint);
        std::vector<float> mine(kDepthPixels, std::numeric_limits<float>::quiet_NaN());
        // each surface by itself, because one met more than its diameter before the joint is not the joint's
        const auto add = [&](const DepthScene& alone, double radius_m) {
          const std::vector<float> surface = image_of(renderer, sensor, alone);
          for (std::size_t i = 0; i < mine.size(); ++i)
            if (static_cast<double>(surface[i]) >= at.z() - 2.0 * radius_m && !(mine[i] <= surface[i]))
              mine[i] = surface[i];
        };
        std::size_t bones = 0;
        for (const BodySurface& part : surfaces_of(pose))
          for (const auto& [parent, end] : own.bones)
            if (part.parent == parent && part.end == end) {
              DepthScene alone;
              alone.capsules.push_back({pose.at(parent), pose.at(end), part.radius_m});
              add(alone, part.radius_m);
              ++bones;
            }
        ASSERT_EQ(bones, own.bones.size());
        if (own.head_sphere) {
          DepthScene alone;
          alone.spheres.push_back({pose.at(head), radius_at(head)});
          add(alone, radius_at(head));
        }
        const Eigen::Vector2d pixel = *project(sensor.intrinsics, at);
        const auto away = std::lround(0.5 * radius_at(own.joint) * sensor.intrinsics.fx_px / at.z());
        double met = 0.0, first = 0.0;
        bool close = false;
        for (const auto& [right, down] : sides) {
          const long column = std::lround(pixel.x()) + right * away,
                     row = std::lround(pixel.y()) + down * away;
          if (column < 0 || row < 0 || column >= kDepthWidth || row >= kDepthHeight) continue;
          const auto i = static_cast<std::size_t>(row * kDepthWidth + column);
          if (std::isnan(mine[i])) continue;
          met += 1.0;
          close = close || std::abs(mine[i] - all[i] - 1e-3f) < 1e-5f;  // floats do not tell
          if (mine[i] - all[i] <= 1e-3f) first += 1.0;
        }
        if (close) continue;
        const double share = visibility.visible_share(own.joint);
        ASSERT_NEAR(share, met > 0.0 ? first / met : 1.0, 1e-9) << name_of(own.joint) << " " << number;
        ++(share == 0.0 ? none : share == 1.0 ? fully : partly);
      }
    }
  }
  EXPECT_GT(none, 5);
  EXPECT_GT(partly, 5);
  EXPECT_GT(fully, 50);
}

// Joints that a sensor at a place sees hidden.
std::vector<Joint> hidden_from(const Vector3d& position_m, const SkeletonPose& pose) {
  JointVisibility visibility{DepthIntrinsics()};
  visibility.set_person(pose, world_from_sensor_looking_at(position_m, {0.0, 1.0, 0.0}));
  const auto hidden = visibility.hidden_joints(0.5);
  std::vector<Joint> joints;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (hidden[j]) joints.push_back(static_cast<Joint>(j));
  return joints;
}

// Faces +z, the left is at +x.
SkeletonPose standing_pose() { return generated_motion(Person{}, Activity::standing)(0.0); }

using testing::Contains;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;

TEST(JointVisibility, WhoStandsInFrontOfTheSensorHidesNothing) {
  EXPECT_THAT(hidden_from({0.0, 1.0, 2.2}, standing_pose()), IsEmpty());
}

// (The near hip is behind the hanging hand.)
TEST(JointVisibility, TheFarSideIsHiddenFromTheSide) {
  const auto hidden = hidden_from({2.2, 1.0, 0.0}, standing_pose());
  EXPECT_THAT(hidden, IsSupersetOf({shoulder_right, elbow_right, hip_right, knee_right, ankle_right}));
  for (const Joint joint : {shoulder_left, elbow_left, wrist_left, knee_left, ankle_left, head, neck})
    EXPECT_THAT(hidden, Not(Contains(joint))) << name_of(joint);
}

TEST(JointVisibility, AnArmInFrontOfTheTrunkIsSeenAndOneBehindItIsNot) {
  const auto with_arm_at = [](double z_m) {
    SkeletonPose pose = standing_pose();
    const Vector3d by = Vector3d(0.0, 1.25, z_m) - pose.at(wrist_left);
    for (const Joint joint : {wrist_left, hand_left, hand_tip_left, thumb_left}) pose.at(joint) += by;
    pose.at(elbow_left) = {0.1, 1.25, z_m};
    return hidden_from({0.0, 1.2, 2.2}, pose);
  };
  EXPECT_THAT(with_arm_at(0.3), Not(Contains(wrist_left)));
  EXPECT_THAT(with_arm_at(0.3), Not(Contains(spine_mid)));  // an arm is thinner than the trunk
  EXPECT_THAT(with_arm_at(-0.3), IsSupersetOf({elbow_left, wrist_left}));
}

TEST(JointVisibility, OfTwoCrossingShanksTheOneBehindIsHidden) {
  SkeletonPose pose = standing_pose();
  pose.at(knee_left) = {0.0, 0.5, 0.15};
  pose.at(ankle_left) = {0.0, 0.1, 0.15};
  pose.at(knee_right) = {0.0, 0.5, -0.1};
  pose.at(ankle_right) = {0.0, 0.1, -0.1};
  const auto front = hidden_from({0.0, 0.5, 2.2}, pose), back = hidden_from({0.0, 0.5, -2.2}, pose);
  EXPECT_THAT(front, IsSupersetOf({knee_right, ankle_right}));
  EXPECT_THAT(front, Not(Contains(knee_left)));
  EXPECT_THAT(front, Not(Contains(ankle_left)));
  EXPECT_THAT(back, IsSupersetOf({knee_left, ankle_left}));
  EXPECT_THAT(back, Not(Contains(ankle_right)));
}

TEST(JointVisibility, AJointWithoutBonesAndAShareOfZeroHideNothing) {
  SkeletonPose lonely;
  lonely.at(head) = {0.0, 1.6, 0.0};
  lonely.at(wrist_left) = {0.0, 1.0, 0.0};
  lonely.present.set(static_cast<std::size_t>(wrist_left));
  EXPECT_THAT(hidden_from({0.0, 1.0, 2.0}, lonely), IsEmpty());
  JointVisibility visibility{DepthIntrinsics()};
  visibility.set_person(standing_pose(), world_from_sensor_looking_at({2.2, 1.0, 0.0}, {0.0, 1.0, 0.0}));
  EXPECT_TRUE(visibility.hidden_joints(0.5).any());
  EXPECT_TRUE(visibility.hidden_joints(0.0).none());
}

}  // namespace
}  // namespace trilat
