// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "pipeline/sweep/sweep_block.h"

namespace trilat {

// Chunks that are computed side by side and then added up in order, with room for their sums.
class SweepWave {
 public:
  SweepWave(const SweepPlan& plan, const std::function<bool()>& stop_requested);

  struct Chunk {
    std::size_t cell = 0;
    std::uint64_t first_trial = 0;
    SweepSums sums;
    bool done = false;
  };
  void clear() { count_ = 0; }
  bool full() const { return count_ == size_; }
  bool empty() const { return count_ == 0; }
  void add(std::size_t cell, std::uint64_t first_trial);

  // Those that are done are, but for the last few, the first ones. Calls chunk_done() from any thread. The
  // next wave is larger when this one was over soon, or smaller.
  void compute(const std::function<void()>& chunk_done);
  const Chunk& operator[](std::size_t i) const { return chunks_[i]; }
  std::size_t count() const { return count_; }

 private:
  bool stop() const { return stop_requested_ && stop_requested_(); }
  void compute(Chunk& chunk);

  const SweepPlan& plan_;
  const std::function<bool()>& stop_requested_;
  std::vector<Chunk> chunks_;
  std::size_t least_, size_, count_ = 0;
  SweepBlocks blocks_;
};

}  // namespace trilat
