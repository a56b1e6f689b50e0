// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/skeleton/skeleton.h"
#include "datasets/take/up_axis.h"

namespace trilat {

// Which OptiTrack assets are which joint: the joint is the mean of the assets' positions. An asset
// is written as "name" or, where a name stands under two types, "type:name" (types: rigid_body,
// rigid_body_marker, marker, bone, bone_marker).
struct JointMapping {
  struct Entry {
    Joint joint;
    std::vector<std::string> assets;
  };
  std::vector<Entry> joints;
};

// mapping.json, format 1: {"joints": {"head": ["head_1", …], …}}. Unknown joints are refused with
// those known.
JointMapping read_mapping(const std::filesystem::path& path);
JointMapping parse_mapping(const Json& json, const std::string& place);
void write_mapping(const std::filesystem::path& path, const JointMapping& mapping);

// One recorded take: a session, the calibration of its sensors, the OptiTrack export and what is
// what in it; `mocap` and `mapping` are empty where there is no export. Paths are absolute or relative to the
// current directory once read.
struct Take {
  std::string id;
  std::string participant;
  std::string activity;
  std::filesystem::path session;
  std::filesystem::path calibration;
  std::filesystem::path mocap;
  std::filesystem::path mapping;
  // Mocap time of an instant = host time - this: the host clock's reading at the mocap's first
  // frame, in ns.
  std::int64_t mocap_start_host_ns = 0;
  // What the simulator knows about the body tracker; empty when there is none.
  std::filesystem::path tracker_truth{};
  UpAxis up_axis = UpAxis::automatic;  // of the mocap's world
  // The sensor whose tracked joints stand for the truth, and which no method sees; empty when mocap is the
  // truth. Not of a file: a study makes such takes.
  std::string left_out{};
};

// A folder of takes, described by its campaign.json (format 1), where paths are relative to the
// folder.
struct Campaign {
  std::string name;
  bool simulated = false;
  std::vector<Take> takes;
  std::filesystem::path folder{};  // where it was read from
};

// `path` is the folder or its campaign.json. Take ids must be unique and usable as names; files must lie in
// the folder unless others are allowed.
Campaign read_campaign(const std::filesystem::path& path, OutsidePaths outside = OutsidePaths::refused);
Campaign parse_campaign(const Json& json, const std::filesystem::path& file, OutsidePaths outside);
// Writes paths relative to `folder`, whatever they are.
void write_campaign(const std::filesystem::path& folder, const Campaign& campaign);

}  // namespace trilat
