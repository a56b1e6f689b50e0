// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/results/recording_summary.h"
#include "datasets/results/stage_timings.h"
#include "pipeline/recording_study/clock_errors.h"
#include "pipeline/recording_study/recording_spec.h"

namespace trilat {

struct ExecuteRecordingOptions {
  int threads = 0;  // 0: as many as there are processors
  std::function<bool()> stop_requested = {};
  std::function<void(const std::string& part, double share)> progress = {};
  // Times a recording in real time, in a folder that does not exist yet. Not of this room: it takes
  // recorders.
  std::function<std::vector<StageTiming>(const std::filesystem::path& folder, const RecordingHooks& hooks)>
      time_capture = {};
  WorkOptions work = {};
  bool fresh = false;          // what `output`.partial holds is not gone on with
  ItemTally* tally = nullptr;  // told what was computed and what was not
};

struct RecordingOutcome {
  RecordingSummary summary;
  StageTimings timings;
};

// Runs the study's parts and writes the results folder: manifest.json, simulator.json, summary.json (equal
// for equal studies), timings.json (measured) and run.json. Interrupted leaves the parts that were finished
// in `output`.partial. A shard leaves a part folder and an empty summary; the first times. Nothing is written
// when `output` is among the earlier results and holds just these.
RecordingOutcome execute_recording(const RecordingSpec& spec, const std::filesystem::path& output,
                                   const ExecuteRecordingOptions& options);

// The results that one run would have given, to the byte, but for run.json and timings.json.
RecordingOutcome merge_recording(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                                 const ExecuteRecordingOptions& options);

}  // namespace trilat
