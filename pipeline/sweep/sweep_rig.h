// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "pipeline/sweep/sweep_spec.h"

namespace trilat {

// 1 to 60 characters that fit into a heading and a cell of a table.
bool is_plain_name(const std::string& name);

// The list of rigs under `key`: names differ, each rig has 3 to 8 sensors, no two in one place and not all on
// one line. A rig is {"name", "heights_m": […], "radius_m"}, sensor i at angle 360 i / n degrees of a circle
// around the origin (x = r cos, z = r sin), or {"name", "sensors_m": [[x, y, z], …]}.
std::vector<SweepRig> read_rigs(JsonObject& object, const std::string& key);

}  // namespace trilat
