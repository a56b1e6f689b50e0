// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/strict_json.h"
#include "datasets/results/summary.h"

namespace trilat {

// The entries of summary.json (kind accuracy). Readers refuse keys that are missing or not known, with the
// place; NaN is null.
Json json_of(const SummaryCell& cell);
Json json_of(const DifferenceCell& cell);
Json json_of(const BodyCell& cell);
Json json_of(const TruthFloor& floor);

SummaryCell read_cell(JsonObject& object);
DifferenceCell read_difference(JsonObject& object);
BodyCell read_body(JsonObject& object);
TruthFloor read_floor(JsonObject& object);

}  // namespace trilat
