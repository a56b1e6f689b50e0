// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/study/study.h"
#include "pipeline/variations/variations_spec.h"

namespace trilat {

// Each point is an item: its campaign is simulated, evaluated and removed again. One that cannot be evaluated
// fails with its reason and is tried again by the next run. Beside summary.json: points.csv, tables.json and
// figures.json.
Study variations_study(const VariationsSpec& spec);

}  // namespace trilat
