// SPDX-License-Identifier: MIT
#include "tests/fuzz/sound_results.h"

#include "datasets/base/files.h"
#include "datasets/results/gate_history.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/calibration_study/calibration_tables.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sweep/sweep_study.h"
#include "pipeline/variations/variations_study.h"
#include "tests/fuzz/calibration_summaries.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/sweeps.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

void write_accuracy(const fs::path& scratch) {
  const Campaign campaign = simulate_into(scratch / "campaign", walking_spec(2, 0.5));
  const StudySpec study = study_of(
      R"("methods": [{"name": "linear", "method": "linear"}, {"name": "nonlinear", "method": "nonlinear"},
                     {"name": "mean", "method": "mean"}],
         "alignments": ["mean", "none"], "rate_hz": 10)");
  execute_study(study, campaign, scratch / "accuracy", {.threads = 1});
}

void write_sweep(const fs::path& scratch) {
  const SweepPlan plan =
      sweep_plan_of(kOneRig + R"(, "trials": 20, "digits_trials": 10, "max_iterations": 50, "search": true,
                                 "time_problems": 16, "time_repeats": 1)");
  run_study(sweep_study(plan), scratch / "sweep", {.threads = 1});
}

void write_recording(const fs::path& scratch) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "recording", "name": "clocks", "frames": 100,
          "sensors": 3, "runs": 1, "methods": [{"name": "linear", "method": "linear"}]})";
  const Study study =
      recording_study(parse_recording_spec(parse_json(text, "recording.json"), "recording.json"));
  run_study(study, scratch / "recording", {.threads = 1});
}

void write_variations(const fs::path& folder) {
  const std::string text =
      R"({"format": "trilat.study", "version": 1, "kind": "variations", "name": "map", "clock": "stated",
          "points": 8, "alignments": ["none"],
          "simulation": {"format": "trilat.simulation", "version": 1, "body_tracker": {}, "participants": 1,
                         "activities": [{"name": "walking", "duration_s": 0.3}]},
          "methods": [{"method": "mean"}, {"method": "nonlinear"}],
          "ranges": [{"setting": "/rig/radius_m", "low": 1.8, "high": 2.2}],
          "comparisons": [{"better": "nonlinear", "than": ["mean"]}]})";
  run_study(variations_study(parse_variations(parse_json(text, "map.json"), "map.json", {}, {})), folder,
            {.threads = 1});
}

void write_gate_files(const fs::path& folder) {
  make_folder(folder);
  write_beside(folder, AcceptedBaseline{"first night", "2026-01-01T03:00:00Z", "trilat", "00ff", "", ""});
  HistoryEntry night;
  night.time = "2026-01-01T03:00:00Z";
  night.program = "trilat";
  night.alarms = {"nonlinear"};
  night.error_m = {{"nonlinear/head", 0.05}};
  night.coverage = {{"nonlinear/head", 1.0}};
  append_history(folder / "history.jsonl", night);
}

}  // namespace

std::vector<SoundFile> sound_files(const fs::path& results) {
  std::vector<SoundFile> files;
  for (const auto& folder : fs::directory_iterator(results))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension().string().starts_with(".json"))
        files.push_back({folder, entry.path().filename().string(), read_file(entry.path())});
  std::ranges::sort(files, [](const SoundFile& a, const SoundFile& b) {
    return std::pair(a.folder, a.name) < std::pair(b.folder, b.name);
  });
  return files;
}

void write_sound_results(const fs::path& scratch) {
  fs::remove_all(scratch);
  make_folder(scratch);
  write_accuracy(scratch);
  write_sweep(scratch);
  write_recording(scratch);
  make_folder(scratch / "calibration");
  const CalibrationSummary calibration = hand_made_calibration();
  store_tables(scratch / "calibration", calibration_tables(calibration));
  write_beside(scratch / "calibration", StoredFigures{calibration_figures(calibration)});
  write_results(scratch / "calibration", calibration);
  write_variations(scratch / "variations");
  write_gate_files(scratch / "gate");
}

}  // namespace trilat
