// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {

// Reads places.csv: from_s, to_s (since the first depth frame), sensor, distance_m, and angle_deg where it is
// known. InputError with the line where a distance is none in metres, a sensor or a time is not in the
// session.
std::vector<WandPlace> read_stated_places(const std::filesystem::path& csv, const SessionReader& session);

// Errors of every way to find the ball, each the mean of at most `frames` frames of a place. InputError at
// the places' file where the stated distances are not those of what the sensors see.
WandRecording measure_stated_distances(const StatedDistances& stated, std::uint64_t frames,
                                       const RunControl& control);

// Measures a wand's recording. A tenth of the places after the third is left out in turn: in the poses
// that the others give, the truth is where OptiTrack saw the ball there, or, without an export, where the
// other sensors did. Poses by each way to calibrate are held against `stated`, where both are in
// OptiTrack's world. InputError says what a calibration is lacking.
WandRecording measure_wand(const CampaignWand& wand, const std::optional<Calibration>& stated,
                           std::uint64_t frames, const RunControl& control);

// Measures each sensor's depth of a flat wall, against a plane that is fitted to the mean of its frames.
// InputError where less than four fifths of what a sensor sees lies within 3 cm of one plane.
WallRecording measure_wall(const FlatWall& wall, const RunControl& control);

}  // namespace trilat
