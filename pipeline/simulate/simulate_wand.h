// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/synthetic/simulated_sensor.h"
#include "pipeline/study/watch.h"
#include "recorders/synthetic_source.h"

namespace trilat {

// Depth that is rendered on all processors, reports its progress and ends by Interrupted.
SyntheticDepth watched_depth(const SimulationSpec& spec, std::size_t sensors, double duration_s,
                             SceneMotion scene, const Watch& watch);

double wand_duration_s(const WandSpec& wand);
// The wand recording's place among the campaign's random numbers: behind all takes.
SimulatedItem wand_item(const SimulationSpec& spec);
// Stated time of the recording's host clock at the first frame of the wand's mocap.csv.
HostTime wand_mocap_start(const SimulationSpec& spec);

// Writes `folder`/session.h5 (depth and bodies), truth.json and mocap.csv of the calibration recording that
// spec.wand asks for.
void simulate_wand(const SimulationSpec& spec, const std::vector<SensorPose>& poses,
                   const Eigen::Vector3d& rig_centre_m, const std::filesystem::path& folder,
                   const Watch& watch);

}  // namespace trilat
