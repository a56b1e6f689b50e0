// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/rig/campaign.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "pipeline/study/run_control.h"
#include "recorders/synthetic_source.h"

namespace trilat {

// Depth that is rendered on all processors, reports its progress and ends by Interrupted.
SyntheticDepth watched_depth(const SimulationSpec& spec, std::size_t sensors, double duration_s,
                             SceneMotion scene, const RunControl& control);

double wand_duration_s(const WandSpec& wand);
// The wand recording's place among the campaign's random numbers: behind all takes.
SimulatedItem wand_item(const SimulationSpec& spec);
// Stated time of the recording's host clock at the first frame of the wand's mocap.csv.
HostTime wand_mocap_start(const SimulationSpec& spec);

// Writes `folder`/session.h5 (depth and bodies), truth.json and mocap.csv of the calibration recording that
// spec.wand asks for.
void simulate_wand(const SimulationSpec& spec, const std::vector<SensorPose>& poses,
                   const Eigen::Vector3d& rig_centre_m, const std::filesystem::path& folder,
                   const RunControl& control);

// A recording beside the takes, by which sensors are calibrated or a calibration is judged.
struct CalibrationRecording {
  std::string folder;  // inside the campaign's
  double duration_s = 0.0;
  // Writes session.h5, truth.json and what else belongs to it.
  std::function<void(const std::filesystem::path& folder, const RunControl& control)> simulate;
  // Names it in a campaign, when it lies in `folder`.
  std::function<void(const std::filesystem::path& folder, Campaign& campaign)> add_to;
};

// The wand's recording, and those of the bench: session.h5 and, of a ball, places.csv, which states its
// distance and angle at every place as a laser meter would. `poses` and `rig_centre_m`: of the rig, where the
// wand is seen.
std::vector<CalibrationRecording> calibration_recordings(const SimulationSpec& spec,
                                                         const std::vector<SensorPose>& poses,
                                                         const Eigen::Vector3d& rig_centre_m);

}  // namespace trilat
