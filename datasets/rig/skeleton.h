// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace trilat {

// The 25 joints of the Kinect SDK 2.0, with its numbers. SpineShoulder comes after the legs: a parent may
// have a larger number than its child, so walk the tree in kJointsRootFirst order.
enum class Joint : std::uint8_t {
  spine_base = 0,
  spine_mid = 1,
  neck = 2,
  head = 3,
  shoulder_left = 4,
  elbow_left = 5,
  wrist_left = 6,
  hand_left = 7,
  shoulder_right = 8,
  elbow_right = 9,
  wrist_right = 10,
  hand_right = 11,
  hip_left = 12,
  knee_left = 13,
  ankle_left = 14,
  foot_left = 15,
  hip_right = 16,
  knee_right = 17,
  ankle_right = 18,
  foot_right = 19,
  spine_shoulder = 20,
  hand_tip_left = 21,
  thumb_left = 22,
  hand_tip_right = 23,
  thumb_right = 24,
};

inline constexpr int kJointCount = 25;

// The SDK's TrackingState.
enum class TrackingState : std::uint8_t { not_tracked = 0, inferred = 1, tracked = 2 };

std::string_view name_of(Joint joint);  // "spine_base", …
std::optional<Joint> joint_from_name(std::string_view name);
std::vector<std::string> joint_names();  // of all
// Parent of a joint; nothing for the root, spine_base.
std::optional<Joint> parent_of(Joint joint);
// Joint on the other side; a joint of the middle is its own mirror.
Joint mirror_of(Joint joint);

// Every joint after its parent.
extern const std::array<Joint, kJointCount> kJointsRootFirst;

struct Bone {
  Joint parent;
  Joint child;
};
inline constexpr int kBoneCount = kJointCount - 1;
extern const std::array<Bone, kBoneCount> kBones;

// The groups that the tables have rows for, in the order of the paper.
struct JointGroup {
  std::string_view name;
  std::span<const Joint> joints;
};
// head, shoulder, elbow, wrist, hip, knee, ankle: left and right pooled.
std::span<const JointGroup> joint_groups();
// The group a joint belongs to; nothing for joints the tables do not show (hands, feet, spine).
std::optional<std::string_view> group_of(Joint joint);
// The row a joint belongs to in the tables: its group, or its own name.
std::string table_group(Joint joint);

}  // namespace trilat
