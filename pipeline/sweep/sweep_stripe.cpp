// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_stripe.h"

#include "datasets/results/work_part.h"

namespace trilat {
namespace {

constexpr std::uint64_t kGoldenSection = 0x9E3779B97F4A7C15;  // times 2^-64
static_assert(kMostShards < std::uint64_t{1} << 32);

}  // namespace

std::uint64_t SweepStripe::chunk(std::uint64_t turn) const {
  const std::uint64_t share = turn * kGoldenSection >> 32;  // times 2^-32, of a whole turn
  const std::uint64_t rotated_by = share * shard.of >> 32;
  return turn * shard.of + (shard.number - 1 + rotated_by) % shard.of;
}

std::uint64_t SweepStripe::turns_before(std::uint64_t end) const {
  const std::uint64_t turn = end / shard.of;
  return chunk(turn) < end ? turn + 1 : turn;
}

}  // namespace trilat
