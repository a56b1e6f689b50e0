// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {

// study.json, format 1, kind "error_budget": a simulated campaign taken apart into its sources of error.
struct BudgetSpec {
  SimulationSpec simulation;
  double calibration_sigma_m = 0.005;  // an axis; what a wand calibration is held to
  double calibration_sigma_deg = 0.2;
  StudySpec study;           // what every part is evaluated with
  std::string sha256 = {};   // of the documents that it was read from
  WatchedFiles inputs = {};  // those that are read again for every source of error
};

// `simulation` is a path relative to `folder`, wherever it leads; without one it is `fallback`, the paper's
// campaign. `seed` and `participants` replace those of the simulation.
BudgetSpec parse_budget(const Json& json, const std::string& place, const std::filesystem::path& folder,
                        const SimulationSpec& fallback);

// A simulated campaign, once for every source of error, evaluated; the campaigns themselves are not kept. An
// item a source of error. Its summary.json is a BudgetSummary.
Study budget_study(const BudgetSpec& spec);

}  // namespace trilat
