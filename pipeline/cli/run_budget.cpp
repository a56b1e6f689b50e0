// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind error_budget.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/execute_budget.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/verbs.h"
#include "reports/budget_tables.h"
#include "reports/render.h"

namespace trilat {
namespace {

int print_results(const BudgetSummary& summary, const std::filesystem::path& output, Json document,
                  bool json) {
  if (json) {
    document.update(Json{{"results", output.string()}, {"simulated", true}});
    fmt::print("{}\n", json_text(document, 2));
  } else {
    for (const Table& table : budget_tables(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", output.string());
  }
  return kDone;
}

// That the study names; empty when it names none.
std::filesystem::path simulation_file(const RunArguments& arguments, const Json& study) {
  return study.contains("simulation") && study["simulation"].is_string()
             ? arguments.study.parent_path() / study["simulation"].get<std::string>()
             : std::filesystem::path();
}

}  // namespace

int run_budget_study(const RunArguments& arguments, const Json& study) {
  if (!arguments.campaign.empty() || !arguments.calibration.empty())
    throw InputError(
        arguments.campaign.empty() ? "--calibration" : "--campaign",
        "is of no use: an error budget simulates its own campaigns; name their simulation.json in the "
        "study, as \"simulation\"");
  if (arguments.cross_check) throw InputError("--cross-check", "is for studies of kind accuracy");
  const SimulationSpec paper =
      parse_simulation(parse_json(embedded::paper_campaign_json, "pipeline/studies/paper_campaign.json"),
                       "pipeline/studies/paper_campaign.json", {});
  const BudgetSpec spec =
      parse_budget(study, arguments.study.string(), arguments.study.parent_path(), paper, arguments.outside);
  if (arguments.dry_run) {
    if (arguments.json)
      fmt::print("{}\n", json_text({{"study", resolved_json(spec.study)},
                                    {"participants", spec.simulation.participants},
                                    {"campaigns", error_sources().size()}},
                                   2));
    else
      fmt::print("study {} (simulated): {} campaigns of {} participants, one for every source of error\n",
                 spec.study.name, error_sources().size(), spec.simulation.participants);
    return kDone;
  }
  check_run_output(arguments, ResultsKind::error_budget, {simulation_file(arguments, study)});
  ItemTally tally;
  const WorkOptions work = work_options(arguments);
  BudgetSummary summary;
  {
    PartProgress progress;
    BudgetOptions options{.threads = arguments.threads, .stop_requested = stop_requested};
    options.progress = [&](const std::string& part, double share) { progress.set(part, share); };
    options.work = work;
    options.fresh = arguments.fresh;
    options.tally = &tally;
    if (arguments.memory_mb) options.memory_bytes = *arguments.memory_mb * 1'000'000;
    summary = execute_budget(spec, arguments.output, options);
  }
  tell_reuse("sources of error", tally);
  if (!work.shard.whole()) {
    print_part(arguments.output, work.shard, tally, arguments.json);
    return kDone;
  }
  return print_results(summary, arguments.output, tally_json(tally), arguments.json);
}

int merge_budget_study(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  const BudgetSummary summary = merge_budget(parts, arguments.output, {.threads = arguments.threads});
  return print_results(summary, arguments.output, {{"parts", parts.size()}}, arguments.json);
}

}  // namespace trilat
