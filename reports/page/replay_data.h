// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// The data for the replay of one take, as JSON: names, the skeleton, counts, and `points` in base64, which is
// a zlib stream of 16-bit little-endian millimetres (-32768: there is none). Each channel is all instants of
// one number, the first as it is and then differences modulo 2^16. Channels, in order: x, y, z of
// the truth of every evaluated joint; of every method's estimate of these joints.
struct PackedReplay {
  std::string title;  // "table3: walking, take p01-walking"
  std::string json;
};

// The first evaluated take of each condition: of its first 35 s at most 15 instants a second, with the truth,
// the study's reference, the best method, nonlinear and mean.
std::vector<PackedReplay> packed_replays(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
