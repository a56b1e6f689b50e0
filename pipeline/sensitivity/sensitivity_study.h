// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/sensitivity/sensitivity_spec.h"
#include "pipeline/study/study.h"

namespace trilat {

// Campaigns all over a space of simulations, each evaluated; they are not kept. An item is a row of the
// design, the simulation as it is, or a row of a slice. Its summary.json is a SensitivitySummary. InputError
// for a point of the space whose settings contradict each other.
Study sensitivity_study(const SensitivitySpec& spec);

// Every setting written out: what parse_sensitivity() reads.
Json resolved_json(const SensitivitySpec& spec);

// How many campaigns it simulates.
std::size_t campaigns_of(const SensitivitySpec& spec);

}  // namespace trilat
