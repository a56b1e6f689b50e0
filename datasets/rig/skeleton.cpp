// SPDX-License-Identifier: MIT
#include "datasets/rig/skeleton.h"

#include <algorithm>

namespace trilat {
namespace {

using enum Joint;

struct JointEntry {
  std::string_view name;
  Joint parent;  // itself for the root
  Joint mirror;
};

constexpr std::array<JointEntry, kJointCount> kJoints{{
    {"spine_base", spine_base, spine_base},
    {"spine_mid", spine_base, spine_mid},
    {"neck", spine_shoulder, neck},
    {"head", neck, head},
    {"shoulder_left", spine_shoulder, shoulder_right},
    {"elbow_left", shoulder_left, elbow_right},
    {"wrist_left", elbow_left, wrist_right},
    {"hand_left", wrist_left, hand_right},
    {"shoulder_right", spine_shoulder, shoulder_left},
    {"elbow_right", shoulder_right, elbow_left},
    {"wrist_right", elbow_right, wrist_left},
    {"hand_right", wrist_right, hand_left},
    {"hip_left", spine_base, hip_right},
    {"knee_left", hip_left, knee_right},
    {"ankle_left", knee_left, ankle_right},
    {"foot_left", ankle_left, foot_right},
    {"hip_right", spine_base, hip_left},
    {"knee_right", hip_right, knee_left},
    {"ankle_right", knee_right, ankle_left},
    {"foot_right", ankle_right, foot_left},
    {"spine_shoulder", spine_mid, spine_shoulder},
    {"hand_tip_left", hand_left, hand_tip_right},
    {"thumb_left", wrist_left, thumb_right},
    {"hand_tip_right", hand_right, hand_tip_left},
    {"thumb_right", wrist_right, thumb_left},
}};

constexpr const JointEntry& entry_of(Joint joint) { return kJoints[static_cast<std::size_t>(joint)]; }

constexpr std::array<Joint, 1> kHead{head};
constexpr std::array<Joint, 2> kShoulder{shoulder_left, shoulder_right};
constexpr std::array<Joint, 2> kElbow{elbow_left, elbow_right};
constexpr std::array<Joint, 2> kWrist{wrist_left, wrist_right};
constexpr std::array<Joint, 2> kHip{hip_left, hip_right};
constexpr std::array<Joint, 2> kKnee{knee_left, knee_right};
constexpr std::array<Joint, 2> kAnkle{ankle_left, ankle_right};
constexpr std::array<JointGroup, 7> kGroups{{{"head", kHead},
                                             {"shoulder", kShoulder},
                                             {"elbow", kElbow},
                                             {"wrist", kWrist},
                                             {"hip", kHip},
                                             {"knee", kKnee},
                                             {"ankle", kAnkle}}};

constexpr std::array<Bone, kBoneCount> make_bones(const std::array<Joint, kJointCount>& order) {
  std::array<Bone, kBoneCount> bones{};
  for (std::size_t i = 1; i < order.size(); ++i) bones[i - 1] = {entry_of(order[i]).parent, order[i]};
  return bones;
}

}  // namespace

constexpr std::array<Joint, kJointCount> kRootFirst{
    spine_base, spine_mid,      spine_shoulder, neck,       head,           shoulder_left, elbow_left,
    wrist_left, hand_left,      hand_tip_left,  thumb_left, shoulder_right, elbow_right,   wrist_right,
    hand_right, hand_tip_right, thumb_right,    hip_left,   knee_left,      ankle_left,    foot_left,
    hip_right,  knee_right,     ankle_right,    foot_right};

const std::array<Joint, kJointCount> kJointsRootFirst = kRootFirst;
const std::array<Bone, kBoneCount> kBones = make_bones(kRootFirst);

std::string_view name_of(Joint joint) { return entry_of(joint).name; }

std::optional<Joint> joint_from_name(std::string_view name) {
  for (std::size_t i = 0; i < kJoints.size(); ++i)
    if (kJoints[i].name == name) return static_cast<Joint>(i);
  return std::nullopt;
}

std::vector<std::string> joint_names() {
  std::vector<std::string> names;
  for (int j = 0; j < kJointCount; ++j) names.emplace_back(name_of(static_cast<Joint>(j)));
  return names;
}

std::optional<Joint> parent_of(Joint joint) {
  const Joint parent = entry_of(joint).parent;
  return parent == joint ? std::nullopt : std::optional(parent);
}

Joint mirror_of(Joint joint) { return entry_of(joint).mirror; }

std::span<const JointGroup> joint_groups() { return kGroups; }

std::optional<std::string_view> group_of(Joint joint) {
  for (const JointGroup& group : kGroups)
    if (std::ranges::find(group.joints, joint) != group.joints.end()) return group.name;
  return std::nullopt;
}

std::string table_group(Joint joint) { return std::string(group_of(joint).value_or(name_of(joint))); }

}  // namespace trilat
