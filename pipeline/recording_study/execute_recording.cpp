// SPDX-License-Identifier: MIT
#include "pipeline/recording_study/execute_recording.h"

#include <algorithm>
#include <iterator>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/results/results_file.h"
#include "pipeline/manifest.h"
#include "pipeline/recording_study/clock_errors.h"
#include "pipeline/recording_study/processing_time.h"
#include "pipeline/results_folder.h"
#include "pipeline/running_time.h"

namespace trilat {
namespace {

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

std::string key_of(const RecordingSpec& spec) { return key_of_item(resolved_json(spec)); }

RecordingOutcome empty_outcome(const RecordingSpec& spec) {
  return {{spec.name, spec.seed, false, spec.frames, spec.sensors, spec.runs, {}, {}, spec.late_s, {}},
          {spec.name, processor_name(), {}}};
}

void put_clocks(ClockErrorResults clocks, RecordingSummary& summary) {
  summary.clocks = std::move(clocks.rows);
  summary.fits = std::move(clocks.fits);
  summary.queues = std::move(clocks.queues);
}

bool captures(const RecordingSpec& spec, const ExecuteRecordingOptions& options) {
  return options.time_capture && spec.capture_s > 0.0;
}

bool is_timed(const RecordingSpec& spec, const ExecuteRecordingOptions& options) {
  return !spec.methods.empty() || captures(spec, options);
}

void time_stages(const RecordingSpec& spec, const std::filesystem::path& folder,
                 const ExecuteRecordingOptions& options, StageTimings& timings) {
  timings.stages = time_processing(spec, hooks_of(options, "processing"));
  if (captures(spec, options))
    std::ranges::move(options.time_capture(folder / "capture", hooks_of(options, "capture")),
                      std::back_inserter(timings.stages));
}

void write_outcome(const RecordingSpec& spec, const RecordingOutcome& outcome, StudyItems& items,
                   const std::filesystem::path& folder) {
  if (items.whole()) {
    write_recording_manifest(folder, spec);
    write_recording_summary(folder, outcome.summary);
  }
  if (!outcome.timings.stages.empty()) write_stage_timings(folder, outcome.timings);
  if (!outcome.summary.interrupted) items.finish(folder, key_of(spec));
}

RecordingOutcome run_parts(const RecordingSpec& spec, const std::filesystem::path& folder, StudyItems& items,
                           int threads, const ExecuteRecordingOptions& options) {
  RecordingOutcome outcome = empty_outcome(spec);
  Json times = Json::object();
  const RunningTime start;
  try {
    put_clocks(measure_clocks(spec, items, hooks_of(options, "clocks")), outcome.summary);
    times["clocks_s"] = start.seconds();
    const RunningTime timing;
    if (items.first()) time_stages(spec, folder, options, outcome.timings);
    times["timing_s"] = timing.seconds();
  } catch (const Interrupted&) {
    outcome.summary.interrupted = true;
  }
  write_outcome(spec, outcome, items, folder);
  times.update(json_of(items.tally()));
  write_run_record(folder, times, start.seconds(), threads);
  return outcome;
}

}  // namespace

RecordingOutcome execute_recording(const RecordingSpec& spec, const std::filesystem::path& output,
                                   const ExecuteRecordingOptions& options) {
  const std::vector<PartItem> list = clock_items(spec);
  std::vector<const char*> files{"simulator.json"};
  if (is_timed(spec, options)) files.push_back("timings.json");
  if (is_done_already(output, options.work, key_of(spec), list, files, options.tally))
    return {read_recording_summary(output),
            read_stage_timings(output).value_or(StageTimings{spec.name, processor_name(), {}})};
  const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile});
  RecordingOutcome outcome;
  on_threads(options.threads, [&](int threads) {
    StudyItems items(name_of(ResultsKind::recording), resolved_json(spec), list, folder.partial(),
                     options.work);
    outcome = run_parts(spec, folder.partial(), items, threads, options);
    if (options.tally) *options.tally = items.tally();
  });
  if (!outcome.summary.interrupted) folder.put_in_place();
  return outcome;
}

RecordingOutcome merge_recording(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                                 const ExecuteRecordingOptions& options) {
  const FoundPart& first = parts.front();
  const RunningTime start;
  const RecordingSpec spec = parse_recording_spec(first.part.work, (first.folder / "part.json").string());
  StudyItems items(parts);
  const ResultsFolder folder(output);
  RecordingOutcome outcome = empty_outcome(spec);
  put_clocks(measure_clocks(spec, items, {}), outcome.summary);
  if (auto timings = read_stage_timings(first.folder)) outcome.timings = std::move(*timings);
  write_outcome(spec, outcome, items, folder.partial());
  write_run_record(folder.partial(), Json::object(), start.seconds(), options.threads);
  folder.put_in_place();
  return outcome;
}

}  // namespace trilat
