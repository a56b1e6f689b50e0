// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/results/studies/sensitivity_summary.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/methods/study_spec.h"

namespace trilat {

// study.json, format 1, kind "sensitivity": which conclusions hold in which part of a space of simulations.
struct SensitivitySpec {
  StudySpec study;                        // what every campaign is evaluated with
  Json simulation;                        // simulation.json, whose settings the space varies
  std::string place;                      // of it, for errors
  std::vector<std::vector<Json>> values;  // by factor: those of a list; empty: a range
  SensitivitySummary head;                // factors, claims and slices; no points
};

// `simulation` is an object, or a path relative to `folder`; without one it is `fallback`, the paper's
// campaign. InputError for a factor whose setting does not exist or whose ends the simulation refuses, and
// for a claim about a method that is not compared.
SensitivitySpec parse_sensitivity(const Json& json, const std::string& place,
                                  const std::filesystem::path& folder, const Json& fallback);

// The simulation at a position of the space: by factor 0 to 1, NaN where it stays as it is. InputError for
// settings that contradict each other.
SimulationSpec simulation_at(const SensitivitySpec& spec, const std::vector<double>& position,
                             std::uint64_t seed);

}  // namespace trilat
