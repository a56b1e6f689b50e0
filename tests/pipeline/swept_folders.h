// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "datasets/base/files.h"
#include "pipeline/sweep/merge_sweep.h"
#include "tests/pipeline/sweeps.h"
#include "tests/support/scratch.h"

namespace trilat {

// All files of the two results are equal, those that hold times apart.
inline void expect_same_sweeps(const std::filesystem::path& a, const std::filesystem::path& b) {
  for (const char* file : {"summary.json", "manifest.json", "items.json"})
    EXPECT_EQ(read_file(a / file), read_file(b / file)) << b / file;
}

inline std::filesystem::path part_folder(const ScratchFolder& folder, const Shard& shard) {
  return folder / ("part" + std::to_string(shard.number) + "of" + std::to_string(shard.of));
}

inline std::vector<std::filesystem::path> run_shards(const SweepPlan& plan, const ScratchFolder& folder,
                                                     std::uint64_t shards,
                                                     const ExecuteSweepOptions& options = {}) {
  std::vector<std::filesystem::path> parts;
  for (std::uint64_t number = 1; number <= shards; ++number) {
    ExecuteSweepOptions of_shard = options;
    of_shard.work.shard = {number, shards};
    parts.push_back(part_folder(folder, of_shard.work.shard));
    execute_sweep(plan, parts.back(), of_shard);
  }
  return parts;
}

// Runs the sweep and leaves it when this share of it is done, by an exception: as little is written then as
// when the process is killed.
inline void run_and_drop(const SweepPlan& plan, const std::filesystem::path& output,
                         ExecuteSweepOptions options, double share) {
  struct Dropped {};
  options.progress = [&](double done) {
    if (done >= share) throw Dropped{};
  };
  EXPECT_THROW(execute_sweep(plan, output, options), Dropped);
}

}  // namespace trilat
