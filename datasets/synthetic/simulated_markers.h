// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/synthetic/motion.h"
#include "datasets/synthetic/simulated_sensor.h"

namespace trilat {

inline constexpr int kMarkersPerJoint = 4;

// "head_1" … "head_4": the markers of one joint.
std::string marker_name(Joint joint, int marker);

// The four markers of one joint at frame `frame` of the virtual OptiTrack: corners of a tetrahedron about the
// joint that turns with the body, so that their mean is the joint, plus noise. A lost marker is NaN. World,
// metres.
std::vector<Eigen::Vector3d> simulate_markers(const SkeletonPose& pose, Joint joint, const MocapSpec& spec,
                                              const SimulatedItem& item, std::uint64_t frame);

// A rigid body's position at frame `frame`, with the noise of a marker; NaN while it is lost.
Eigen::Vector3d simulate_rigid_body(const Eigen::Vector3d& position_in_world_m, const MocapSpec& spec,
                                    const SimulatedItem& item, std::uint64_t frame);

// Time by which the stated start of the mocap is later than the true one, on the host clock.
Duration mocap_clock_error(const MocapSpec& spec, const SimulatedItem& item);

}  // namespace trilat
