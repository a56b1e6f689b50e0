// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/json.h"
#include "datasets/mocap/mocap_take.h"
#include "datasets/results/simulation_assumptions.h"
#include "datasets/rig/campaign.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "pipeline/simulate/calibration_recordings.h"

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
  UpAxis up_axis = UpAxis::y;  // of the mocap
};

// The sensors' true poses and what they look at.
struct SimulatedRig {
  std::vector<SensorPose> poses;
  Eigen::Vector3d centre_m;
};

// Writes `folder`/session.h5, mocap.csv, truth.csv, truth.json and mapping.json for one take, and returns its
// entry for the campaign. For a real take mocap.csv and
// mapping.json are copies of what was given, and there is no truth.csv.
Take simulate_take(const SimulationSpec& spec, const SimulatedTakePlan& plan, const SimulatedRig& rig,
                   const std::filesystem::path& folder, const RunControl& control);

// All that a simulation records: every take, and behind them what it is calibrated by.
struct SimulatedCampaign {
  SimulatedRig rig;
  std::vector<SimulatedTakePlan> takes;
  std::vector<CalibrationRecording> calibration;
  std::size_t recordings() const { return takes.size() + calibration.size(); }
  const std::string& id(std::size_t recording) const {
    return recording < takes.size() ? takes[recording].id : calibration[recording - takes.size()].folder;
  }
};
SimulatedCampaign simulated_campaign(const SimulationSpec& spec);

// About how long each recording takes, in seconds of a take without depth.
std::vector<double> costs_of(const SimulationSpec& spec, const SimulatedCampaign& campaign);

// Makes one recording in `folder`; the entry of a take, nothing of a calibration recording.
std::optional<Take> simulate_recording(const SimulationSpec& spec, const SimulatedCampaign& campaign,
                                       std::size_t recording, const std::filesystem::path& folder,
                                       const RunControl& control);

// calibration.json and simulator.json.
void write_rig(const SimulationSpec& spec, const SimulatedRig& rig, const std::filesystem::path& folder);

// The virtual OptiTrack's export (mocap.csv), and beside it the same frames without noise, gaps and markers
// (truth.csv). Throws Interrupted when asked to stop.
void write_simulated_mocap(const MocapSpec& mocap, const SimulatedTakePlan& plan,
                           const std::filesystem::path& folder, const std::function<bool()>& stop_requested);

// Which of its markers are which joint.
JointMapping marker_mapping(const std::vector<Joint>& joints);

// The truth of a recording, truth.json. With `depth`, also each unit's depth error.
Json simulated_truth(const SimulatedItem& item, const std::vector<SimulatedSensor>& sensors,
                     Duration mocap_error, const DepthNoiseSpec* depth);

// The head of a virtual OptiTrack export with these assets of one type.
MocapHeader simulated_mocap_header(const std::string& take_name, double rate_hz, std::int64_t frames,
                                   AssetType type, const std::vector<std::string>& assets);

// How many frames the virtual OptiTrack makes, the first at the start of the motion.
std::int64_t mocap_frames(const MocapSpec& mocap, double duration_s);

}  // namespace trilat
