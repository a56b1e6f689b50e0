// SPDX-License-Identifier: MIT
#include "pipeline/study_part.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <span>

#include <nlohmann/json.hpp>

#include "datasets/base/build_id.h"
#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "pipeline/assemble.h"
#include "pipeline/items/file_identity.h"
#include "pipeline/manifest.h"
#include "pipeline/results_folder.h"
#include "pipeline/rig_gdop.h"
#include "pipeline/runner.h"
#include "pipeline/take_folder.h"
#include "pipeline/take_key.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// What the files of the takes are: the contents of those that planning reads whole, the sizes of the others,
// which only the shard reads whose take it is.
Json inputs_json(const Campaign& campaign, HashCache& hashes, const std::function<bool()>& stop_requested) {
  Json takes = Json::object();
  for (const Take& take : campaign.takes)
    for (const TakeFile& file : files_of(take)) {
      Json& entry = takes[take.id][file.role];
      entry["file"] = file.path.filename().string();
      if (file.path == take.calibration || file.path == take.mapping)
        entry["sha256"] = hashes.hash(file.path, stop_requested).sha256;
      else if (const auto identity = identity_of(file.path))
        entry["bytes"] = identity->bytes;
    }
  return takes;
}

Json parameters_json(const Campaign& campaign) {
  Json parameters = Json::array();
  for (const DeclaredParameter& p : read_declared_parameters(campaign.folder))
    parameters.push_back({p.name, p.value, p.unit, p.source});
  return parameters;
}

// What merging needs to know of the plan.
Json work_json(const Plan& plan, bool cross_check, Json inputs) {
  Json takes = Json::array(), joints = Json::array();
  for (const PlannedTake& t : plan.takes)
    takes.push_back({{"id", t.take.id},
                     {"participant", t.take.participant},
                     {"activity", t.take.activity},
                     {"mocap_start_host_ns", t.take.mocap_start_host_ns},
                     {"tracker_truth", !t.take.tracker_truth.empty()},
                     {"ok", t.ok},
                     {"instants", t.instants}});
  for (const Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  return {{"study", resolved_json(plan.study)},
          {"cross_check", cross_check},
          {"campaign", plan.campaign.name},
          {"campaign_simulated", plan.campaign.simulated},
          {"simulated", plan.simulated},
          {"rig", plan.rig},
          {"joints", joints},
          {"takes", takes},
          {"inputs", std::move(inputs)},
          {"parameters", parameters_json(plan.campaign)}};
}

PlannedTake read_planned_take(JsonObject& entry) {
  PlannedTake planned;
  planned.take.id = entry.text("id");
  planned.take.participant = entry.text("participant");
  planned.take.activity = entry.text("activity");
  planned.take.mocap_start_host_ns = entry.integer("mocap_start_host_ns");
  planned.ok = entry.boolean("ok", false);
  planned.instants = entry.count("instants");
  entry.boolean("tracker_truth", false);
  entry.finish();
  return planned;
}

// A plan that can be summarised, not run: it does not know the files of its takes.
struct PartPlan {
  Plan plan;
  bool cross_check = false;
};

void check_takes(const Plan& plan, std::span<const PartItem> items, const JsonObject& work) {
  const auto same = [](const PlannedTake& take, const PartItem& item) { return take.take.id == item.id; };
  if (!std::equal(plan.takes.begin(), plan.takes.end(), items.begin(), items.end(), same))
    work.refuse("takes", "must be the items, in their order");
}

PartPlan read_plan(const WorkPart& part, const std::string& place) {
  JsonObject work(part.work, place, "/work");
  PartPlan read;
  Plan& plan = read.plan;
  plan.study = parse_study(work.value("study"), place, {});
  plan.campaign.name = work.text("campaign");
  plan.campaign.simulated = work.boolean("campaign_simulated", false);
  plan.simulated = work.boolean("simulated", false);
  plan.rig = work.texts("rig");
  plan.methods = resolve_methods(plan.study, plan.rig);
  plan.reference = reference_of(plan.study, plan.methods);
  for (const std::string& name : work.texts("joints")) {
    const auto joint = joint_from_name(name);
    if (!joint) work.refuse("joints", "has \"" + name + "\", which is no joint");
    plan.joints.push_back(*joint);
  }
  for (JsonObject& entry : work.objects("takes")) {
    plan.takes.push_back(read_planned_take(entry));
    plan.campaign.takes.push_back(plan.takes.back().take);
  }
  check_takes(plan, part.items, work);
  if (!work.has("cross_check")) work.refuse("cross_check", "is missing");
  read.cross_check = work.boolean("cross_check", false);
  work.value("inputs");
  work.value("parameters");
  work.finish();
  return read;
}

// A part needs all its samples, so those of takes that are used again are taken over.
void bring_here(const Plan& plan, const std::filesystem::path& folder, std::size_t index,
                EvaluatedTake& take) {
  const std::filesystem::path here = own_folder(folder, plan.takes[index].take.id);
  if (!take.result.evaluated || take.folder == here) return;
  copy_samples(plan, index, take.folder, here);
  take.folder = here;
}

void put_part(const Plan& plan, const Shard& shard, std::vector<PartItem> items,
              const std::vector<std::size_t>& mine, const TakesRun& run, Json work,
              const std::filesystem::path& folder) {
  std::vector<DoneItem> done;
  const std::vector<DoneItem> all = items_of(plan, run.takes);
  for (const std::size_t t : mine) done.push_back(all[t]);
  write_items(folder, done);
  if (const auto map = rig_gdop(plan)) write_gdop_map(folder, *map);
  if (const auto parameters = read_declared_parameters(plan.campaign.folder); !parameters.empty())
    write_declared_parameters(folder, parameters);
  write_part(folder, {name_of(ResultsKind::accuracy), build_id(), shard.number, shard.of, std::move(work),
                      std::move(items)});
}

// Every take as its part has it.
std::vector<EvaluatedTake> takes_of_parts(const Plan& plan, const std::vector<FoundPart>& parts) {
  std::map<std::string, EvaluatedTake> by_id;
  for (const FoundPart& found : parts)
    for (DoneItem& item : read_items(found.folder).items)
      by_id[item.id] = {item.key, own_folder(found.folder, item.id),
                        read_take_result(item.outcome, (found.folder / "items.json").string())};
  std::vector<EvaluatedTake> takes;
  for (const PlannedTake& planned : plan.takes) {
    const auto found = by_id.find(planned.take.id);
    if (found == by_id.end())
      throw InputError(parts.front().folder.string(),
                       "and the other parts do not hold the take \"" + planned.take.id + '"');
    takes.push_back(std::move(found->second));
  }
  return takes;
}

}  // namespace

