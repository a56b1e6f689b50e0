// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "datasets/results/item_journal.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/sweep/sweep_record.h"

namespace trilat {

// The cells of a sweep as items.json lists them. Their outcomes are in summary.json, in the same order.
std::vector<DoneItem> items_of(const SweepPlan& plan);

// Cells of finished sweeps, by their keys.
class EarlierCells {
 public:
  // Folders are asked in this order; one without items has none to give. InputError when one is no folder.
  explicit EarlierCells(std::span<const std::filesystem::path> folders);
  // Null when no folder has it; else good as long as this lives.
  const SweepRecord::Reused* find(const std::string& key);

 private:
  struct Earlier {
    std::filesystem::path folder;
    std::string written;  // its items.json
    std::size_t items = 0;
    std::map<std::string, std::size_t> number_of_key;
    std::vector<SweepRecord::Reused> cells;  // once one was asked for
  };
  std::vector<Earlier> earlier_;
};

}  // namespace trilat
