// SPDX-License-Identifier: MIT
#include "pipeline/simulate/campaign_study.h"

#include <tbb/task_arena.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/simulate/simulate_take.h"
#include "pipeline/study/known_items.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

std::string item_of(const std::string& recording) { return std::string(kRecordings) + '/' + recording; }

// What campaign.json says of a take besides its files; nothing of the wand.
Json json_of(const Take& take) {
  return {{"participant", take.participant},
          {"activity", take.activity},
          {"mocap_start_host_ns", take.mocap_start_host_ns},
          {"up_axis", kUpAxisNames.at(static_cast<std::size_t>(take.up_axis))}};
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
            static_cast<UpAxis>(object.choice("up_axis", {kUpAxisNames.begin(), kUpAxisNames.end()}, 0))};
  object.finish();
  return take;
}

void link_files(const fs::path& item, const fs::path& recording) {
  make_folder(recording);
  const std::optional<StoredItem> stored = stored_item(item);
  if (!stored) throw InputError(item.string(), "is no recording of a part");
  for (const auto& [name, bytes] : stored->bytes) link_or_copy(item / name, recording / name);
}

void put_together(const std::string& name, const std::vector<std::string>& recordings,
                  const Outcomes& outcomes, const fs::path& folder) {
  Campaign campaign{name, true, {}, folder};
  for (const std::string& recording : recordings) {
    const auto found = outcomes.find(item_of(recording));
    if (found == outcomes.end())
      throw InputError(name, "has no recording \"" + recording + "\" in its parts");
    const Outcome& outcome = found->second;
    link_files(outcome.folder, folder / recording);
    if (const Json take = outcome.json(); !take.is_null())
      campaign.takes.push_back(read_take(recording, take, outcome.place(), folder));
  }
  write_campaign(folder, campaign);
}

}  // namespace

Study campaign_of_parts(const Json& json, const std::string& place) {
  JsonObject work(json, place, "/work");
  const std::string name = work.text("simulation");
  work.text("sha256");
  const std::vector<std::string> recordings = work.texts("recordings");
  work.finish();
  return {.kind = kCampaign,
          .work = json,
          .reduce = [=](const Outcomes& outcomes, const fs::path& folder, const Watch&) {
            put_together(name, recordings, outcomes, folder);
          }};
}

Study campaign_study(const SimulationSpec& spec, const std::string& sha256, const WatchedFiles& inputs) {
  const auto shared = std::make_shared<const SimulationSpec>(spec);
  const auto campaign = std::make_shared<const SimulatedCampaign>(simulated_campaign(spec));
  Json recordings = Json::array();
  for (std::size_t r = 0; r < campaign->recordings(); ++r) recordings.push_back(campaign->id(r));
  Study study = campaign_of_parts({{"simulation", spec.name}, {"sha256", sha256}, {"recordings", recordings}},
                                  spec.name);
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

Campaign simulate_campaign(const SimulationSpec& spec, const fs::path& folder, const Watch& watch) {
  run_study(campaign_study(spec, "", {}), folder,
            {.threads = tbb::this_task_arena::max_concurrency(),
             .stop_requested = watch.stop_requested,
             .progress = [&](const std::string&, double share) { watch.tell(share); },
             .fresh = true});
  return read_campaign(folder);
}

}  // namespace trilat
