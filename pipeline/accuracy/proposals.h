// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "datasets/mocap/mocap_take.h"
#include "datasets/rig/campaign.h"
#include "pipeline/study/run_control.h"

namespace trilat {

// The joints that an export's names tell: bones of Motive's skeletons (also with FBX names), markers of the
// Baseline, Conventional and Plug-in Gait sets, joint centres, the Kinect's own joint names, and markers
// numbered about a joint (head_1, head_2); with a prefix ("Ann:LFArm") or without, but for the last. A bone
// stands at the joint that is nearer to the trunk: the forearm's is the elbow. Two markers about a joint are
// its middle. Empty when no name is known, or when names do not tell two persons apart.
// Where a file without bones has an upper arm, a forearm and no elbow, all its points are bones.
JointMapping propose_mapping(const MocapHeader& header);

// A note on points that are taken as bones for their names alone; empty where none are.
std::string bones_text(const MocapHeader& header);

// Whether a take's sensors are placed in the world of its mocap; else only a rigid alignment compares them.
bool is_in_mocap_world(const Take& take);

// The time on the recording's host clock at the first frame of a take's mocap, by the motion.
struct MocapStart {
  std::string status;  // name_of(ClockOffsetStatus); the rest counts when it is "found"
  std::string cause;   // why not, as a sentence; empty when found
  std::int64_t host_ns = 0;
  double after_recording_s = 0.0;    // since the recording's first frame
  double low_s = 0.0, high_s = 0.0;  // of that, 95 %
};

// Lays the joints' speeds in the take's bodies and in its mocap over each other, at every start up to
// `search_s` before and after the recording's. Needs calibration and mapping. The tracker's lag, 0.05 s or
// so, is in what is found. InputError for what cannot be read.
MocapStart find_mocap_start(const Take& take, double search_s, const RunControl& control);

}  // namespace trilat
