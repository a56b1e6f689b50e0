// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/results/work_part.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/items/item_store.h"

namespace trilat {

inline constexpr const char* kWandPart = "wand_search";

// Searches one shard's share of the depth frames into a part folder; an item is a run of neighbouring frames
// of one sensor. What the part held already, finished or not, is not searched again.
ItemTally search_wand_part(const std::vector<std::filesystem::path>& files, WandMethod method,
                           const CalibrateWandOptions& options, const Shard& shard,
                           const std::filesystem::path& output, std::uint64_t frames_of_item = kFramesOfItem);

// What calibrate_wand() would have made of the same sessions. Needs the parts only.
WandCalibration merge_wand_parts(const std::vector<FoundPart>& parts);

}  // namespace trilat
