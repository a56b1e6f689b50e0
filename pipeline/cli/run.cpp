// SPDX-License-Identifier: MIT
// `trilat run`, and `trilat merge` of studies that make their own data.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "pipeline/cli/generated_studies.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/results_folder.h"
#include "reports/render.h"

namespace trilat {
namespace {

void refuse_what_is_of_no_use(const GeneratedKind& kind, const RunArguments& arguments) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: " + kind.no_campaign);
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
}

int print_results(const GeneratedKind& kind, const std::filesystem::path& output, Json document, bool json) {
  if (json) {
    document.update(Json{{"results", output.string()}, {"simulated", true}, {"interrupted", false}});
    fmt::print("{}\n", json_text(document, 2));
    return kDone;
  }
  for (const Table& table : kind.tables(output)) fmt::print("{}\n", markdown_of(table));
  fmt::print("results: {}\n", output.string());
  return kDone;
}

int run_generated(const GeneratedKind& kind, const RunArguments& arguments, const Json& json) {
  refuse_what_is_of_no_use(kind, arguments);
  const OpenedStudy opened = kind.open(arguments, json);
  if (arguments.dry_run) {
    fmt::print("{}\n", arguments.json ? json_text(opened.plan, 2) : opened.plan_text);
    return kDone;
  }
  check_run_output(arguments, kind.kind, opened.inputs);
  const WorkOptions work = work_options(arguments);
  ItemTally tally;
  try {
    PartProgress progress;
    tally = run_study(
        opened.study, arguments.output,
        {arguments.threads, stop_requested,
         [&](const std::string& stage, double share) { progress.set(stage, share); }, work, arguments.fresh});
  } catch (const Interrupted&) {
    tell_interrupted(partial_name(output_name(arguments.output)));
    return kItemsFailed;
  }
  tell_reuse(kind.items, tally);
  if (work.shard.whole()) return print_results(kind, arguments.output, tally_json(tally), arguments.json);
  print_part(arguments.output, work.shard, tally, arguments.json);
  return kDone;
}

}  // namespace

int merge_generated(const GeneratedKind& kind, const MergeArguments& arguments,
                    const std::vector<FoundPart>& parts) {
  const FoundPart& first = parts.front();
  const Study study = kind.of_parts(first.part.work, (first.folder / "part.json").string());
  {
    PartProgress progress;
    merge_parts(study, parts, arguments.output,
                {arguments.threads, stop_requested,
                 [&](const std::string& stage, double share) { progress.set(stage, share); }});
  }
  return print_results(kind, arguments.output, {{"parts", parts.size()}}, arguments.json);
}

int run(const RunArguments& arguments) {
  const Json json = read_json(arguments.study);
  if (!arguments.shard.empty()) parse_shard(arguments.shard, "--shard");
  const StudyKind kind = study_kind(json, arguments.study.string());
  if (arguments.memory_mb && kind != StudyKind::accuracy && kind != StudyKind::error_budget)
    throw InputError("--memory-mb", "is for studies of kind accuracy and error_budget; others need little");
  if (const GeneratedKind* generated = generated_kind(name_of(kind)))
    return run_generated(*generated, arguments, json);
  return kind == StudyKind::accuracy ? run_accuracy_study(arguments, json) : run_sweep_study(arguments, json);
}

}  // namespace trilat
