// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/results/gate_history.h"

namespace trilat {

// The studies of the baseline that would not be in it any more.
std::vector<std::string> studies_only_in_baseline(const std::filesystem::path& results,
                                                  const std::filesystem::path& baseline);

// Makes the results of `results` the baseline, with accepted.json beside them and without their items: copied
// aside, then exchanged
// in one step, so that there is always one whole baseline. A single results folder replaces just its study
// where the baseline holds several. InputError when the reason is empty, the results are not what
// find_results() takes, or `baseline` is a folder of something else.
AcceptedBaseline accept_results(const std::filesystem::path& results, const std::filesystem::path& baseline,
                                const std::string& reason, const std::string& time);

}  // namespace trilat
