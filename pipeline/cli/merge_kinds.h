// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "datasets/results/work_part.h"
#include "pipeline/cli/verbs.h"

namespace trilat {

// `trilat merge` of each kind of work; the parts are complete, belong together and are in order.
int merge_accuracy(const MergeArguments& arguments, const std::vector<FoundPart>& parts);
int merge_simulated_campaign(const MergeArguments& arguments, const std::vector<FoundPart>& parts);
int merge_threshold_sweep(const MergeArguments& arguments, const std::vector<FoundPart>& parts);
int merge_wand_calibration(const MergeArguments& arguments, const std::vector<FoundPart>& parts);

}  // namespace trilat
