// SPDX-License-Identifier: MIT
// `trilat merge` of a threshold sweep.
#include "pipeline/sweep/merge_sweep.h"

#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/sweep_text.h"

namespace trilat {

int merge_threshold_sweep(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  SweepOutcome outcome;
  {
    Progress progress("merging");
    outcome =
        merge_sweep(parts, arguments.output, {stop_requested, [&](double share) { progress.set(share); }});
  }
  print_sweep(outcome, Shard{}, arguments.json);
  return kDone;
}

}  // namespace trilat
