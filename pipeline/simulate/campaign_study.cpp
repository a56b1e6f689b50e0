// SPDX-License-Identifier: MIT
#include "pipeline/simulate/campaign_study.h"

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/simulate/simulate_take.h"
#include "pipeline/study/results_run.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// Keys of a take in campaign.json besides its files.
struct TakeEntry {
  std::string participant, activity;
  std::int64_t mocap_start_host_ns = 0;
  UpAxis up_axis = UpAxis::y;

  static void fields(auto& self, auto&& f) {
    f("participant", self.participant, "activity", self.activity, "mocap_start_host_ns",
      self.mocap_start_host_ns, "up_axis", self.up_axis);
  }
};

Take take_of(const std::string& id, const TakeEntry& entry, const fs::path& folder) {
  return {id,
          entry.participant,
          entry.activity,
          folder / id / "session.h5",
          folder / "calibration.json",
          folder / id / "mocap.csv",
          folder / id / "mapping.json",
          entry.mocap_start_host_ns,
          entry.up_axis};
}

// Moves what the items recorded out of the store.
void finish_campaign(const SimulationSpec& spec, const SimulatedCampaign& simulated, const ResultsRun& run,
                     const fs::path& folder) {
  Campaign campaign{spec.name, true, {}, folder};
  for (const CalibrationRecording& recording : simulated.calibration)
    recording.add_to(folder / recording.folder, campaign);
  for (std::size_t r = 0; r < simulated.recordings(); ++r) {
    const std::string id = simulated.id(r);
    const ItemResult& outcome = run.outcome(r);
    fs::rename(outcome.folder, folder / id);
    fs::remove(folder / id / "item.json");
    if (!outcome.json.is_null())
      campaign.takes.push_back(take_of(id, read_as<TakeEntry>(outcome.json, outcome.place()), folder));
  }
  write_campaign(folder, campaign);
}

// Whether an earlier simulation left it.
bool is_of_campaign(const fs::path& path) {
  const std::string name = path.filename().string();
  return name == "calibration.json" || name == "simulator.json" || fs::exists(path / "truth.json");
}

}  // namespace

ItemCounts record_campaign(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs,
                           const fs::path& folder, const StudyOptions& options) {
  const SimulatedCampaign campaign = simulated_campaign(spec);
  const std::vector<double> costs = costs_of(spec, campaign);
  std::vector<ResultsRun::Item> items;
  for (std::size_t r = 0; r < campaign.recordings(); ++r)
    items.push_back({"recordings/" + campaign.id(r), costs[r]});
  ItemCounts tally;
  {
    ResultsRun run(folder, items, options);
    run.find_keys([&](std::size_t r, const RunControl&) {
      return key_of({{"simulation", spec.name}, {"sha256", sha256}, {"recording", campaign.id(r)}});
    });
    run.compute([&](std::size_t r, const fs::path& into, const RunControl& control) -> Json {
      const std::optional<Take> take = simulate_recording(spec, campaign, r, into, control);
      inputs.check();
      if (!take) return Json();
      return json_of(TakeEntry{take->participant, take->activity, take->mocap_start_host_ns,
                               take->up_axis.value_or(UpAxis::y)});
    });
    run.publish("campaign.json", is_of_campaign, [&](const fs::path& into) {
      write_rig(spec, campaign.rig, into);
      finish_campaign(spec, campaign, run, into);
    });
    tally = run.tally();
  }
  const ItemStore store(folder);
  store.remove_all_but({});
  store.remove_if_empty();
  return tally;
}

Campaign simulate_campaign(const SimulationSpec& spec, const fs::path& folder, const RunControl& control) {
  record_campaign(spec, "", {}, folder,
                  {.stop_requested = control.stop_requested,
                   .progress = [&](const std::string&, double share) { control.report(share); },
                   .fresh = true});
  return read_campaign(folder);
}

}  // namespace trilat
