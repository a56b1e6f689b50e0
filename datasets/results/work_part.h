// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

inline constexpr std::uint64_t kMostShards = 100'000;

// One item of a work that several processes share.
struct PartItem {
  std::string id;           // plain names with '/' between them
  double cost = 1.0;        // estimated, in any unit that all items share
  std::uint64_t shard = 1;  // whose it is, from 1
};

// part.json (trilat.part, version 1): which share of a work a folder holds. What all parts of one work have
// in common is equal in them, number and files apart.
struct WorkPart {
  std::string kind;  // of the work: accuracy, threshold_sweep, …, campaign
  std::string build;
  std::uint64_t number = 1, of = 1;  // shard number/of
  Json work = Json::object();        // settings and plan
  std::vector<PartItem> items;       // of all shards, in the order of the work; empty when shards are stripes
};

void write_part(const std::filesystem::path& folder, const WorkPart& part);
// InputError when `folder` holds no finished part.
WorkPart read_part(const std::filesystem::path& folder);

struct FoundPart {
  std::filesystem::path folder;
  WorkPart part;
};

// Reads all and puts them in the order of their numbers. InputError when two do not belong together (which
// says in what they differ), one is there twice, or some are missing (which names them and their items).
std::vector<FoundPart> read_parts(std::span<const std::filesystem::path> folders);

}  // namespace trilat
