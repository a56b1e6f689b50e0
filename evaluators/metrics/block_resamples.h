// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace trilat {

struct ResampleOptions {
  std::size_t resamples = 2000;  // 0: no intervals
  std::uint64_t seed = 1;
};

// Resamples of data in two levels: as many clusters as there are are drawn with replacement, and within every
// drawn one as many of its blocks as it has, with replacement. Each draw is a function of the seed, the
// resample and its place alone.
struct BlockResamples {
  std::size_t clusters = 0;
  std::size_t resamples = 0;
  std::vector<std::size_t> first_block;     // by cluster, and one behind the last
  std::vector<std::uint16_t> drawn;         // cluster, by resample and place
  std::vector<std::size_t> first_weight;    // into `weights`, by resample and place, and one behind the last
  std::vector<std::uint16_t> block_weight;  // how often each block of the drawn cluster was drawn
};

// `cluster_of_block` does not fall and leaves no cluster out; fewer than 65,536 clusters and blocks a cluster
// (InternalError).
BlockResamples draw_resamples(const std::vector<std::size_t>& cluster_of_block,
                              const ResampleOptions& options);

}  // namespace trilat
