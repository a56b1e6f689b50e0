// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/item_journal.h"
#include "pipeline/items/shard.h"

namespace trilat {

// What a run computes, and what it may take from elsewhere.
struct WorkOptions {
  Shard shard;                               // all of it, or a part
  std::vector<std::filesystem::path> reuse;  // earlier outputs, asked in this order
};

// The key of an item: a hash of all that decides its outcome, the build of this program included.
std::string key_of_item(const Json& settings);

// What became of the items that this run was asked for.
struct ItemTally {
  std::vector<std::string> computed, continued, reused;  // ids, in the order in which they came
};
// As run.json has it.
Json json_of(const ItemTally& tally);

// Outcomes that need not be computed again: those of the same run before it was stopped, and those of earlier
// outputs. All functions may be called from any thread.
class ItemStore {
 public:
  // `folder`: the unfinished output.
  ItemStore(const std::filesystem::path& folder, std::span<const std::filesystem::path> reuse);

  // The outcome of an item and the folder it was in; nothing when it must be computed.
  struct Found {
    Json outcome;
    std::filesystem::path folder;
  };
  using Usable = std::function<bool(const Found&)>;
  // `usable`: asked whether a folder still holds what belongs to the outcome; without one all do. What an
  // earlier run left of the item in this folder is forgotten unless it is what was found.
  std::optional<Found> find(const std::string& id, const std::string& key, const Usable& usable = {});
  // An item that was computed; it is on the disk when this returns.
  void add(const std::string& id, const std::string& key, const Json& outcome);
  // For those who read files of an earlier output: InputError when it was replaced since this was made.
  void check_earlier() const;
  ItemTally tally() const;

 private:
  struct Earlier {
    std::filesystem::path folder;
    std::string written;  // its items.json
    bool used = false;
    std::map<std::string, DoneItem> items;
  };
  std::filesystem::path folder_;
  ItemJournal journal_;
  std::vector<Earlier> earlier_;
  mutable std::mutex mutex_;
  ItemTally tally_;
};

}  // namespace trilat
