// SPDX-License-Identifier: MIT
#include "pipeline/simulate/campaign_study.h"

#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/simulate/simulate_take.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::string item_of(const std::string& recording) { return "recordings/" + recording; }

// The entries of campaign.json on a take besides its files.
Json json_of(const Take& take) {
  return {{"participant", take.participant},
          {"activity", take.activity},
          {"mocap_start_host_ns", take.mocap_start_host_ns},
          {"up_axis", kUpAxisNames.at(static_cast<std::size_t>(take.up_axis.value_or(UpAxis::y)))}};
}

Take read_take(const std::string& id, const Json& json, const std::string& place, const fs::path& folder) {
  JsonObject object(json, place, "");
  Take take{id,
            object.text("participant"),
            object.text("activity"),
            folder / id / "session.h5",
            folder / "calibration.json",
            folder / id / "mocap.csv",
            folder / id / "mapping.json",
            object.integer("mocap_start_host_ns"),
            read_up_axis(object)};
  object.finish();
  return take;
}

// Moves what the items recorded out of the store.
void put_together(const SimulationSpec& spec, const SimulatedCampaign& simulated, const Outcomes& outcomes,
                  const fs::path& folder) {
  Campaign campaign{spec.name, true, {}, folder};
  for (const CalibrationRecording& recording : simulated.calibration)
    recording.add_to(folder / recording.folder, campaign);
  for (std::size_t r = 0; r < simulated.recordings(); ++r) {
    const std::string id = simulated.id(r);
    const Outcome& outcome = outcomes.at(item_of(id));
    fs::rename(outcome.folder, folder / id);
    fs::remove(folder / id / "item.json");
    if (!outcome.json.is_null())
      campaign.takes.push_back(read_take(id, outcome.json, outcome.place(), folder));
  }
  write_campaign(folder, campaign);
}

}  // namespace

Study campaign_study(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs) {
  const auto shared = std::make_shared<const SimulationSpec>(spec);
  const auto campaign = std::make_shared<const SimulatedCampaign>(simulated_campaign(spec));
  Study study{.kind = "campaign",
              .settings = {{"simulation", spec.name}, {"sha256", sha256}},
              .reduce = [=](const Outcomes& outcomes, const fs::path& folder, const Watch&) {
                put_together(*shared, *campaign, outcomes, folder);
              }};
  const std::vector<double> costs = costs_of(spec, *campaign);
  for (std::size_t r = 0; r < campaign->recordings(); ++r)
    study.items.push_back({item_of(campaign->id(r)), costs[r], [=](const fs::path& into, const Watch& watch) {
                             const std::optional<Take> take =
                                 simulate_recording(*shared, *campaign, r, into, watch);
                             inputs.check();
                             return take ? json_of(*take) : Json();
                           }});
  study.write_beside = [shared, campaign](const fs::path& folder) {
    write_rig(*shared, campaign->rig, folder);
  };
  return study;
}

ItemTally record_campaign(const Study& study, const fs::path& folder, const StudyOptions& options) {
  return run_to_files(study, folder, options, "campaign.json", [](const fs::path& path) {
    const std::string name = path.filename().string();
    return name == "calibration.json" || name == "simulator.json" || fs::exists(path / "truth.json");
  });
}

Campaign simulate_campaign(const SimulationSpec& spec, const fs::path& folder, const Watch& watch) {
  record_campaign(campaign_study(spec, "", {}), folder,
                  {.threads = tbb::this_task_arena::max_concurrency(),
                   .stop_requested = watch.stop_requested,
                   .progress = [&](const std::string&, double share) { watch.tell(share); },
                   .fresh = true});
  return read_campaign(folder);
}

}  // namespace trilat
