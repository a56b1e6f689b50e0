// SPDX-License-Identifier: MIT
#include "tests/fuzz/chosen_seeds.h"

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/calibration/calibration.h"
#include "datasets/results/replay.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/cli/embedded_studies.h"
#include "recorders/network/link/tls_keys.h"
#include "tests/fuzz/fuzz_folder.h"
#include "tests/fuzz/sound_files.h"
#include "tests/fuzz/sound_parts.h"
#include "tests/fuzz/sound_results.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/sweeps.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

void write_chosen(const fs::path& path, std::size_t reader, const std::string& bytes) {
  write_file(path, std::string(1, static_cast<char>(reader)) + bytes);
}

void write_campaign_seeds(const SeedPath& seed) {
  const FuzzFolder scratch("seeds");
  simulate_into(scratch.path(), walking_spec(2, 0.2));
  std::size_t reader = 2;
  for (const char* name : {"campaign.json", "mapping.json", "calibration.json"})
    for (const auto& entry : fs::recursive_directory_iterator(scratch.path()))
      if (entry.path().filename() == name) {
        write_chosen(seed("settings", name), reader++, read_file(entry.path()));
        break;
      }
}

}  // namespace

void write_settings_seeds(const SeedPath& seed) {
  int number = 0;
  for (const char* study : {embedded::calibration_json, embedded::error_budget_json, embedded::sensors_json,
                            embedded::table1_json, embedded::table1_search_json, embedded::table2_json,
                            embedded::table3_json, embedded::table4_json})
    write_chosen(seed("settings", "study_" + std::to_string(number++)), 0, study);
  const StudySpec study = study_of(R"("methods": [{"name": "nonlinear", "method": "nonlinear"},
                                                  {"name": "window", "method": "window"}])");
  write_chosen(seed("settings", "every_accuracy_setting"), 0, json_text(resolved_json(study), 1));
  write_chosen(seed("settings", "every_sweep_setting"), 0, json_text(resolved_json(sweep_of(kOneRig)), 1));
  write_chosen(seed("settings", "simulation"), 1, embedded::paper_campaign_json);
  write_chosen(seed("settings", "simulation_of_a_recorded_take"), 1,
               R"({"format": "trilat.simulation", "version": 1, "recorded": {"mocap": "walk.csv",
                   "mapping": "mapping.json", "activity": "walking"}, "wand": {}, "depth": {}, "room": {}})");
  write_campaign_seeds(seed);
}

void write_results_seeds(const SeedPath& seed, const fs::path& sound) {
  write_sound_results(sound);
  const std::vector<SoundFile> files = sound_files(sound);
  for (std::size_t i = 0; i < files.size(); ++i)
    write_chosen(seed("results", files[i].folder.filename().string() + "_" + files[i].name), i,
                 files[i].text);
  for (std::size_t i = 0; i < kSoundPartFiles.size(); ++i) {
    const SoundPartFile& file = kSoundPartFiles[i];
    const fs::path path = sound / "parts" / file.folder / file.name;
    write_chosen(seed("parts", file.folder + "_" + path.parent_path().filename().string() + "_" +
                                   path.filename().string()),
                 i, read_file(path));
  }
  write_chosen(seed("samples", "samples"), 0, read_file(sound / "accuracy" / "samples.h5"));
  write_chosen(seed("samples", "replay"), 1, read_file(sound / "accuracy" / "replay.h5"));
}

void write_tls_seeds(const SeedPath& seed) {
  const FuzzFolder scratch("seeds");
  make_tls_keys(scratch.path(), {"k1"});
  write_chosen(seed("tls", "keys"), 0, read_file(scratch.path() / "k1.key"));
  write_chosen(seed("tls", "address"), 3, "[::ffff:127.0.0.1]:7345");
}

}  // namespace trilat
