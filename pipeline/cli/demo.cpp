// SPDX-License-Identifier: MIT
// `trilat demo`: a first page in seconds.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/campaign_study.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

struct DemoArguments {
  std::filesystem::path output = "out/demo";
  bool force = false;
  bool json = false;
};

constexpr std::uint64_t kParticipants = 6;  // the fewest without a warning that intervals are wide
constexpr double kDuration_s = 8.0;
// Quick, and every family once.
constexpr const char* kStudy = R"({
  "format": "trilat.study", "version": 1, "kind": "accuracy", "name": "demo", "alignments": ["mean", "none"],
  "methods": [{"method": "linear"}, {"method": "geometric"}, {"method": "nonlinear"}, {"method": "single"},
              {"method": "mean"}, {"method": "range_bearing"}, {"method": "rts"}],
  "reference": "nonlinear"})";

int demo(const DemoArguments& arguments) {
  const std::filesystem::path& folder = arguments.output;
  const std::filesystem::path campaign_folder = folder / "campaign", results = folder / "results",
                              report = folder / "report";
  const auto check = [&](const std::filesystem::path& path, OutputKind kind) {
    check_output({path, kind, {}, arguments.force});
  };
  check(folder, OutputKind::reproduction);
  check(campaign_folder, OutputKind::campaign);
  check(results, OutputKind::results);
  check(report, OutputKind::report);
  fmt::print(stderr, "simulating {} walkers of {:g} s before four sensors, into {}\n", kParticipants,
             kDuration_s, folder.string());
  SimulationSpec spec = parse_simulation(parse_json(embedded::paper_campaign_json, "the paper's campaign"),
                                         "the paper's campaign", {});
  spec.participants = kParticipants;
  std::erase_if(spec.activities, [](const ActivitySpec& a) { return a.activity != Activity::walking; });
  spec.activities.front().duration_s = kDuration_s;
  const Campaign campaign = [&] {
    Progress progress("simulating");
    return simulate_campaign(spec, campaign_folder, {stop_requested, [&](double s) { progress.set(s); }});
  }();
  const ResultsSummary summary = [&] {
    Progress progress("evaluating");
    return execute_study(parse_study(parse_json(kStudy, "demo"), "demo", {}), campaign, results,
                         {.stop_requested = stop_requested, .progress = [&](double s) { progress.set(s); }});
  }();
  const ReportFiles page = write_report({results}, report, {});
  if (arguments.json)
    fmt::print("{}\n", json_text(Json{{"campaign", campaign_folder.string()},
                                      {"results", results.string()},
                                      {"page", (report / "report.html").string()},
                                      {"answers", page.headline.answers}},
                                 2));
  else
    fmt::print("{}\npage:     {}\nnext: trilat run study.json --campaign your-campaign -o results\n",
               headline_text(page.headline), (report / "report.html").string());
  return summary.takes_failed == 0 ? kDone : kItemsFailed;
}

}  // namespace

void add_demo(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<DemoArguments>(
      app, code, "demo", "a first page in seconds: simulated walkers, their tables and the report", demo);
  verb.add_option("-o,--output", a.output, "folder of everything that is made")->capture_default_str();
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
