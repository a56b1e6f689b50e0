// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_study.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/results/simulation_assumptions.h"
#include "pipeline/calibration_study/calibration_numbers.h"
#include "pipeline/calibration_study/place_samples.h"
#include "pipeline/study/results_run.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// One recording to be evaluated.
struct Recording {
  std::string id, name;
  std::vector<RecordingFile> files;
  Json stated;  // what the campaign states of it beside its files
  std::function<Json(const RunControl&)> measure;
};

// "bench_room" of bench_room/session.h5, "wall" of wall.h5.
std::string name_of_recording(const fs::path& session) {
  return session.stem() == "session" ? fs::absolute(session).parent_path().filename().string()
                                     : session.stem().string();
}

Recording wand_recording(const CalibrationSpec& spec, const CampaignWand& wand, const Campaign& campaign) {
  Recording recording{"wand/wand", name_of_recording(wand.session), {}, {}, {}};
  recording.stated = {{"asset", wand.asset},
                      {"mocap_start_host_ns", wand.mocap_start_host_ns},
                      {"ball_radius_m", wand.ball_radius_m}};
  recording.files.push_back({recording.name, "session", wand.session});
  if (!wand.mocap.empty()) recording.files.push_back({recording.name, "mocap", wand.mocap});
  fs::path calibration = campaign.calibration;
  for (const Take& take : campaign.takes)
    if (calibration.empty()) calibration = take.calibration;
  if (!calibration.empty()) recording.files.push_back({recording.name, "calibration", calibration});
  recording.measure = [=](const RunControl& control) {
    std::optional<Calibration> stated;
    if (!calibration.empty()) stated = read_calibration(calibration);
    return json_of(measure_wand(wand, stated, spec.frames, control));
  };
  return recording;
}

Recording stated_recording(const CalibrationSpec& spec, const StatedDistances& stated, std::size_t number) {
  Recording recording{
      "distances/" + std::to_string(number + 1), name_of_recording(stated.session), {}, {}, {}};
  recording.stated = {{"ball_radius_m", stated.ball_radius_m}};
  recording.files = {{recording.name, "session", stated.session}, {recording.name, "places", stated.places}};
  recording.measure = [=](const RunControl& control) {
    return json_of(measure_stated_distances(stated, spec.frames, control));
  };
  return recording;
}

Recording wall_recording(const FlatWall& wall, std::size_t number) {
  Recording recording{"walls/" + std::to_string(number + 1), name_of_recording(wall.session), {}, {}, {}};
  if (wall.distance_m) recording.stated = {{"distance_m", *wall.distance_m}};
  recording.files = {{recording.name, "session", wall.session}};
  recording.measure = [=](const RunControl& control) { return json_of(measure_wall(wall, control)); };
  return recording;
}

std::vector<Recording> recordings_of(const CalibrationSpec& spec, const Campaign& campaign) {
  std::vector<Recording> recordings;
  for (std::size_t k = 0; k < campaign.stated_distances.size(); ++k)
    recordings.push_back(stated_recording(spec, campaign.stated_distances[k], k));
  if (campaign.wand) recordings.push_back(wand_recording(spec, *campaign.wand, campaign));
  for (std::size_t k = 0; k < campaign.walls.size(); ++k)
    recordings.push_back(wall_recording(campaign.walls[k], k));
  if (recordings.empty())
    throw InputError(
        "campaign \"" + campaign.name + '"',
        "has no recording to calibrate by: name a wand (\"wand\": {\"session\": …}), a ball at measured "
        "distances (\"stated_distances\") or a flat wall (\"walls\") in its campaign.json");
  std::set<std::string> used;  // recordings may have one name in several folders
  for (Recording& recording : recordings) recording.name = unused_name(recording.name, used);
  return recordings;
}

