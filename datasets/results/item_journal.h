// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

// One item of work that was done. The key is a hash of all that decides the outcome: settings, inputs and the
// build of the program. Items of equal id and key have equal outcomes.
struct DoneItem {
  std::string id, key;
  Json outcome;
};

// What a run has done so far, in `folder`/items.jsonl of its unfinished output: one line an item, so that
// a run that was stopped, however it was, goes on from there.
class ItemJournal {
 public:
  static constexpr const char* kFile = "items.jsonl";

  // Opens the journal or begins one. Lines that are torn or were not written by us are left out.
  explicit ItemJournal(const std::filesystem::path& folder);
  ~ItemJournal();
  ItemJournal(const ItemJournal&) = delete;
  ItemJournal& operator=(const ItemJournal&) = delete;

  // The outcome of an item that was done with this key, or nothing.
  std::optional<Json> find(const std::string& id, const std::string& key) const;
  // From any thread; the item is on the disk when this returns. OutputError when it cannot be.
  void add(const DoneItem& item);
  // Nothing is known of the item any more, when this returns also on the disk: what lies beside the journal
  // for it may now be overwritten.
  void forget(const std::string& id);

 private:
  void append(const DoneItem& item);

  std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::map<std::string, DoneItem> items_;
  int file_ = -1;
};

// items.json (trilat.items, version 1) of a finished output: what its items were, in their order. Equal work
// gives equal bytes. `key`: of the output as a whole, or empty.
void write_items(const std::filesystem::path& folder, std::span<const DoneItem> items,
                 const std::string& key = {});
struct DoneItems {
  std::string key;
  std::vector<DoneItem> items;
};
// Empty when there is no such file; InputError when it is not one of these.
DoneItems read_items(const std::filesystem::path& folder);
// The key alone, without reading the items; empty when there is none.
std::string read_items_key(const std::filesystem::path& folder);

}  // namespace trilat
