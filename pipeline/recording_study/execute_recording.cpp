// SPDX-License-Identifier: MIT
#include "pipeline/recording_study/execute_recording.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/manifest.h"
#include "pipeline/recording_study/clock_errors.h"
#include "pipeline/recording_study/processing_time.h"
#include "pipeline/results_folder.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void write_recording_manifest(const std::filesystem::path& folder, const RecordingSpec& spec) {
  const Json study = resolved_json(spec);
  const Json json{{"format", "trilat.manifest"},
                  {"version", 1},
                  {"program", kProgramVersion},
                  {"study", study},
                  {"study_sha256", hash_of_text(study.dump())},
                  {"simulated", true},
                  {"inputs", Json::array()}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
  write_declared_parameters(folder, recording_parameters(spec));
}

RecordingHooks hooks_of(const ExecuteRecordingOptions& options, const std::string& part) {
  return {options.stop_requested, [&options, part](double share) {
            if (options.progress) options.progress(part, share);
          }};
}

RecordingOutcome run_parts(const RecordingSpec& spec, const std::filesystem::path& folder, int threads,
                           const ExecuteRecordingOptions& options) {
  RecordingOutcome outcome{{spec.name, spec.seed, false, spec.frames, spec.sensors, spec.runs, {}, {}},
                           {spec.name, processor_name(), {}}};
  Json times = Json::object();
  const Clock::time_point start = Clock::now();
  write_recording_manifest(folder, spec);
  try {
    ClockErrorResults clocks = measure_clocks(spec, hooks_of(options, "clocks"));
    outcome.summary.clocks = std::move(clocks.rows);
    outcome.summary.fits = std::move(clocks.fits);
    times["clocks_s"] = seconds_since(start);
    const Clock::time_point processing = Clock::now();
    outcome.timings.stages = time_processing(spec, hooks_of(options, "processing"));
    times["processing_s"] = seconds_since(processing);
    if (options.time_capture && spec.capture_s > 0.0)
      std::ranges::move(options.time_capture(folder / "capture", hooks_of(options, "capture")),
                        std::back_inserter(outcome.timings.stages));
  } catch (const Interrupted&) {
    outcome.summary.interrupted = true;
  }
  write_recording_summary(folder, outcome.summary);
  if (!outcome.timings.stages.empty()) write_stage_timings(folder, outcome.timings);
  write_run_record(folder, times, seconds_since(start), threads);
  return outcome;
}

}  // namespace

RecordingOutcome execute_recording(const RecordingSpec& spec, const std::filesystem::path& output,
                                   const ExecuteRecordingOptions& options) {
  const ResultsFolder folder(output);
  RecordingOutcome outcome;
  on_threads(options.threads,
             [&](int threads) { outcome = run_parts(spec, folder.partial(), threads, options); });
  if (!outcome.summary.interrupted) folder.put_in_place();
  return outcome;
}

}  // namespace trilat
