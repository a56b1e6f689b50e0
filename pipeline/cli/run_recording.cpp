// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind recording.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/time_capture.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/recording_study/execute_recording.h"
#include "pipeline/results_folder.h"
#include "reports/render.h"
#include "reports/table4.h"

namespace trilat {
namespace {

int print_plan(const RecordingSpec& spec, bool json) {
  const std::uint64_t samples = spec.runs * spec.sensors * spec.frames;
  if (json) {
    fmt::print("{}\n", json_text({{"study", resolved_json(spec)}, {"samples_of_each_network", samples}}, 2));
    return kDone;
  }
  fmt::print(
      "study {} (simulated): {} networks, of each {} runs x {} sensors x {} frames; {} methods timed on {} "
      "frames\n",
      spec.name, spec.networks.size(), spec.runs, spec.sensors, spec.frames, spec.methods.size(),
      spec.frames);
  return kDone;
}

int print_results(const RecordingOutcome& outcome, const std::filesystem::path& output, Json document,
                  bool json) {
  const bool interrupted = outcome.summary.interrupted;
  const std::filesystem::path folder = interrupted ? partial_name(output_name(output)) : output;
  if (json) {
    document.update(Json{{"results", folder.string()}, {"simulated", true}, {"interrupted", interrupted}});
    fmt::print("{}\n", json_text(document, 2));
  } else {
    for (const Table& table : table4(outcome.summary, outcome.timings))
      fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", folder.string());
  }
  if (!interrupted) return kDone;
  tell_interrupted(folder);
  return kItemsFailed;
}

}  // namespace

int run_recording_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: a recording study simulates its own recordings");
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
  const RecordingSpec spec = parse_recording_spec(study, arguments.study.string());
  if (arguments.dry_run) return print_plan(spec, arguments.json);
  check_run_output(arguments, ResultsKind::recording);
  ItemTally tally;
  const WorkOptions work = work_options(arguments);
  RecordingOutcome outcome;
  {
    PartProgress progress;
    outcome = execute_recording(spec, arguments.output,
                                {arguments.threads, stop_requested,
                                 [&](const std::string& part, double share) { progress.set(part, share); },
                                 [&](const std::filesystem::path& folder, const RecordingHooks& hooks) {
                                   return time_capture(spec, folder, hooks);
                                 },
                                 work, arguments.fresh, &tally});
  }
  tell_reuse("items", tally);
  if (!work.shard.whole() && outcome.summary.interrupted) throw Interrupted();
  if (!work.shard.whole()) {
    print_part(arguments.output, work.shard, tally, arguments.json);
    return kDone;
  }
  return print_results(outcome, arguments.output, tally_json(tally), arguments.json);
}

int merge_recording_study(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  const RecordingOutcome outcome = merge_recording(parts, arguments.output, {.threads = arguments.threads});
  return print_results(outcome, arguments.output, {{"parts", parts.size()}}, arguments.json);
}

}  // namespace trilat
