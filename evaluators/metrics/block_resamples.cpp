// SPDX-License-Identifier: MIT
#include "evaluators/metrics/block_resamples.h"

#include <algorithm>

#include "datasets/base/check.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

std::size_t pick(const RandomStream& random, std::uint32_t& draw, std::size_t count) {
  const auto picked = static_cast<std::size_t>(random.uniform(draw++) * static_cast<double>(count));
  return std::min(picked, count - 1);
}

}  // namespace

BlockResamples draw_resamples(const std::vector<std::size_t>& cluster_of_block,
                              const ResampleOptions& options) {
  BlockResamples result;
  result.first_block = {0};
  for (std::size_t b = 0; b < cluster_of_block.size(); ++b) {
    const std::size_t here = b == 0 ? 0 : cluster_of_block[b - 1];
    TRILAT_CHECK(cluster_of_block[b] == here || (b > 0 && cluster_of_block[b] == here + 1),
                 "blocks come cluster by cluster");
    if (b > 0 && cluster_of_block[b] != here) result.first_block.push_back(b);
  }
  if (!cluster_of_block.empty()) result.first_block.push_back(cluster_of_block.size());
  result.clusters = result.first_block.size() - 1;
  result.resamples = options.resamples;
  constexpr std::size_t kMost = 65'536;
  TRILAT_CHECK(result.clusters < kMost, "clusters can be numbered");
  result.first_weight = {0};
  for (std::size_t r = 0; r < options.resamples; ++r) {
    const RandomStream random{options.seed, Purpose::bootstrap, r};
    std::uint32_t draw = 0;
    for (std::size_t place = 0; place < result.clusters; ++place) {
      const std::size_t cluster = pick(random, draw, result.clusters);
      const std::size_t blocks = result.first_block[cluster + 1] - result.first_block[cluster];
      TRILAT_CHECK(blocks < kMost, "draws of a block can be counted");
      result.drawn.push_back(static_cast<std::uint16_t>(cluster));
      const std::size_t first = result.block_weight.size();
      result.block_weight.resize(first + blocks);
      for (std::size_t b = 0; b < blocks; ++b) ++result.block_weight[first + pick(random, draw, blocks)];
      result.first_weight.push_back(result.block_weight.size());
    }
  }
  return result;
}

}  // namespace trilat
