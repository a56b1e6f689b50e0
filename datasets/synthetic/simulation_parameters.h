// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/synthetic/simulation_spec.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"

namespace trilat {

// Everything that a simulated campaign assumes of persons, rig, sensors, tracker and mocap, with what each
// value rests on: what a reader of its results has to know.
std::vector<TrackerParameter> simulation_parameters(const SimulationSpec& spec);

}  // namespace trilat
