// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "datasets/base/strict_json.h"
#include "datasets/results/sweep_summary.h"

namespace trilat {

// The member "search" of a sweep's summary.json.
Json json_of(const SweepSearch& search);
// Refuses numbers of interpretations that the summary does not have, and factors that are not one a range.
SweepSearch read_search(JsonObject object, std::size_t interpretations, std::size_t ranges);

}  // namespace trilat
