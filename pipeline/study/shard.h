// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace trilat {

// Which share of a work this process does.
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t of = 0;  // 0: the work is not divided; 1: it is, into one part
  bool whole() const { return of == 0; }
  bool operator==(const Shard&) const = default;
};

// "3/7"; InputError at `place` when it is not k/n with 1 <= k <= n.
Shard parse_shard(const std::string& text, const std::string& place);

std::string name_of(const Shard& shard);  // "3/7"

// Whose each item is, from 1 to `shards` (0 counts as 1): the dearest goes first, each to the shard that has
// least so far. Equal costs give equal shares on every machine. No shard has more than 4/3 of what the best
// division would give it (Graham 1969).
std::vector<std::uint64_t> shards_of(std::span<const double> costs, std::uint64_t shards);

}  // namespace trilat
