// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/results/stored_take.h"

namespace trilat {

// The outcome of one item of a study: item.json (trilat.item, version 2) in a folder with whatever files
// the item consists of. The key is a hash of all that decides the outcome: settings, inputs and the build of
// the program. Items of equal key have equal outcomes and files.
struct StoredItem {
  std::string id, key;
  Json outcome;
  std::map<std::string, std::uint64_t> bytes;  // of its files, by name

  static void fields(auto& self, auto&& f) {
    f.format("trilat.item", 2);
    f("id", self.id, "key", self.key, "files", self.bytes, "outcome", self.outcome);
  }
  void check(const JsonPlace& place) const;
};

// The items of a study, in folders items/KEY of its results. An item is whole or not there, however a process
// ends, and several processes may put items at once.
class ItemStore {
 public:
  explicit ItemStore(const std::filesystem::path& results) : folder_(results / "items") {}

  std::filesystem::path folder(const std::string& key) const { return folder_ / key; }
  // The item of this key; nothing when there is none. InputError, which names the file, when one is cut, or
  // when the item is of another key than its folder says.
  std::optional<StoredItem> find(const std::string& key) const;
  // Takes an item whose files lie in `made`, a folder of a StagingFolder; one that is there is replaced.
  void put(const std::filesystem::path& made, StoredItem item) const;
  // Removes every other item, and what killed processes were making.
  void remove_all_but(const std::set<std::string>& keys) const;
  void remove_if_empty() const;
  // How many items there are.
  std::size_t size() const;

  // A folder in which one process makes items; removed at the end. What a killed process left is told from
  // what a running one is making by a lock.
  class StagingFolder {
   public:
    explicit StagingFolder(const ItemStore& store);
    ~StagingFolder();
    StagingFolder(const StagingFolder&) = delete;
    StagingFolder& operator=(const StagingFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

   private:
    std::filesystem::path path_;
    int folder_ = -1;
  };

 private:
  std::filesystem::path folder_;
};

// The keys of manifest.json that readers of results need.
struct Manifest {
  static constexpr bool kHasMore = true;
  struct Study {
    static constexpr bool kHasMore = true;
    std::string kind, name;
    static void fields(auto& self, auto&& f) { f("kind", self.kind, "name", self.name); }
  };
  struct Take {
    static constexpr bool kHasMore = true;
    std::string id, activity;
    static void fields(auto& self, auto&& f) { f("id", self.id, "activity", self.activity); }
  };
  struct Input {
    static constexpr bool kHasMore = true;
    std::string take, role, file;
    std::optional<std::string> sha256;  // none of a file that could not be read
    static void fields(auto& self, auto&& f) {
      f("take", self.take, "role", self.role);
      f("file", self.file, kMayLack);
      f("sha256", self.sha256, kMayLack);
    }
  };
  JsonPlace place{"", {}};
  std::string program, study_sha256, campaign, calibration;
  Study study;
  Json settings;  // the resolved study
  std::vector<std::string> rig;
  std::vector<Take> takes;
  std::vector<Input> inputs;
  std::map<std::string, std::optional<std::string>> items;  // keys; none of what failed or is not known yet

  static void fields(auto& self, auto&& f) {
    f.format("trilat.manifest", 2);
    f("program", self.program, "study", self.study, "study", self.settings, "items", self.items);
    f("study_sha256", self.study_sha256, kMayLack);
    f("campaign", self.campaign, kMayLack);
    f("calibration", self.calibration, kMayLack);
    f("rig", self.rig, kMayLack);
    f("takes", self.takes, kMayLack);
    f("inputs", self.inputs, kMayLack);
  }
};
// InputError when it is not one of this version.
Manifest read_manifest(const std::filesystem::path& results);
// InputError where the manifest and the summary beside it, of this kind, study and campaign, are of different
// runs. A campaign without a name is not compared.
void check_same_run(const Manifest& manifest, const std::string& kind, const std::string& study,
                    const std::string& campaign);
// "is unfinished: 3 of 16 items are there; …", or empty where the folder holds no unfinished results.
std::string unfinished_results(const std::filesystem::path& results);

// A take of the results of an accuracy study, in the order of the study.
struct ResultTake {
  std::string id, condition;     // condition: its activity
  std::filesystem::path folder;  // of its item; empty: it failed
};
// Reads the takes of finished results. InputError when the item of one is missing.
std::vector<ResultTake> result_takes(const std::filesystem::path& results);
StoredTake open_take(const ResultTake& take);

}  // namespace trilat
