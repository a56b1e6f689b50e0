// SPDX-License-Identifier: MIT
// `trilat reproduce`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/simulate_take.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/execute.h"
#include "reports/accuracy_tables.h"
#include "reports/render.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

constexpr std::uint64_t kQuickParticipants = 4;

SimulationSpec campaign_spec(const ReproduceArguments& arguments) {
  const Json json = parse_json(embedded::paper_campaign_json, "pipeline/studies/paper_campaign.json");
  SimulationSpec spec = parse_simulation(json, "pipeline/studies/paper_campaign.json", {});
  spec.seed = arguments.seed;
  if (arguments.scale == "quick") spec.participants = kQuickParticipants;
  return spec;
}

StudySpec table3_study() {
  return parse_study(parse_json(embedded::table3_json, "pipeline/studies/table3.json"),
                     "pipeline/studies/table3.json", {});
}

// The folder is ours to fill when it is new, empty or an earlier reproduction.
void check_output(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder)) ||
      fs::exists(folder / "campaign"))
    return;
  throw InputError(folder.string(),
                   "exists and is not an earlier reproduction; choose another name or remove it");
}

}  // namespace

int reproduce(const ReproduceArguments& arguments) {
  const std::filesystem::path folder = arguments.output;
  check_output(folder);
  const SimulationSpec spec = campaign_spec(arguments);
  fmt::print(stderr, "1/3 simulating {} participants ({} scale, seed {})\n", spec.participants,
             arguments.scale, spec.seed);
  Campaign campaign;
  {
    Progress progress("simulating");
    campaign =
        simulate_campaign(spec, folder / "campaign", stop_requested, [&](double s) { progress.set(s); });
  }
  fmt::print(stderr, "2/3 Table III: every method on every take, cross-checked with Ceres\n");
  ResultsSummary summary;
  {
    Progress progress("evaluating");
    summary = execute_study(table3_study(), campaign, folder / "table3",
                            {arguments.threads, true, stop_requested, [&](double s) { progress.set(s); }});
  }
  fmt::print(stderr, "3/3 writing the report\n");
  const ReportFiles report = write_report({folder / "table3"}, folder / "report");
  const bool passed = summary.takes_failed == 0 && (!summary.cross_check || summary.cross_check->passed());
  if (arguments.json) {
    const Json json{{"campaign", (folder / "campaign").string()},
                    {"results", {(folder / "table3").string()}},
                    {"report", (folder / "report" / "report.md").string()},
                    {"takes_failed", summary.takes_failed},
                    {"cross_check_passed", summary.cross_check && summary.cross_check->passed()}};
    fmt::print("{}\n", json_text(json, 2));
  } else {
    for (const Table& table : table3(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("cross-check with Ceres: worst difference {:.3g} m on {} samples\n",
               summary.cross_check->worst_m, summary.cross_check->samples);
    fmt::print("report:   {}\nresults:  {}\ncampaign: {}\n", (folder / "report" / "report.md").string(),
               (folder / "table3").string(), (folder / "campaign").string());
  }
  return passed ? kDone : kItemsFailed;
}

}  // namespace trilat
