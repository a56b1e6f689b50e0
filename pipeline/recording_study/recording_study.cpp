// SPDX-License-Identifier: MIT
#include "pipeline/recording_study/recording_study.h"

#include <algorithm>
#include <iterator>

#include "datasets/results/recording_summary.h"
#include "pipeline/manifest.h"
#include "pipeline/recording_study/clock_errors.h"
#include "pipeline/recording_study/processing_time.h"

namespace trilat {
namespace {

constexpr double kProcessingShare = 0.3;  // of the time that timing takes

RecordingSummary summarise(const RecordingSpec& spec, const Outcomes& outcomes) {
  RecordingSummary summary{spec.name, spec.seed, false, spec.frames, spec.sensors,
                           spec.runs, {},        {},    spec.late_s, {}};
  ClockErrorResults clocks = read_clocks(spec, outcomes);
  summary.clocks = std::move(clocks.rows);
  summary.fits = std::move(clocks.fits);
  summary.queues = std::move(clocks.queues);
  return summary;
}

StageTimings time_stages(const RecordingSpec& spec, const TimeCapture& time_capture,
                         const std::filesystem::path& scratch, const Watch& watch) {
  const auto share = [&](double before, double part) {
    return Watch{watch.stop_requested, share_of(watch.progress, before, part)};
  };
  StageTimings timings{spec.name, processor_name(), time_processing(spec, share(0.0, kProcessingShare))};
  if (time_capture)
    std::ranges::move(
        time_capture(spec, scratch / "capture", share(kProcessingShare, 1.0 - kProcessingShare)),
        std::back_inserter(timings.stages));
  return timings;
}

}  // namespace

Study recording_study(const RecordingSpec& spec, const TimeCapture& time_capture) {
  const Json resolved = resolved_json(spec);
  Study study{StudyKind::recording,
              resolved,
              clock_items(spec),
              manifest_of(resolved, {{"simulated", true}, {"inputs", Json::array()}}),
              recording_parameters(spec),
              [spec](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                write_recording_summary(results, summarise(spec, outcomes));
              }};
  const TimeCapture timed = spec.capture_s > 0.0 ? time_capture : TimeCapture{};
  if (timed || !spec.methods.empty())
    study.time = [spec, timed](const std::filesystem::path& scratch, const Watch& watch) {
      return time_stages(spec, timed, scratch, watch);
    };
  return study;
}

}  // namespace trilat
