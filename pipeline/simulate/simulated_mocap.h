// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "datasets/take/campaign.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {

// The virtual OptiTrack's export (mocap.csv), and beside it the same frames without noise, gaps and markers
// (truth.csv). Throws Interrupted when asked to stop.
void write_simulated_mocap(const MocapSpec& mocap, const SimulatedTakePlan& plan,
                           const std::filesystem::path& folder, const std::function<bool()>& stop_requested);

// Which of its markers are which joint.
JointMapping marker_mapping(const std::vector<Joint>& joints);

}  // namespace trilat
