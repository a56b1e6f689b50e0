// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/results/calibration_summary.h"
#include "pipeline/calibration_study/calibration_spec.h"
#include "pipeline/items/study_items.h"

namespace trilat {

struct ExecuteCalibrationOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& part, double share)> progress = {};
  WorkOptions work = {};
  bool fresh = false;          // what `output`.partial holds is not gone on with
  ItemTally* tally = nullptr;  // told what was computed and what was not
};

// Runs the study's parts and writes the results folder: manifest.json, summary.json and run.json. Interrupted
// leaves the parts that were finished in `output`.partial.
// A shard leaves a part folder and an empty summary. Nothing is written when `output` is among the earlier
// results and holds just these.
CalibrationSummary execute_calibration(const CalibrationSpec& spec, const std::filesystem::path& output,
                                       const ExecuteCalibrationOptions& options);

// The results that one run would have given, to the byte, but for run.json.
CalibrationSummary merge_calibration(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                                     const ExecuteCalibrationOptions& options);

}  // namespace trilat
