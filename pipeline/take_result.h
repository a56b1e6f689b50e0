// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/summary.h"
#include "datasets/results/tracking_summary.h"
#include "pipeline/plan.h"
#include "pipeline/tracking_check.h"

namespace trilat {

// A file that a take is made of.
struct TakeInput {
  std::string role, file;  // what it is, its name
  std::uintmax_t bytes = 0;
  std::string sha256;  // empty when it could not be read
};

// How far the own solver and Ceres were apart in one take.
struct TakeCheck {
  std::uint64_t samples = 0, disagreements = 0;
  double worst_m = 0.0;
  std::string worst_at, disagreed_at;  // the first
  void merge(const TakeCheck& later);
};

// All that evaluating one take gives besides its samples and its replay.
struct TakeResult {
  std::vector<TakeInput> inputs;
  std::vector<TakeNote> notes;  // places are given from the campaign's folder
  TakeCheck check;
  TakeTracking tracking;
  bool evaluated = false;
};

Json json_of(const TakeResult& result);
TakeResult read_take_result(const Json& json, const std::string& place);

// Where the samples of a take are: `folder`/samples.h5 and, when it is shown, `folder`/replay.h5, under its
// id.
struct EvaluatedTake {
  std::string key;  // of the work item; empty when the take could not be evaluated
  std::filesystem::path folder;
  TakeResult result;
};

}  // namespace trilat