std::vector<PartItem> part_items(const Plan& plan, std::uint64_t shards) {
  std::vector<double> costs;
  for (const PlannedTake& take : plan.takes) costs.push_back(static_cast<double>(take.instants) + 1.0);
  const std::vector<std::uint64_t> owner = shards_of(costs, shards);
  std::vector<PartItem> items;
  for (std::size_t t = 0; t < costs.size(); ++t) items.push_back({plan.takes[t].take.id, costs[t], owner[t]});
  return items;
}

StudyPart run_study_part(const StudySpec& study, const Campaign& campaign, const Shard& shard,
                         const std::filesystem::path& output, const ExecuteOptions& options) {
  StudyPart part;
  HashCache hashes;
  for (const std::filesystem::path& earlier : options.reuse) hashes.load(earlier);
  on_threads(options.threads, [&](int threads) {
    const Clock::time_point start = Clock::now();
    Json inputs = inputs_json(takes_of(study, campaign), hashes, options.stop_requested);
    std::vector<FilesWritten> written;
    for (const Take& take : takes_of(study, campaign).takes) written.push_back(files_written(take));
    const Plan plan = make_plan(study, campaign);
    Json work = work_json(plan, options.cross_check, std::move(inputs));
    std::vector<PartItem> items = part_items(plan, shard.of);
    std::vector<std::size_t> mine;
    for (std::size_t t = 0; t < items.size(); ++t)
      if (items[t].shard == shard.number) mine.push_back(t);
    const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile, kTakesFolder},
                               name_of(ResultsKind::accuracy));
    ItemStore store(folder.partial(), options.reuse);
    TakesRun run =
        run_takes(plan, mine, {folder.partial(), store, hashes, std::move(written)},
                  {options.cross_check, options.stop_requested, options.progress, options.memory_bytes});
    for (const std::size_t t : mine) bring_here(plan, folder.partial(), t, run.takes[t]);
    put_part(plan, shard, std::move(items), mine, run, std::move(work), folder.partial());
    part = {mine.size(), 0, plan.takes.size(), store.tally(), {}};
    for (const std::size_t t : mine) {
      const TakeResult& result = run.takes[t].result;
      part.failed += result.evaluated ? 0 : 1;
      part.notes.insert(part.notes.end(), result.notes.begin(), result.notes.end());
    }
    // the parts would not belong together when this one alone could not read a take
    for (std::size_t t = 0; t < plan.takes.size(); ++t)
      if (const PlannedTake& other = plan.takes[t];
          !other.ok && !std::binary_search(mine.begin(), mine.end(), t))
        part.notes.push_back({other.take.id, true, other.place, other.problem});
    hashes.save(folder.partial());
    write_run_record(folder.partial(), run.times, seconds_since(start), threads, &part.tally);
    store.check_earlier();
    folder.put_in_place();
  });
  return part;
}

ResultsSummary merge_study(const std::vector<FoundPart>& parts, const std::filesystem::path& output,
                           const ExecuteOptions& options) {
  ResultsSummary summary;
  const FoundPart& first = parts.front();
  const std::string place = (first.folder / "part.json").string();
  on_threads(options.threads, [&](int threads) {
    const Clock::time_point start = Clock::now();
    const PartPlan read = read_plan(first.part, place);
    const Plan& plan = read.plan;
    const ResultsFolder folder(output);
    HashCache hashes;
    for (const FoundPart& part : parts) hashes.load(part.folder);
    const RunParts run{plan, takes_of_parts(plan, parts), read.cross_check,
                       read_declared_parameters(first.folder), read_gdop_map(first.folder)};
    StageTimes times;
    summary = assemble(run, folder.partial(), times,
                       {options.stop_requested, options.progress, options.memory_bytes});
    hashes.save(folder.partial());
    write_run_record(folder.partial(), times, seconds_since(start), threads, nullptr);
    folder.put_in_place();
  });
  return summary;
}

}  // namespace trilat
