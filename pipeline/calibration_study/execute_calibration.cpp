// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/execute_calibration.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/results/results_file.h"
#include "pipeline/calibration_study/distortion.h"
#include "pipeline/calibration_study/joint_effect.h"
#include "pipeline/calibration_study/rig_trials.h"
#include "pipeline/calibration_study/wand_samples.h"
#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

void write_calibration_manifest(const std::filesystem::path& folder, const CalibrationSpec& spec) {
  const Json study = resolved_json(spec);
  const Json json{{"format", "trilat.manifest"},
                  {"version", 1},
                  {"program", kProgramVersion},
                  {"study", study},
                  {"study_sha256", hash_of_text(study.dump())},
                  {"simulated", true},
                  {"inputs", Json::array()}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

std::string key_of(const CalibrationSpec& spec) { return key_of_item(resolved_json(spec)); }

std::vector<PartItem> items_of(const CalibrationSpec& spec) {
  std::vector<PartItem> items = wand_items(spec);
  for (const auto& more : {distortion_items(spec), rig_items(spec)})
    items.insert(items.end(), more.begin(), more.end());
  return items;
}

class Parts {
 public:
  Parts(const CalibrationSpec& spec, const std::filesystem::path& folder, StudyItems& items,
        const ExecuteCalibrationOptions& options)
      : spec_(spec), folder_(folder), items_(items), options_(options) {}

  CalibrationSummary run(int threads) {
    const Clock::time_point start = Clock::now();
    summary_.study = spec_.name;
    summary_.seed = spec_.seed;
    summary_.samples = spec_.samples;
    summary_.units = spec_.units;
    summary_.frames = spec_.frames;
    summary_.ball_radius_m = spec_.ball_radius_m;
    summary_.positions = spec_.positions;
    try {
      run_parts();
    } catch (const Interrupted&) {
      summary_.interrupted = true;
    }
    if (items_.whole()) {
      write_calibration_manifest(folder_, spec_);
      write_calibration_summary(folder_, summary_);
    }
    if (!summary_.interrupted) items_.finish(folder_, key_of(spec_));
    if (!items_.merging()) times_.update(json_of(items_.tally()));
    write_run_record(folder_, times_, std::chrono::duration<double>(Clock::now() - start).count(), threads);
    return summary_;
  }

 private:
  void run_parts() {
    timed("wand", [&](const StudyHooks& hooks) {
      WandSampleResults wand = measure_wand(spec_, items_, hooks);
      summary_.wand = std::move(wand.rows);
      summary_.wand_samples = std::move(wand.samples);
    });
    timed("distortion",
          [&](const StudyHooks& hooks) { summary_.distortion = measure_distortion(spec_, items_, hooks); });
    RigTrialResults rigs;
    timed("rigs", [&](const StudyHooks& hooks) { rigs = measure_rigs(spec_, folder_, items_, hooks); });
    summary_.rigs = std::move(rigs.rows);
    if (!items_.whole()) return;
    timed("effect", [&](const StudyHooks& hooks) {
      summary_.effect = measure_effect(spec_, true_rig(spec_), rigs.calibrations, hooks);
    });
  }

  template <class Part>
  void timed(const std::string& name, const Part& part) {
    const Clock::time_point start = Clock::now();
    part(StudyHooks{options_.stop_requested, [&](double share) {
                      if (options_.progress) options_.progress(name, share);
                    }});
    times_[name + "_s"] = std::chrono::duration<double>(Clock::now() - start).count();
  }

  const CalibrationSpec& spec_;
  const std::filesystem::path& folder_;
  StudyItems& items_;
  const ExecuteCalibrationOptions& options_;
  CalibrationSummary summary_;
  Json times_ = Json::object();
};

}  // namespace

CalibrationSummary execute_calibration(const CalibrationSpec& spec, const std::filesystem::path& output,
                                       const ExecuteCalibrationOptions& options) {
  const std::vector<PartItem> list = items_of(spec);
  if (is_done_already(output, options.work, key_of(spec), list, {}, options.tally))
    return read_calibration_summary(output);
  const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile});
  CalibrationSummary summary;
  on_threads(options.threads, [&](int threads) {
    StudyItems items(name_of(ResultsKind::calibration), resolved_json(spec), list, folder.partial(),
                     options.work);
    summary = Parts(spec, folder.partial(), items, options).run(threads);
    if (options.tally) *options.tally = items.tally();
  });
  if (!summary.interrupted) folder.put_in_place();
  return summary;
}

CalibrationSummary merge_calibration(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                                     const ExecuteCalibrationOptions& options) {
  const FoundPart& first = parts.front();
  const CalibrationSpec spec = parse_calibration_spec(first.part.work, (first.folder / "part.json").string());
  StudyItems items(parts);
  const ResultsFolder folder(output);
  CalibrationSummary summary;
  on_threads(options.threads,
             [&](int threads) { summary = Parts(spec, folder.partial(), items, options).run(threads); });
  if (!summary.interrupted) folder.put_in_place();
  return summary;
}

}  // namespace trilat
