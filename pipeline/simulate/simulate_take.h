// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/declared_parameters.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/take/campaign.h"
#include "pipeline/simulate/simulate_wand.h"

namespace trilat {

// One take to be simulated: who does what, watched by which sensors.
struct SimulatedTakePlan {
  std::string id;
  std::string participant;
  std::string activity;
  SimulatedItem item;
  Motion motion;
  double duration_s = 0.0;
  std::vector<Joint> marker_joints;      // empty when the mocap is a real take
  std::filesystem::path recorded_mocap;  // the real take, or empty
  std::filesystem::path recorded_mapping;
};

// The sensors' true poses and what they look at.
struct SimulatedRig {
  std::vector<SensorPose> poses;
  Eigen::Vector3d centre_m;
};

// Writes `folder`/session.h5, mocap.csv, truth.csv, truth.json and mapping.json for one take, with a body
// tracker also tracker_truth.h5, and returns its
// entry for the campaign. For a real take mocap.csv and mapping.json are copies of what was given, and there
// is no truth.csv.
Take simulate_take(const SimulationSpec& spec, const SimulatedTakePlan& plan, const SimulatedRig& rig,
                   const std::filesystem::path& folder, const Watch& watch);

// What the simulation assumes, as simulator.json holds it.
std::vector<DeclaredParameter> declared_parameters(const SimulationSpec& spec);

// All that a simulation records: every take, and last the wand when there is one.
struct SimulatedCampaign {
  SimulatedRig rig;
  std::vector<SimulatedTakePlan> takes;
  bool wand = false;
  std::size_t recordings() const { return takes.size() + (wand ? 1 : 0); }
  std::string id(std::size_t recording) const {
    return recording < takes.size() ? takes[recording].id : "wand";
  }
};
SimulatedCampaign simulated_campaign(const SimulationSpec& spec);

// About how long each recording takes, in seconds of a take without depth.
std::vector<double> costs_of(const SimulationSpec& spec, const SimulatedCampaign& campaign);

// Makes one recording in `folder`; the entry of a take, nothing of the wand.
std::optional<Take> simulate_recording(const SimulationSpec& spec, const SimulatedCampaign& campaign,
                                       std::size_t recording, const std::filesystem::path& folder,
                                       const Watch& watch);

// calibration.json and simulator.json.
void write_rig(const SimulationSpec& spec, const SimulatedRig& rig, const std::filesystem::path& folder);

}  // namespace trilat
