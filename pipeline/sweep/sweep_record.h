// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "datasets/results/sweep_summary.h"
#include "pipeline/items/shard.h"
#include "pipeline/sweep/sweep_totals.h"

namespace trilat {

// What a process has of a cell: sums over its chunks, or the cell as earlier results have it.
struct SweepRecord {
  std::size_t cell = 0;  // its number in the plan
  std::string key;
  Shard shard;               // whose chunks
  std::uint64_t chunks = 0;  // that are done, its first ones
  SweepTotals totals;
  struct Reused {
    std::string from;  // folder
    SweepCell cell;
  };
  std::optional<Reused> reused;  // then there are no sums
};

// One line, without its end: the hash of the rest, a space, and the rest.
std::string line_of(const SweepRecord& record);
// Nothing when the line is damaged or torn; InputError at `place` when it was written otherwise.
std::optional<SweepRecord> read_sweep_record(const std::string& line, const std::string& place);

}  // namespace trilat
