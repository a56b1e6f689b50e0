// SPDX-License-Identifier: MIT
// `trilat run` of a threshold sweep.
#include "datasets/base/error.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/sweep_text.h"
#include "pipeline/cli/verbs.h"

namespace trilat {

int run_sweep_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty())
    throw InputError("--campaign", "is of no use: a threshold sweep makes its own trials and needs none");
  if (!arguments.calibration.empty())
    throw InputError("--calibration", "is of no use: a threshold sweep places its own sensors");
  if (arguments.cross_check)
    throw InputError("--cross-check",
                     "is for studies of kind accuracy; a threshold sweep counts the digits "
                     "that agree with the exact minimum");
  const std::string place = arguments.study.string();
  const SweepPlan plan = make_sweep_plan(parse_sweep(study, place), place);
  ExecuteSweepOptions options;
  options.threads = arguments.threads;
  options.stop_requested = stop_requested;
  if (!arguments.shard.empty()) options.work.shard = parse_shard(arguments.shard, "--shard");
  options.work.reuse = arguments.reuse;
  options.fresh = arguments.fresh;
  if (arguments.dry_run) return print_sweep_plan(plan, options.work.shard, arguments.json);
  check_run_output(arguments, StudyKind::threshold_sweep);
  SweepOutcome outcome;
  {
    PartProgress progress;
    options.progress = [&](double share) { progress.set("sweeping", share); };
    options.timing_progress = [&](double share) { progress.set("timing", share); };
    outcome = execute_sweep(plan, arguments.output, options);
  }
  print_sweep(outcome, options.work.shard, arguments.json);
  note_sweep_tally(outcome);
  return outcome.summary.interrupted ? kItemsFailed : kDone;
}

}  // namespace trilat
