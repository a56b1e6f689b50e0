// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/summary.h"

namespace trilat {

// What the page's replay of one take needs. `bytes` is a zlib stream of 16-bit little-endian millimetres
// (-32768: there is none) and then of bytes; each channel is all instants of one number, the first as it is
// and then differences modulo 2^16 (2^8). Channels, in order: x, y, z of every sensor's Kinect joints; of the
// truth of every evaluated joint; of the estimate of every joint and method; and the tracking states of the
// sensors' joints.
struct PackedReplay {
  std::string title;   // "walking, take p01-walking"
  std::string header;  // JSON: names, poses, rate, counts
  std::string bytes;
};

// One of each take that has a replay. InputError when that is not of the samples beside it.
std::vector<PackedReplay> packed_replays(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
