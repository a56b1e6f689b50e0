// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/results/items.h"

namespace trilat {

// How many items an unfinished output holds, while another process may be writing it.
inline std::size_t finished_items(const std::filesystem::path& output) {
  std::size_t count = 0;
  std::error_code changed;
  for (std::filesystem::recursive_directory_iterator entry(output / kItemsFolder, changed), end;
       !changed && entry != end; entry.increment(changed))
    count += entry->path().filename() == kItemFile;
  return count;
}

// What equal runs need not have in common.
inline bool is_of_the_machine(const std::string& file) {
  return file == "run.json" || file == "hashes.json" || file == "timings.json";
}

inline std::set<std::string> files_in(const std::filesystem::path& folder) {
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(entry.path().lexically_relative(folder).string());
  return files;
}

// Two folders hold the same files with the same bytes, those of the machine apart.
inline void expect_same_results(const std::filesystem::path& one, const std::filesystem::path& other) {
  EXPECT_EQ(files_in(one), files_in(other));
  for (const std::string& file : files_in(one))
    if (!is_of_the_machine(file)) {
      EXPECT_TRUE(read_file(one / file) == read_file(other / file)) << other / file;
    }
}

}  // namespace trilat
