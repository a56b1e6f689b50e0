// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/declared_parameters.h"
#include "pipeline/items/hash_cache.h"
#include "pipeline/plan.h"
#include "pipeline/take_result.h"

namespace trilat {

// The files of a take with their hashes. Interrupted when asked to stop.
std::vector<TakeInput> inputs_of(const Take& take, HashCache& hashes,
                                 const std::function<bool()>& stop_requested);

// The key of a take's work item: equal keys, equal samples and equal result. What only the summary needs
// (names, alignments, intervals) is not in it, so that changing it costs no take.
std::string key_of_take(const Plan& plan, std::size_t take, std::span<const TakeInput> inputs,
                        bool cross_check);

// What decides the bytes of a whole results folder.
struct RunIdentity {
  StudySpec study;
  bool cross_check = false;
  std::string campaign;
  bool simulated = false;
  std::vector<DeclaredParameter> parameters;
  std::vector<Take> takes;
  std::vector<std::vector<TakeInput>> inputs;  // by take
};
std::string key_of_run(const RunIdentity& run);

}  // namespace trilat
