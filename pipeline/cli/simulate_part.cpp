// SPDX-License-Identifier: MIT
#include "pipeline/cli/simulate_part.h"

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/take/campaign.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/items/study_items.h"
#include "pipeline/parallel.h"
#include "pipeline/results_folder.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

Json json_of(const Take& take) {
  return {{"participant", take.participant},
          {"activity", take.activity},
          {"mocap_start_host_ns", take.mocap_start_host_ns},
          {"tracker_truth", !take.tracker_truth.empty()}};
}

Take read_take(const std::string& id, const Json& json, const fs::path& folder) {
  JsonObject object(json, id, "");
  Take take{id,
            object.text("participant"),
            object.text("activity"),
            folder / id / "session.h5",
            folder / "calibration.json",
            folder / id / "mocap.csv",
            folder / id / "mapping.json",
            object.integer("mocap_start_host_ns"),
            {}};
  if (object.boolean("tracker_truth", false)) take.tracker_truth = folder / id / "tracker_truth.h5";
  object.finish();
  return take;
}

void link_or_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (error) fs::copy_file(from, to, error);
  if (error)
    throw OutputError(to.string(),
                      "cannot be linked or copied from " + from.string() + ": " + error.message());
}

void link_files(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from))
    throw InputError(from.string(), "is missing, though its part says that it was made");
  make_folder(to);
  for (const fs::directory_entry& entry : fs::directory_iterator(from))
    link_or_copy(entry.path(), to / entry.path().filename());
}

std::vector<PartItem> items_of(const SimulationSpec& spec, const SimulatedCampaign& campaign) {
  std::vector<PartItem> items;
  const std::vector<double> costs = costs_of(spec, campaign);
  for (std::size_t r = 0; r < campaign.recordings(); ++r) items.push_back({campaign.id(r), costs[r]});
  return items;
}

}  // namespace

ItemTally simulate_part(const SimulationSpec& spec, const std::string& sha256, const Shard& shard,
                        const fs::path& output, const SimulatePartOptions& options) {
  const SimulatedCampaign campaign = simulated_campaign(spec);
  Kept kept{"items.jsonl"};
  for (std::size_t r = 0; r < campaign.recordings(); ++r) kept.push_back(campaign.id(r));
  const ResultsFolder folder(output, kept);
  StudyItems items(kCampaignPart, {{"simulation", spec.name}, {"sha256", sha256}}, items_of(spec, campaign),
                   folder.partial(), {shard, {}});
  write_rig(spec, campaign.rig, folder.partial());
  JointProgress progress(costs_of(spec, campaign), options.progress);
  const auto make = [&](std::size_t r) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    items.outcome(campaign.id(r), [&] {
      fs::remove_all(folder.partial() / campaign.id(r));
      const Take take =
          simulate_recording(spec, campaign, r, folder.partial(),
                             {options.stop_requested, [&](double share) { progress.set(r, share); }});
      return r < campaign.takes.size() ? json_of(take) : Json::object();
    });
    progress.set(r, 1.0);
  };
  parallel_for_index(campaign.takes.size(), 1, make);
  if (campaign.wand) make(campaign.takes.size());
  const ItemTally tally = items.tally();
  items.finish(folder.partial(), "");
  folder.put_in_place();
  return tally;
}

void merge_campaign(const std::vector<FoundPart>& parts, const fs::path& output) {
  if (fs::exists(output) && !(fs::is_directory(output) && fs::is_empty(output)))
    throw InputError(output.string(), "exists; recordings are never replaced. Choose another name");
  StudyItems items(parts);
  const FoundPart& first = parts.front();
  const ResultsFolder folder(output);
  Campaign campaign{first.part.work.at("simulation").get<std::string>(), true, {}, folder.partial()};
  for (const PartItem& item : first.part.items) {
    link_files(parts.at(item.shard - 1).folder / item.id, folder.partial() / item.id);
    if (const auto take = items.outcome(item.id, {}); !take->empty())
      campaign.takes.push_back(read_take(item.id, *take, folder.partial()));
  }
  for (const char* file : {"calibration.json", "simulator.json"})
    link_or_copy(first.folder / file, folder.partial() / file);
  write_campaign(folder.partial(), campaign);
  folder.put_in_place();
}

}  // namespace trilat
