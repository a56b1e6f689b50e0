// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "datasets/results/calibration_summary.h"
#include "pipeline/calibration_study/calibration_spec.h"

namespace trilat {

struct ExecuteCalibrationOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& part, double share)> progress = {};
};

// Runs the study's parts and writes the results folder: manifest.json, summary.json and run.json. Interrupted
// leaves the parts that were finished in `output`.partial.
CalibrationSummary execute_calibration(const CalibrationSpec& spec, const std::filesystem::path& output,
                                       const ExecuteCalibrationOptions& options);

}  // namespace trilat
