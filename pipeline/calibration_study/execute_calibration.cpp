// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/execute_calibration.h"

#include <chrono>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
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

class Parts {
 public:
  Parts(const CalibrationSpec& spec, const std::filesystem::path& folder,
        const ExecuteCalibrationOptions& options)
      : spec_(spec), folder_(folder), options_(options) {}

  CalibrationSummary run(int threads) {
    const Clock::time_point start = Clock::now();
    write_calibration_manifest(folder_, spec_);
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
    write_calibration_summary(folder_, summary_);
    write_run_record(folder_, times_, std::chrono::duration<double>(Clock::now() - start).count(), threads);
    return summary_;
  }

 private:
  void run_parts() {
    timed("wand", [&](const StudyHooks& hooks) {
      WandSampleResults wand = measure_wand(spec_, hooks);
      summary_.wand = std::move(wand.rows);
      summary_.wand_samples = std::move(wand.samples);
    });
    timed("distortion",
          [&](const StudyHooks& hooks) { summary_.distortion = measure_distortion(spec_, hooks); });
    RigTrialResults rigs;
    timed("rigs", [&](const StudyHooks& hooks) { rigs = measure_rigs(spec_, folder_, hooks); });
    summary_.rigs = std::move(rigs.rows);
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
  const ExecuteCalibrationOptions& options_;
  CalibrationSummary summary_;
  Json times_ = Json::object();
};

}  // namespace

CalibrationSummary execute_calibration(const CalibrationSpec& spec, const std::filesystem::path& output,
                                       const ExecuteCalibrationOptions& options) {
  const ResultsFolder folder(output);
  CalibrationSummary summary;
  on_threads(options.threads,
             [&](int threads) { summary = Parts(spec, folder.partial(), options).run(threads); });
  if (!summary.interrupted) folder.put_in_place();
  return summary;
}

}  // namespace trilat
