// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/variations/variations_summary.h"

namespace trilat {

// study.json, format 1, kind "variations": one accuracy study of many variations of a simulation, which are
// patches of its document, or points all over the ranges of some of its settings.
struct VariationsSpec {
  StudySpec study;                        // what every campaign is evaluated with
  Json simulation;                        // simulation.json, patched as all points have it
  std::string place;                      // of it, for errors
  std::filesystem::path folder;           // from where its paths are given
  std::vector<Json> patches;              // JSON merge patches (RFC 7396), by point; empty: ranges
  std::vector<std::vector<Json>> values;  // by range: those of a list; empty: a range
  VariationsSummary head;                 // ranges, comparisons, and points without errors
  WatchedFiles inputs;                    // what the simulation reads beside its document
  std::string inputs_sha256;
};

// `simulation` is an object, or a path relative to `folder`; without one it is `fallback`, the paper's
// campaign. InputError for a patch or an end of a range that the simulation refuses, for conditions, sensors
// and methods that it does not have, and for a comparison of methods that are not evaluated.
VariationsSpec parse_variations(const Json& json, const std::string& place,
                                const std::filesystem::path& folder, const Json& fallback);

// The study that was read, defaults included.
Json resolved_json(const VariationsSpec& spec);

// The simulation of a point. InputError for settings that contradict each other. Points of ranges have
// persons of their own; those of patches the same.
SimulationSpec simulation_at(const VariationsSpec& spec, std::size_t point);
Json simulation_json_at(const VariationsSpec& spec, std::size_t point);  // its document

}  // namespace trilat
