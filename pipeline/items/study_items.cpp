// SPDX-License-Identifier: MIT
#include "pipeline/items/study_items.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/build_id.h"
#include "datasets/base/check.h"
#include "datasets/base/error.h"

namespace trilat {

std::string key_in_study(const Json& study, const std::string& id) {
  return key_of_item({{"study", study}, {"item", id}});
}

StudyItems::StudyItems(std::string kind, Json study, std::vector<PartItem> items,
                       const std::filesystem::path& folder, const WorkOptions& options)
    : kind_(std::move(kind)),
      study_(std::move(study)),
      items_(std::move(items)),
      shard_(options.shard),
      store_(std::make_unique<ItemStore>(folder, options.reuse)) {
  std::vector<double> costs;
  for (const PartItem& item : items_) costs.push_back(item.cost);
  const std::vector<std::uint64_t> owner = shards_of(costs, shard_.of);
  for (std::size_t i = 0; i < items_.size(); ++i) items_[i].shard = owner[i];
}

StudyItems::StudyItems(const std::vector<FoundPart>& parts)
    : kind_(parts.front().part.kind),
      study_(parts.front().part.work),
      items_(parts.front().part.items),
      merged_from_(parts.front().folder) {
  for (const FoundPart& found : parts)
    for (DoneItem& item : read_items(found.folder).items) {
      std::string id = item.id;
      done_[id] = std::move(item);
      folder_of_[id] = found.folder;
    }
  for (const PartItem& item : items_)
    if (!done_.contains(item.id))
      throw InputError(parts[item.shard - 1].folder.string(), "does not hold its item " + item.id);
}

std::optional<Json> StudyItems::outcome(const std::string& id, const std::function<Json()>& compute,
                                        const OutcomeOptions& options) {
  if (!store_) {
    const auto known = done_.find(id);
    if (known == done_.end())
      throw InputError(merged_from_.string(), "and the parts beside it do not hold the item " + id);
    return known->second.outcome;
  }
  if (!has(id)) return std::nullopt;
  const std::string key = options.settings ? key_of_item({{"settings", *options.settings}, {"item", id}})
                                           : key_in_study(study_, id);
  std::optional<ItemStore::Found> found = store_->find(id, key, options.usable);
  Json outcome = found ? std::move(found->outcome) : compute();
  if (!found) store_->add(id, key, outcome);
  const std::lock_guard lock(mutex_);
  if (found) folder_of_[id] = found->folder;
  done_[id] = {id, key, outcome};
  return outcome;
}

bool StudyItems::has(const std::string& id) const {
  if (!store_) return true;
  const auto item = std::find_if(items_.begin(), items_.end(), [&](const PartItem& i) { return i.id == id; });
  TRILAT_CHECK(item != items_.end(), "every item of a study is listed");
  return item->shard == shard_.number;
}

std::string StudyItems::place_of(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto known = folder_of_.find(id);
  return (known == folder_of_.end() ? "" : (known->second / "items.json").string() + ' ') + "item " + id;
}

void StudyItems::finish(const std::filesystem::path& folder, const std::string& key) {
  std::vector<DoneItem> done;
  for (const PartItem& item : items_)
    if (const auto found = done_.find(item.id); found != done_.end()) done.push_back(found->second);
  write_items(folder, done, key);
  if (!whole()) write_part(folder, {kind_, build_id(), shard_.number, shard_.of, study_, items_});
}

bool is_done_already(const std::filesystem::path& output, const WorkOptions& options, const std::string& key,
                     std::span<const PartItem> items, std::vector<const char*> files, ItemTally* tally) {
  const bool asked = std::find(options.reuse.begin(), options.reuse.end(), output) != options.reuse.end();
  if (!asked || !options.shard.whole() || read_items_key(output) != key) return false;
  files.insert(files.end(), {"manifest.json", "summary.json", "run.json"});
  for (const char* file : files)
    if (!std::filesystem::exists(output / file)) return false;
  if (std::filesystem::exists(output / ItemJournal::kFile)) return false;  // it could not be removed
  for (const PartItem& item : items)
    if (tally) tally->reused.push_back(item.id);
  return true;
}

}  // namespace trilat
