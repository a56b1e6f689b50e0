// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "datasets/results/work_part.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/items/file_identity.h"
#include "pipeline/items/item_store.h"

namespace trilat {

inline constexpr const char* kCampaignPart = "campaign";

struct SimulatePartOptions {
  std::function<bool()> stop_requested = {};
  std::function<void(double)> progress = {};
  WatchedFiles inputs = {};  // that the simulation was read from
  bool force = false;        // another part may be replaced
};

// Makes one shard's recordings of a simulated campaign into a part folder, each in a folder of its own. A
// part that was stopped goes on. `sha256`: of the documents that the simulation was read from.
ItemTally simulate_part(const SimulationSpec& spec, const std::string& sha256, const Shard& shard,
                        const std::filesystem::path& output, const SimulatePartOptions& options);

// Puts the parts' recordings into one campaign, as one simulation would have made it, to the byte. Files are
// linked where the file system can, else copied; the parts stay as they are. What
// stands under the name of `output` is replaced.
void merge_campaign(const std::vector<FoundPart>& parts, const std::filesystem::path& output);

}  // namespace trilat
