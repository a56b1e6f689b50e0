// SPDX-License-Identifier: MIT
#include "pipeline/cli/simulate_part.h"

#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include "datasets/base/build_id.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/plain_name.h"
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

// What a recording is made of: its files by their sizes, and the take, where it is one.
Json outcome_of(const fs::path& recording, const Json& take) {
  Json files = Json::object();
  std::vector<fs::path> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(recording))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  for (const fs::path& name : names) files[name.string()] = fs::file_size(recording / name);
  Json outcome{{"files", files}};
  if (!take.empty()) outcome["take"] = take;
  return outcome;
}

// The names of the files that an outcome lists.
std::vector<std::string> files_in(const Json& outcome, const std::string& place) {
  JsonObject files = JsonObject(outcome, place, "").object("files");
  for (const std::string& name : files.keys())
    if (!is_plain_name(name)) files.refuse(name, "is no name of a file");
  return files.keys();
}

// Which file that an outcome lists is missing in the recording's folder or has another size; empty when none.
fs::path damaged_file(const Json& outcome, const fs::path& recording) {
  const std::vector<std::string> names = files_in(outcome, recording.string());
  JsonObject files = JsonObject(outcome, recording.string(), "").object("files");
  for (const std::string& name : names) {
    std::error_code error;
    if (fs::file_size(recording / name, error) != files.count(name) || error) return recording / name;
  }
  return {};
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

void link_files(const Json& outcome, const fs::path& from, const fs::path& to) {
  if (const fs::path file = damaged_file(outcome, from); !file.empty())
    throw InputError(
        file.string(),
        "is missing or has another size than its part says; remove the part and run its shard again");
  make_folder(to);
  for (const std::string& name : files_in(outcome, from.string())) link_or_copy(from / name, to / name);
}

std::vector<PartItem> items_of(const SimulationSpec& spec, const SimulatedCampaign& campaign,
                               const Shard& shard) {
  std::vector<PartItem> items;
  const std::vector<double> costs = costs_of(spec, campaign);
  const std::vector<std::uint64_t> owner = shards_of(costs, shard.of);
  for (std::size_t r = 0; r < campaign.recordings(); ++r)
    items.push_back({campaign.id(r), costs[r], owner[r]});
  return items;
}

// Whether `output` is just this part already. Its items tell, so that part.json may have been removed.
bool is_made(const fs::path& output, const WorkPart& wanted) {
  if (fs::exists(output / "part.json")) {
    const WorkPart there = read_part(output);
    if (there.kind != wanted.kind || there.number != wanted.number || there.of != wanted.of ||
        there.work != wanted.work || there.build != wanted.build)
      return false;
  }
  std::map<std::string, DoneItem> done;
  for (DoneItem& item : read_items(output).items) {
    std::string id = item.id;
    done[id] = std::move(item);
  }
  return std::all_of(wanted.items.begin(), wanted.items.end(), [&](const PartItem& item) {
    if (item.shard != wanted.number) return true;
    const auto found = done.find(item.id);
    return found != done.end() && found->second.key == key_in_study(wanted.work, item.id) &&
           damaged_file(found->second.outcome, output / item.id).empty();
  });
}

// What is there already is left alone, or refused unless `force`. Says whether it is there.
bool keep_made(const fs::path& output, const WorkPart& wanted, bool force, ItemTally& tally) {
  if (!fs::exists(output) || (fs::is_directory(output) && fs::is_empty(output))) return false;
  const bool made = fs::exists(output / "items.json") && is_made(output, wanted);
  if (!made && force) return false;
  if (!made)
    throw InputError(output.string(),
                     "exists and is not this part; recordings are never replaced. Choose another name, or "
                     "replace it with --force");
  if (!fs::exists(output / "part.json")) write_part(output, wanted);
  fs::remove(output / ItemJournal::kFile);  // when it could not be removed at the end
  for (const PartItem& item : wanted.items)
    if (item.shard == wanted.number) tally.reused.push_back(item.id);
  return true;
}

}  // namespace

ItemTally simulate_part(const SimulationSpec& spec, const std::string& sha256, const Shard& shard,
                        const fs::path& output, const SimulatePartOptions& options) {
  const SimulatedCampaign campaign = simulated_campaign(spec);
  const Json work{{"simulation", spec.name}, {"sha256", sha256}};
  const WorkPart wanted{kCampaignPart, build_id(), shard.number,
                        shard.of,      work,       items_of(spec, campaign, shard)};
  ItemTally tally;
  if (keep_made(output, wanted, options.force, tally)) return tally;
  Kept kept{ItemJournal::kFile};
  for (std::size_t r = 0; r < campaign.recordings(); ++r) kept.push_back(campaign.id(r));
  const ResultsFolder folder(output, kept);
  StudyItems items(kCampaignPart, work, wanted.items, folder.partial(), {shard, {}});
  write_rig(spec, campaign.rig, folder.partial());
  JointProgress progress(costs_of(spec, campaign), options.progress);
  const auto make = [&](std::size_t r) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    const fs::path recording = folder.partial() / campaign.id(r);
    items.outcome(campaign.id(r),
                  [&] {
                    fs::remove_all(recording);
                    const Take take = simulate_recording(
                        spec, campaign, r, folder.partial(),
                        {options.stop_requested, [&](double share) { progress.set(r, share); }});
                    options.inputs.check();
                    return outcome_of(recording, r < campaign.takes.size() ? json_of(take) : Json::object());
                  },
                  {.usable = [&](const ItemStore::Found& found) {
                    return damaged_file(found.outcome, recording).empty();
                  }});
    progress.set(r, 1.0);
  };
  parallel_for_index(campaign.takes.size(), 1, make);
  if (campaign.wand) make(campaign.takes.size());
  items.finish(folder.partial(), "");
  folder.put_in_place();
  return items.tally();
}

void merge_campaign(const std::vector<FoundPart>& parts, const fs::path& output) {
  const FoundPart& first = parts.front();
  JsonObject work(first.part.work, (first.folder / "part.json").string(), "/work");
  const std::string name = work.text("simulation");
  work.text("sha256");
  work.finish();
  StudyItems items(parts);
  const ResultsFolder folder(output);
  Campaign campaign{name, true, {}, folder.partial()};
  for (const PartItem& item : first.part.items) {
    const Json outcome = *items.outcome(item.id, {});
    link_files(outcome, parts.at(item.shard - 1).folder / item.id, folder.partial() / item.id);
    if (outcome.contains("take"))
      campaign.takes.push_back(read_take(item.id, outcome["take"], folder.partial()));
  }
  for (const char* file : {"calibration.json", "simulator.json"})
    link_or_copy(first.folder / file, folder.partial() / file);
  write_campaign(folder.partial(), campaign);
  folder.put_in_place();
}

}  // namespace trilat
