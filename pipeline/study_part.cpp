// SPDX-License-Identifier: MIT
#include "pipeline/study_part.h"

#include <algorithm>
#include <map>
#include <span>

#include <nlohmann/json.hpp>

#include "datasets/base/build_id.h"
#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "pipeline/assemble.h"
#include "pipeline/items/file_identity.h"
#include "pipeline/manifest.h"
#include "pipeline/part_plan.h"
#include "pipeline/results_folder.h"
#include "pipeline/rig_gdop.h"
#include "pipeline/runner.h"
#include "pipeline/take_folder.h"
#include "pipeline/take_key.h"
#include "pipeline/watch.h"

namespace trilat {
namespace {

constexpr double kRunShare = 0.9;  // of the progress; the rest is summaries

// What the files of the takes are: the contents of those that planning reads whole, the sizes of the others,
// which only the shard reads whose take it is.
Json inputs_json(const Campaign& campaign, HashCache& hashes, const std::function<bool()>& stop_requested) {
  Json takes = Json::object();
  for (const Take& take : campaign.takes)
    for (const TakeFile& file : files_of(take)) {
      Json& entry = takes[take.id][file.role];
      entry["file"] = file.path.filename().string();
      // looked at twice: what fails for a moment must not set this part apart from the others
      if (file.path == take.calibration || file.path == take.mapping) {
        HashedFile hashed = hashes.hash(file.path, stop_requested);
        if (hashed.sha256.empty()) hashed = hashes.hash(file.path, stop_requested);
        entry["sha256"] = hashed.sha256;
      } else if (auto identity = identity_of(file.path); identity || (identity = identity_of(file.path))) {
        entry["bytes"] = identity->bytes;
      }
    }
  return takes;
}

// What takes were summarised for: parts with the same work belong together.
std::string summary_key(const Json& work) { return hash_of_text(json_text(work, -1)); }

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
  write_part(folder, {name_of(StudyKind::accuracy), build_id(), shard.number, shard.of, std::move(work),
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
    const RunningTime start;
    std::vector<WatchedFiles> watched;
    for (const Take& take : takes_of(study, campaign).takes) watched.push_back(watched_files(take));
    Json inputs = inputs_json(takes_of(study, campaign), hashes, options.stop_requested);
    const Plan plan = make_plan(study, campaign);
    Json work = part_work(plan, options.cross_check, std::move(inputs));
    std::vector<PartItem> items = part_items(plan, shard.of);
    std::vector<std::size_t> mine;
    for (std::size_t t = 0; t < items.size(); ++t)
      if (items[t].shard == shard.number) mine.push_back(t);
    const ResultsFolder folder(output, options.fresh ? Kept{} : Kept{ItemJournal::kFile, kTakesFolder});
    ItemStore store(folder.partial(), options.reuse);
    TakesRun run = run_takes(plan, mine, {folder.partial(), store, hashes, std::move(watched)},
                             {options.cross_check, options.stop_requested,
                              share_of(options.progress, 0.0, kRunShare), options.memory_bytes});
    std::vector<std::size_t> evaluated;
    for (const std::size_t t : mine) {
      bring_here(plan, folder.partial(), t, run.takes[t]);
      if (run.takes[t].result.evaluated) evaluated.push_back(t);
    }
    summarise_takes(plan, evaluated, folder.partial(), summary_key(work), run.times,
                    {options.stop_requested, share_of(options.progress, kRunShare, 1.0 - kRunShare)});
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
    write_run_record(folder.partial(), run.times, start.seconds(), threads, &part.tally);
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
    const RunningTime start;
    const PartPlan read = read_part_plan(first.part, place);
    const Plan& plan = read.plan;
    const ResultsFolder folder(output);
    HashCache hashes;
    for (const FoundPart& part : parts) hashes.load(part.folder);
    const RunParts run{plan,
                       takes_of_parts(plan, parts),
                       read.cross_check,
                       read_declared_parameters(first.folder),
                       read_gdop_map(first.folder),
                       summary_key(first.part.work)};
    StageTimes times;
    summary = assemble(run, folder.partial(), times,
                       {options.stop_requested, options.progress, options.memory_bytes});
    hashes.save(folder.partial());
    write_run_record(folder.partial(), times, start.seconds(), threads, nullptr);
    folder.put_in_place();
  });
  return summary;
}

}  // namespace trilat
