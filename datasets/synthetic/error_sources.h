// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/calibration/calibration.h"
#include "datasets/synthetic/simulation_spec.h"

namespace trilat {

// The parts a simulated error is made of, for an error budget. `none` is what is left when all are off:
// interpolation between frames; `all` has all of them.
enum class ErrorSource {
  none,
  jitter,       // the tracker's white noise
  wander,       // its slow wander
  jumps,        // its jumps
  bias,         // what is systematic in a joint, viewpoint included
  unit_depth,   // of the sensors' units: offset and wiggle of their depth
  lag,          // its delay
  hidden,       // what it makes of hidden joints
  exchange,     // left and right exchanged from behind
  dropped,      // frames that are lost
  clocks,       // of the sensors, their agents and the mocap
  mocap,        // noise and gaps of the markers
  calibration,  // the sensors are not where the calibration says
  all
};
const std::vector<ErrorSource>& error_sources();
std::string name_of(ErrorSource source);
// What a reader of a table wants to know of it.
std::string description_of(ErrorSource source);

// The simulation with only this source of error; its persons, motions and rig stay.
SimulationSpec with_only(const SimulationSpec& spec, ErrorSource source);

// The calibration with every sensor moved and turned by normal errors of these sizes an axis (rotation
// vectors in world axes); the same for the same seed.
Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed);

}  // namespace trilat
