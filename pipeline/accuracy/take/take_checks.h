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

// The bodies that are one person: their tracking ids.
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

// The checks of a take, and a note with size and remedy for each that lies beyond its limit.
struct TakeChecks {
  std::vector<CheckRow> rows = {};
  std::vector<TakeNote> notes = {};
  bool names_cause = false;  // of a truth that differs
};

// Notes on the positions, clock, frames and frame rate of each sensor's stream. Sensors with the same note
// are named together.
std::vector<TakeNote> notes_on_streams(const Plan& plan, const PlannedTake& planned, const RigBodies& seen);

// Checks of the sensors of a take against each other: the same stream twice, and what fit_sensors() finds. A
// sound take has no note.
struct SensorChecks : TakeChecks {
  bool misplaced = false;      // poses are exchanged or far off, so that one person's bodies lie apart
  bool is_one_person = false;  // what was found lays all bodies over each other
  std::vector<std::size_t> odd_sensors;  // of the rig, outside the largest group that agrees
  bool rig_changed = false;              // all sensors have one fault, which the truth would show, too
};
// `bodies`: as they were read, before anything is repaired.
SensorChecks check_sensors(const Plan& plan, const PlannedTake& planned, const BodyTracks& bodies);

// Checks of the truth against the mean of the sensors, however the two worlds lie, by fit_streams(): a
// mirrored one, another unit, of all or of one joint; joints that are exchanged in the mapping; and joints
// far from where they should be. A sound take has no note.
TakeChecks check_truth(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// A start beyond what the clock by motion searches, or another rate, of a truth that does not move as the
// sensors see the person move: the text of a note with the numbers that put it right; empty where neither
// explains it.
std::string clock_fault_text(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// Another frame of the truth than the calibration's, where that explains what differs and no start does;
// empty otherwise. Text of a note.
std::string frame_fault_text(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// How each sensor is turned, shifted and measures beside its calibration, by the bodies (`data.shown`). A
// note where check_sensors() has none. Without rows where the bodies show nothing of the calibration.
TakeChecks check_poses(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

// In which share of the instants a sensor was found to have left and right exchanged; without rows in a world
// that is not level.
std::vector<CheckRow> check_sides(const Plan& plan, const PlannedTake& planned, const PreparedTake& data);

}  // namespace trilat
