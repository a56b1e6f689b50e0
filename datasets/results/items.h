// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/version.h"

namespace trilat {

// One item of work that was done. The key is a hash of all that decides the outcome: settings, inputs and the
// build of the program. Items of equal id and key have equal outcomes and files. An item that failed has an
// empty key, which equals no other.
struct DoneItem {
  std::string id, key;
  Json outcome;
  TRILAT_FIELDS(id, key, outcome)
};

// Items of an unfinished output, and of a part, have a folder each: item.json (trilat.item, version 1) and
// whatever files the item consists of.
inline constexpr const char* kItemsFolder = "items";
inline constexpr const char* kItemFile = "item.json";
std::filesystem::path item_folder(const std::filesystem::path& output, const std::string& id);

// Finishes an item whose other files lie in `made`, on the same file system: the item's folder below `output`
// is whole or not there, however the process ends.
void put_item(const std::filesystem::path& made, const std::filesystem::path& output, const DoneItem& item);

// What an item's folder says of it.
struct StoredItem : DoneItem {
  std::map<std::string, std::uint64_t> bytes;  // by the name of its files
  void check(const JsonObject& object) const;
  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(id, key) field("files", self.bytes);
    TRILAT_EACH(outcome)
  }
};
// Nothing when there is none; InputError when item.json is not one.
std::optional<StoredItem> stored_item(const std::filesystem::path& folder);
// The file of the item that is missing or has another size; empty when none.
std::filesystem::path damaged_file(const StoredItem& item, const std::filesystem::path& folder);

// items.json (trilat.items, version 2) of finished results, written last: what their items were, in their
// order, and which files lie beside it. Equal work gives equal bytes. `key`: of the results as a whole, or
// empty.
void write_items(const std::filesystem::path& results, const std::string& key, std::size_t count,
                 const std::function<DoneItem(std::size_t)>& item);
// Empty when there is no such file; InputError when it is not one of these.
std::vector<DoneItem> read_items(const std::filesystem::path& results);
// What it says of the whole, without reading the items. Empty when there is no such file; InputError when it
// is not one of these, or not whole.
struct ItemsHead {
  std::string key;
  std::map<std::string, std::optional<std::uintmax_t>> bytes;  // by file; none where equal work may differ
};
ItemsHead read_items_head(const std::filesystem::path& results);
bool has_all_files(const std::filesystem::path& results, const ItemsHead& head);
// Whether a file that is there has another size.
bool is_damaged(const std::filesystem::path& results, const ItemsHead& head);

inline constexpr std::uint64_t kMostShards = 100'000;

// One item of a work that several processes share.
struct PartItem {
  std::string id;           // plain names with '/' between them
  double cost = 1.0;        // estimated, in any unit that all items share
  std::uint64_t shard = 1;  // whose it is, from 1
  TRILAT_FIELDS(id, cost, shard)
};

// part.json (trilat.part, version 1): which share of a work a folder holds. What all parts of one work have
// in common is equal in them, number and files apart.
struct WorkPart {
  std::string kind;  // of the work: accuracy, threshold_sweep, …, campaign
  std::string build;
  std::uint64_t number = 1, of = 1;  // shard number/of
  Json work = Json::object();        // settings and plan
  std::vector<PartItem> items;       // of all shards, in the order of the work
  void check(const JsonObject& object) const;
  static void fields(auto& self, auto&& field) {
    field("program", std::string(kProgramVersion));
    TRILAT_EACH(kind, build) field("shard", self.number);
    field("shards", self.of);
    TRILAT_EACH(work, items)
  }
};

void write_part(const std::filesystem::path& folder, const WorkPart& part);
// InputError when `folder` holds no finished part.
WorkPart read_part(const std::filesystem::path& folder);

struct FoundPart {
  std::filesystem::path folder;
  WorkPart part;
};

// Reads all and puts them in the order of their numbers. InputError when two do not belong together (which
// says in what they differ), one is there twice, or some are missing (which names them and their items).
std::vector<FoundPart> read_parts(std::span<const std::filesystem::path> folders);

}  // namespace trilat
