// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/strict_json.h"
#include "datasets/results/sweep_summary.h"

namespace trilat {

// As in summary.json. What is read is equal to what was written, to the bit.
Json json_of(const SweepCell& cell);
SweepCell read_sweep_cell(JsonObject& object);

}  // namespace trilat
