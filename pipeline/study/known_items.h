// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/study/study.h"

namespace trilat {

// Items that need not be computed again: those of the same run before it was stopped, and those of earlier
// outputs. All functions may be called from any thread.
class KnownItems {
 public:
  // `folder`: the unfinished output, of all items or of a part. InputError when one of `reuse` is no folder.
  KnownItems(const Study& study, const std::filesystem::path& folder,
             std::span<const std::filesystem::path> reuse, bool is_whole);

  struct Found {
    Outcome outcome;
    bool continued;  // it was here already
  };
  // Nothing when the item has to be computed. What is here of the item is removed unless it is what was
  // found.
  std::optional<Found> find(const std::string& id, const std::string& key);
  // The item of an earlier output in a folder of this one. Files are linked where the file system can.
  // `aside`: a folder that does not exist.
  Outcome bring_here(const std::string& id, const Outcome& found, const std::filesystem::path& aside) const;
  // InputError when an earlier output of which something was found was replaced since.
  void check_earlier() const;

 private:
  struct Earlier {
    std::filesystem::path folder;
    std::string written;  // what lists its items
    bool used = false;
    std::map<std::string, Json> gathered;  // outcomes by key
  };
  std::optional<Outcome> find_in(const Earlier& earlier, const std::string& id, const std::string& key) const;

  const Study& study_;
  std::filesystem::path folder_;
  bool is_whole_;
  std::vector<Earlier> earlier_;
  std::mutex mutex_;
};

// Links a large file; copies it where the file system cannot, or where it is small.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace trilat
