// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/mocap/mocap_take.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/take/campaign.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {

// The virtual OptiTrack's export (mocap.csv), and beside it the same frames without noise, gaps and markers
// (truth.csv). Throws Interrupted when asked to stop.
void write_simulated_mocap(const MocapSpec& mocap, const SimulatedTakePlan& plan,
                           const std::filesystem::path& folder, const std::function<bool()>& stop_requested);

// Which of its markers are which joint.
JointMapping marker_mapping(const std::vector<Joint>& joints);

// What only the simulator knows about a recording: truth.json. With `depth`, also each unit's depth error.
Json simulated_truth(const SimulatedItem& item, const std::vector<SimulatedSensor>& sensors,
                     Duration mocap_error, const DepthNoiseSpec* depth);

// The head of a virtual OptiTrack export with these assets of one type.
MocapHeader simulated_mocap_header(const std::string& take_name, double rate_hz, std::int64_t frames,
                                   AssetType type, const std::vector<std::string>& assets);

// How many frames the virtual OptiTrack makes, the first at the start of the motion.
std::int64_t mocap_frames(const MocapSpec& mocap, double duration_s);

}  // namespace trilat
