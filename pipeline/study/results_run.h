// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "pipeline/study/study.h"

namespace trilat {

// One run of some items into a folder of results. Its methods are called in their order, by one thread:
// find_keys(), is_finished(), begin(), compute(), publish(). InputError when another run of all items fills
// the folder; Interrupted when asked to stop: the same run goes on from the items that are done.
class ResultsRun {
 public:
  struct Item {
    // Plain names with '/' between them. Items of equal first name are computed beside each other, other
    // names one after the other; the first name is shown with the progress.
    std::string id;
    double cost;  // estimated, in any unit that all items share
  };
  ResultsRun(std::filesystem::path results, std::vector<Item> items, const StudyOptions& options);

  // RunControl of one stage of the run.
  RunControl control(const std::string& stage) const;
  // Whether the run is of all items; else a shard's.
  bool is_whole() const { return options_.shard.whole(); }

  // Asks for the key of each item of this run, a hash of all that decides its outcome; empty when an input
  // cannot be read. From any thread.
  void find_keys(const std::function<std::string(std::size_t item, const RunControl& control)>& key_of);
  // Whether the results of this manifest, without its items, are there already; nothing is then left to do.
  bool is_finished(const Json& manifest);
  // The folder's results are those of this manifest from here on, and unfinished.
  void begin(const Json& manifest);
  // Finds items or computes them, each into an empty folder whose files become the item's. From any thread.
  void compute(const std::function<ComputedItem(std::size_t item, const std::filesystem::path& into,
                                                const RunControl& control)>& compute_item);
  const ItemResult& outcome(std::size_t item) const { return outcomes_.at(items_[item].id); }
  const Outcomes& outcomes() const { return outcomes_; }
  // Moves what is written into an empty folder into the results, the file `mark` last, and removes what
  // `is_earlier` of an earlier run; items that are not of this run go.
  void publish(const std::string& mark, const std::function<bool(const std::filesystem::path&)>& is_earlier,
               const std::function<void(const std::filesystem::path& into)>& write);
  // Publishes results: summary.json says that they are whole, run.json how they came about.
  void publish_results(const Json& manifest,
                       const std::function<void(const std::filesystem::path& into)>& write);

  ItemCounts tally() { return std::move(tally_); }

 private:
  Json with_items(Json manifest) const;
  void compute_stage(std::span<const std::size_t> items, const std::filesystem::path& aside,
                     const RunControl& control, const auto& compute_item);
  void take(std::size_t i, const std::filesystem::path& aside, const RunControl& control,
            const auto& compute_item);
  bool find(const Item& item, ItemResult& outcome);

  const std::filesystem::path results_;
  const std::vector<Item> items_;
  const StudyOptions& options_;
  std::optional<FolderLock> lock_;
  const RunningTime start_;
  const ItemStore store_;
  std::vector<std::string> keys_;  // by item; of other shards' none
  std::vector<std::size_t> mine_;  // items of this run
  std::mutex mutex_;
  Outcomes outcomes_;
  ItemCounts tally_;
  Json times_ = Json::object();
};

}  // namespace trilat
