// SPDX-License-Identifier: MIT
// `trilat run` for a study of kind error_budget.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/error_sources.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/execute_budget.h"
#include "pipeline/cli/part_progress.h"
#include "pipeline/cli/verbs.h"
#include "reports/budget_tables.h"
#include "reports/render.h"

namespace trilat {

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
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  BudgetSummary summary;
  {
    PartProgress progress;
    BudgetOptions options{arguments.threads, stop_requested,
                          [&](const std::string& part, double share) { progress.set(part, share); }};
    if (arguments.memory_mb) options.memory_bytes = *arguments.memory_mb * 1'000'000;
    summary = execute_budget(spec, arguments.output, options);
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text({{"results", arguments.output.string()}, {"simulated", true}}, 2));
  } else {
    for (const Table& table : budget_tables(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", arguments.output.string());
  }
  return kDone;
}

}  // namespace trilat
