// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "pipeline/sweep/sweep_record.h"

namespace trilat {

// What a process has done of a sweep, in its unfinished folder: a line for every finished cell, in the order
// of the plan, and the cell that is open. However the process ends, the next one goes on from what was saved
// last.
class SweepLog {
 public:
  static constexpr const char* kFinished = "sums.jsonl";
  static constexpr const char* kOpen = "open.jsonl";

  explicit SweepLog(const std::filesystem::path& folder);

  // Gives out the finished cells in their order until one is damaged or not accepted, and forgets from there.
  void restore(const std::function<bool(SweepRecord&&)>& accept);
  // The cell that was open at the last save.
  std::optional<SweepRecord> open_cell() const;

  void add(const SweepRecord& finished);
  // All that was added, and the open cell if there is one, are on the disk when this returns.
  void save(const SweepRecord* open);

 private:
  void append_pending();

  std::filesystem::path finished_, open_;
  std::string pending_;  // lines
};

}  // namespace trilat
