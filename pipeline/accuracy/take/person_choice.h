// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/accuracy/take/sensor_track.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {

using RigBodies = std::vector<SensorBodies>;  // by rig sensor

// Which bodies of each sensor are one person.
struct PersonChoice {
  std::vector<std::set<std::uint64_t>> identities;  // by rig sensor
  bool sees_several = false;                        // any sensor at one time
  std::string note;
};

// Matches the bodies across sensors and takes the person who is nearest to the ground truth in the median,
// also before and after a long absence; without ground truth the one with the most frames. Nothing when all
// bodies are that person's, or when no sensor ever sees two at once, no tracking id went over to another body
// and no person is near the truth (which may be in another world). `data` has its times and truth.
std::optional<PersonChoice> choose_person(const Plan& plan, const PlannedTake& planned, const RigBodies& seen,
                                          const PersonTake& data);

}  // namespace trilat
