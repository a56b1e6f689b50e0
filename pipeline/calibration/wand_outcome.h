// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/base/strict_json.h"
#include "pipeline/calibration/wand_in_world.h"
#include "pipeline/calibration/wand_search.h"

namespace trilat {

// What items of a wand search came to, as documents that read back to the last bit. InputError at `place`
// when one is not as it was written.
Json json_of(const SensorSearch& search);
SensorSearch read_sensor_search(const Json& json, const std::string& place);

Json json_of(const WandTrack& track);
WandTrack wand_track_of(const Json& json, const std::string& place);

}  // namespace trilat
