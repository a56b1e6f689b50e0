// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/rig/campaign.h"

namespace trilat {

// Where `trilat init` looks for recordings.
struct TakeSearch {
  std::filesystem::path folder;
  std::string activity;  // of recordings that are called session.h5; empty: recorded, or simulated
  std::string up_axis;   // of the motion capture: y, z, or empty
};

struct FoundTake {
  Take take;
  std::size_t sensors = 0;
  bool simulated = false;
  std::string start = {};  // how its mocap's start was found
};

struct FoundTakes {
  std::vector<FoundTake> takes;
  std::vector<std::string> notes;
  Campaign calibration = {};  // its wand, stated distances and walls
  // Motion capture in folders without a recording that no take has; why files that end as sessions do are
  // none.
  std::vector<std::filesystem::path> mocap_apart = {};
  std::vector<std::string> unread = {};
};

// Finds the recordings below the folder that `known`, the campaign as it is, does not hold. Each comes with
// the calibration, the motion capture and the joints of other methods in its folder. Throws InputError
// when the folder holds no recording, or when a recording has no calibration.
FoundTakes find_takes(const TakeSearch& search, const Campaign& known);

}  // namespace trilat
