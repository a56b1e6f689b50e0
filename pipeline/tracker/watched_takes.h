// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "datasets/take/campaign.h"
#include "pipeline/study/watch.h"
#include "pipeline/tracker/measure_tracker.h"

namespace trilat {

struct WatchedCampaign {
  std::vector<WatchedTake> takes;
  std::vector<std::string> left_out;  // takes that cannot be used, each with why
};

// All takes of a campaign as measure_tracker() takes them, at 30 instants a second; left and right stay as
// sensors see them. The truth of a simulated campaign is exact, any other's is of markers; takes without
// mocap have none. InputError where no take is usable.
WatchedCampaign read_watched_takes(const Campaign& campaign, const Watch& watch);

}  // namespace trilat
