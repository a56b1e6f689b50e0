// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/mocap/mocap_take.h"
#include "datasets/take/campaign.h"

namespace trilat {

// The joints that an export's names tell: bones of Motive's skeletons (also with FBX names), markers of the
// Baseline, Conventional and Plug-in Gait sets, joint centres, the Kinect's own joint names, and markers
// numbered about a joint (head_1, head_2); with a prefix ("Ann:LFArm") or without, but for the last. A bone
// stands at the joint that is nearer to the trunk: the forearm's is the elbow. Two markers about a joint are
// its middle. Empty when no name is known, or when names do not tell two persons apart.
JointMapping propose_mapping(const MocapHeader& header);

}  // namespace trilat
