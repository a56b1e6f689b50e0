// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/results/work_part.h"
#include "pipeline/items/item_store.h"

namespace trilat {

// The key of an item of a study whose settings all its items depend on.
std::string key_in_study(const Json& study, const std::string& id);

struct OutcomeOptions {
  std::optional<Json> settings = {};  // all that the item depends on, where that is not the whole study
  ItemStore::Usable usable = {};      // of an outcome that is known
};

// The work items of a study that makes its own data: each is computed here, found done, or left to another
// shard. Outcomes are JSON documents.
class StudyItems {
 public:
  // `study`: settings that every item depends on; `items`: all there are, in the order of the study;
  // `folder`: the unfinished output.
  StudyItems(std::string kind, Json study, std::vector<PartItem> items, const std::filesystem::path& folder,
             const WorkOptions& options);
  // What the parts of a work hold: nothing is computed. InputError when an item is not there.
  explicit StudyItems(const std::vector<FoundPart>& parts);

  // The outcome of an item, from `compute` when it is this run's and not known; nothing when it is another
  // shard's. From any thread.
  std::optional<Json> outcome(const std::string& id, const std::function<Json()>& compute,
                              const OutcomeOptions& options = {});
  // Whether the item is this run's; all are when merging.
  bool has(const std::string& id) const;
  // Where the outcome of an item stands, for errors. From any thread.
  std::string place_of(const std::string& id) const;
  // Whether this run has all items, so that they can be put together.
  bool whole() const { return shard_.whole(); }
  // Whether work that belongs to no item (timing) is this run's.
  bool first() const { return shard_.number == 1; }
  // Whether items are only put together, of which nothing is to be told.
  bool merging() const { return !store_; }
  ItemTally tally() const { return store_ ? store_->tally() : ItemTally{}; }
  // Writes items.json with `key`, and part.json when this is a shard.
  void finish(const std::filesystem::path& folder, const std::string& key);

 private:
  std::string kind_;
  Json study_;
  std::vector<PartItem> items_;
  Shard shard_;
  std::unique_ptr<ItemStore> store_;   // none when merging
  std::filesystem::path merged_from_;  // the first of them
  mutable std::mutex mutex_;
  std::map<std::string, DoneItem> done_;
  std::map<std::string, std::filesystem::path> folder_of_;  // by item, where it was not computed here
};

// Whether `output` is asked for earlier results and holds those of this key, whole; then all items count as
// reused. `files`: what the study writes besides manifest.json, summary.json and run.json.
bool is_done_already(const std::filesystem::path& output, const WorkOptions& options, const std::string& key,
                     std::span<const PartItem> items, std::vector<const char*> files, ItemTally* tally);

}  // namespace trilat
