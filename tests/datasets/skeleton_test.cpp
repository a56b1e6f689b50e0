// SPDX-License-Identifier: MIT
#include "datasets/rig/skeleton.h"

#include <set>

#include <gmock/gmock.h>

namespace trilat {
namespace {

TEST(Skeleton, HasTheNumbersOfTheKinectSdk) {
  EXPECT_EQ(static_cast<int>(Joint::head), 3);
  EXPECT_EQ(static_cast<int>(Joint::wrist_right), 10);
  EXPECT_EQ(static_cast<int>(Joint::foot_right), 19);
  EXPECT_EQ(static_cast<int>(Joint::spine_shoulder), 20);
  EXPECT_EQ(static_cast<int>(Joint::thumb_right), 24);
}

TEST(Skeleton, RootFirstOrderHasEveryJointOnceAndAfterItsParent) {
  std::set<Joint> seen;
  for (Joint joint : kJointsRootFirst) {
    if (const auto parent = parent_of(joint)) {
      EXPECT_TRUE(seen.contains(*parent)) << name_of(joint);
    }
    EXPECT_TRUE(seen.insert(joint).second) << name_of(joint);
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(kJointCount));
}

TEST(Skeleton, NamesAreUniqueAndReadBack) {
  for (Joint joint : kJointsRootFirst) EXPECT_EQ(joint_from_name(name_of(joint)), joint);
  EXPECT_FALSE(joint_from_name("tail"));
}

TEST(Skeleton, MirrorIsAnInvolutionThatKeepsTheTree) {
  for (Joint joint : kJointsRootFirst) {
    EXPECT_EQ(mirror_of(mirror_of(joint)), joint);
    if (const auto parent = parent_of(joint)) {
      EXPECT_EQ(parent_of(mirror_of(joint)), mirror_of(*parent));
    }
  }
}

TEST(Skeleton, GroupsPoolLeftAndRight) {
  EXPECT_EQ(group_of(Joint::wrist_left), "wrist");
  EXPECT_EQ(group_of(Joint::wrist_right), "wrist");
  EXPECT_EQ(group_of(Joint::head), "head");
  EXPECT_FALSE(group_of(Joint::spine_mid));
  EXPECT_EQ(joint_groups().size(), 7u);
}

}  // namespace
}  // namespace trilat