// Collects what the items gave; those that failed are named in `summary`.
CalibrationRecordings gather(const std::vector<Recording>& recordings, const ResultsRun& run,
                             CalibrationSummary& summary) {
  CalibrationRecordings made;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Recording& recording = recordings[r];
    const ItemResult& outcome = run.outcome(r);
    if (outcome.failed) {
      summary.failed.push_back(recording.name + ": " + outcome.json.at("problem").get<std::string>());
      continue;
    }
    summary.recordings.push_back(recording.name);
    if (recording.id.starts_with("walls/")) {
      WallRecording wall = read_as<WallRecording>(outcome.json, outcome.place());
      summary.simulated |= wall.simulated;
      for (WallRow& row : wall.rows) made.walls.emplace_back(std::move(row)).recording = recording.name;
    } else {
      WandRecording& wand = made.wands.emplace_back(read_as<WandRecording>(outcome.json, outcome.place()));
      wand.name = recording.name;
      if (wand.truth == WandTruth::stated && summary.stated_distances.empty())
        summary.stated_distances = wand.name;
      summary.simulated |= wand.simulated;
    }
  }
  return made;
}

void write_study(const CalibrationSpec& spec, const Campaign& campaign,
                 const std::vector<Recording>& recordings, const ResultsRun& run, const fs::path& folder) {
  CalibrationSummary summary;
  summary.study = spec.name;
  summary.campaign = campaign.name;
  summary.paper = name_of(spec.paper);
  summary.simulated = campaign.simulated;
  const CalibrationRecordings made = gather(recordings, run, summary);
  if (summary.recordings.empty())
    throw InputError("campaign \"" + campaign.name + '"', summary.failed.front());
  summary.numbers = calibration_numbers(made);
  const std::vector<SimulationAssumption> simulator = read_simulation_assumptions(campaign.folder);
  if (!simulator.empty()) write_simulation_assumptions(folder, simulator);
  store_tables(folder, calibration_tables(summary, made));
  write_json_file(folder, StoredFigures{calibration_figures(summary.simulated, made)});
  write_results(folder, summary);
}

ComputedItem measure(const Recording& recording, const WatchedFiles& files, const RunControl& control) {
  try {
    Json outcome = recording.measure(control);
    files.check();
    return outcome;
  } catch (const InputError& error) {
    return {Json{{"problem", error.what()}}, true};
  }
}

std::vector<fs::path> paths_of(const Recording& recording) {
  std::vector<fs::path> paths;
  for (const RecordingFile& file : recording.files) paths.push_back(file.file);
  return paths;
}

// The cost of a recording grows with its length.
double cost_of(const Recording& recording) {
  std::error_code error;
  const auto bytes = static_cast<double>(fs::file_size(recording.files.front().file, error));
  return error ? 1.0 : bytes;
}

}  // namespace

std::size_t calibration_recordings(const CalibrationSpec& spec, const Campaign& campaign) {
  return recordings_of(spec, campaign).size();
}

ItemCounts run_calibration(const CalibrationSpec& spec, const Campaign& campaign, const fs::path& folder,
                           const StudyOptions& options) {
  const std::vector<Recording> recordings = recordings_of(spec, campaign);
  const Json resolved = json_of(spec);
  HashCache hashes;
  hashes.load(folder);
  std::vector<ResultsRun::Item> items;
  std::vector<WatchedFiles> watched;  // from before they are read
  std::vector<RecordingFile> files;
  Json stated = Json::object();
  for (const Recording& recording : recordings) {
    items.push_back({recording.id, cost_of(recording)});
    watched.emplace_back(paths_of(recording));
    files.insert(files.end(), recording.files.begin(), recording.files.end());
    stated[recording.id] = recording.stated;
  }
  ResultsRun run(folder, items, options);
  run.find_keys([&](std::size_t r, const RunControl& control) {
    return key_of({{"study", resolved},
                   {"simulated", campaign.simulated},
                   {"stated", recordings[r].stated},
                   {"inputs", hashed_inputs(recordings[r].files, hashes, control.stop_requested)}});
  });
  const Json manifest = manifest_of(resolved, {{"campaign", campaign.name},
                                               {"simulated", campaign.simulated},
                                               {"stated", stated},
                                               {"inputs", hashed_inputs(files, hashes, {})}});
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  if (run.is_whole()) hashes.save(folder);
  run.compute([&](std::size_t r, const fs::path&, const RunControl& control) {
    return measure(recordings[r], watched[r], control);
  });
  if (run.is_whole())
    run.publish_results(manifest,
                        [&](const fs::path& into) { write_study(spec, campaign, recordings, run, into); });
  return run.tally();
}

}  // namespace trilat
