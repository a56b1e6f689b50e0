// SPDX-License-Identifier: MIT
#include "pipeline/recording/recording_study.h"

#include "datasets/results/results_file.h"
#include "datasets/results/studies/recording_summary.h"
#include "pipeline/recording/clock_errors.h"
#include "pipeline/recording/processing_time.h"
#include "pipeline/study/results_folder.h"

namespace trilat {
namespace {

RecordingSummary summarise(const RecordingSpec& spec, const Outcomes& outcomes) {
  RecordingSummary summary;
  summary.study = spec.name;
  summary.seed = spec.seed;
  summary.frames = spec.frames;
  summary.sensors = spec.sensors;
  summary.runs = spec.runs;
  summary.late_s = spec.late_s;
  ClockErrorResults clocks = read_clocks(spec, outcomes);
  summary.clocks = std::move(clocks.rows);
  summary.fits = std::move(clocks.fits);
  summary.queues = std::move(clocks.queues);
  return summary;
}

}  // namespace

Study recording_study(const RecordingSpec& spec) {
  const Json resolved = resolved_json(spec);
  Study study{.kind = name_of(StudyKind::recording),
              .work = resolved,
              .items = clock_items(spec),
              .write_beside =
                  [spec](const std::filesystem::path& folder) {
                    write_declared_parameters(folder, recording_parameters(spec));
                  },
              .reduce = [spec](const Outcomes& outcomes, const std::filesystem::path& results,
                               const Watch&) { write_recording_summary(results, summarise(spec, outcomes)); },
              .manifest = [resolved](const Outcomes&) { return manifest_of_generated(resolved); }};
  if (!spec.methods.empty())
    study.time = [spec](const std::filesystem::path& folder, const Watch& watch) {
      write_stage_timings(folder, {spec.name, processor_name(), time_processing(spec, watch)});
    };
  return study;
}

}  // namespace trilat
