// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "pipeline/items/shard.h"

namespace trilat {

// Which chunks of a sweep are a shard's. Chunks are numbered over all cells; of every n in a row, from the
// first on, each shard has one. Which one turns from n to n by the golden section, so that shards also share
// evenly what repeats every so many chunks. No cost is estimated: a cell of many chunks is everybody's.
struct SweepStripe {
  Shard shard;
  std::uint64_t all_chunks = 0;

  // The chunk of the shard's turn, from 0; they increase.
  std::uint64_t chunk(std::uint64_t turn) const;
  // How many of the shard's chunks come before this one, at most all_chunks.
  std::uint64_t turns_before(std::uint64_t chunk) const;
  std::uint64_t turns() const { return turns_before(all_chunks); }
};

}  // namespace trilat
