// SPDX-License-Identifier: MIT
// `trilat reproduce`.
#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/budget/budget_study.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/recording/recording_study.h"
#include "pipeline/sensitivity/sensitivity_study.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/study/machine.h"
#include "pipeline/sweep/sweep_study.h"
#include "reports/write_report.h"

namespace trilat {
namespace {

struct ReproduceArguments {
  std::filesystem::path output = "out/reproduce";
  std::string scale = "paper";
  std::uint64_t seed = 1;
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

// How much of each study is run; a study that asks for less stays as it is.
struct Scale {
  std::string name, takes;                                 // how long, on two processors
  std::string writes;                                      // how much; empty: not measured
  std::uint64_t participants;                              // of Tables II and III
  std::uint64_t sensor_participants, budget_participants;  // of the other campaigns
  std::uint64_t search_trials;                             // a cell
  std::uint64_t units, samples, near_samples, frames;      // of the calibration
  std::uint64_t distortion_frames, rigs;
  std::uint64_t recording_frames, recording_runs;
  std::uint64_t map_participants, map_rows, map_slices, map_steps;
};
constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
const std::vector<Scale> kScales{
    {"quick", "a minute", "0.3 GB", 4, 2, 1, 60, 2, 30, 10, 1, 50, 2, 1000, 2, 1, 2, 1, 3},
    {"paper", "two minutes", "0.7 GB", 16, 3, 2, 80, 16, 30, 10, 3, 200, 3, 3000, 4, 1, 5, 1, 4},
    {"full", "half an hour", "", kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll,
     kAll, kAll, kAll}};

// Every results folder, in the order of the report.
constexpr std::array kResults{"table3",
                              "table2",
                              "table1",
                              "table1_search",
                              "calibration",
                              "table4",
                              "sensors_different_heights",
                              "sensors_equal_heights",
                              "error_budget",
                              "sensitivity"};
constexpr std::array kCampaigns{"campaign", "campaign_different_heights", "campaign_equal_heights"};

class Reproduction {
 public:
  explicit Reproduction(const ReproduceArguments& arguments)
      : arguments_(arguments),
        scale_(*std::ranges::find(kScales, arguments.scale, &Scale::name)),
        folder_(arguments.output) {}

  // Everything that will be written, before the work begins.
  void check_outputs() const {
    const auto check = [&](const std::filesystem::path& path, OutputKind kind) {
      check_output({path, kind, {}, arguments_.force});
    };
    check(folder_, OutputKind::reproduction);
    for (const char* campaign : kCampaigns) check(folder_ / campaign, OutputKind::campaign);
    for (const char* results : kResults) check(folder_ / results, OutputKind::results);
    check(folder_ / "report", OutputKind::report);
  }

  void simulate() { campaign_ = simulated("campaign", paper_campaign()); }
  void table3() {
    table3_ = evaluated("table3", study_from(embedded::table3_json, "table3.json"), *campaign_, true);
  }
  void table2() { evaluated("table2", study_from(embedded::table2_json, "table2.json"), *campaign_, false); }

  // Two rigs of eight sensors, of which the study takes two to eight.
  void sensors() {
    for (const auto& [rig, text] :
         {std::pair{std::string("different_heights"), embedded::sensors_different_heights_json},
          {"equal_heights", embedded::sensors_equal_heights_json}}) {
      StudySpec study = study_from(embedded::sensors_json, "sensors.json");
      study.name += "_" + rig;
      const Campaign campaign = simulated(
          "campaign_" + rig, campaign_spec(text, "sensors_" + rig + ".json", scale_.sensor_participants));
      evaluated("sensors_" + rig, study, campaign, false);
    }
  }

  void budget() {
    BudgetSpec spec = parse_budget(json_of(embedded::error_budget_json, "error_budget.json"),
                                   "error_budget.json", {}, paper_campaign());
    spec.simulation.seed = arguments_.seed;
    lower(spec.simulation.participants, scale_.budget_participants);
    run("error_budget", budget_study(spec));
  }

  void table1() { run("table1", sweep_study(sweep_plan(embedded::table1_json, "table1.json", kAll))); }
  void search() {
    run("table1_search",
        sweep_study(sweep_plan(embedded::table1_search_json, "table1_search.json", scale_.search_trials)));
  }

  void calibration() {
    CalibrationSpec spec =
        parse_calibration_spec(json_of(embedded::calibration_json, "calibration.json"), "calibration.json");
    spec.seed = arguments_.seed;
    lower(spec.units, scale_.units);
    lower(spec.samples, scale_.samples);
    lower(spec.near_samples, scale_.near_samples);
    lower(spec.frames, scale_.frames);
    lower(spec.distortion_frames, scale_.distortion_frames);
    lower(spec.runs, scale_.rigs);
    run("calibration", calibration_study(spec));
  }

  void recording() {
    RecordingSpec spec = parse_recording_spec(json_of(embedded::table4_json, "table4.json"), "table4.json");
    spec.seed = arguments_.seed;
    lower(spec.frames, scale_.recording_frames);
    lower(spec.runs, scale_.recording_runs);
    run("table4", recording_study(spec));
  }

  void map() {
    SensitivitySpec spec = parse_sensitivity(json_of(embedded::sensitivity_json, "sensitivity.json"),
                                             "sensitivity.json", {}, {});
    spec.head.seed = arguments_.seed;
    lower(spec.head.participants, scale_.map_participants);
    lower(spec.head.rows, scale_.map_rows);
    if (spec.head.slices.size() > scale_.map_slices) spec.head.slices.resize(scale_.map_slices);
    for (auto& slice : spec.head.slices) lower(slice.steps, scale_.map_steps);
    run("sensitivity", sensitivity_study(spec));
    points_failed_ = failed_points(read_sensitivity_summary(folder_ / "sensitivity"));
  }

  void report() {
    Progress progress("report");
    report_ = write_report(results(), folder_ / "report",
                           {.paper = judge_paper(results()), .progress = [&](double s) { progress.set(s); }});
  }

  const std::string& takes() const { return scale_.takes; }
  const std::string& writes() const { return scale_.writes; }

  bool passed() const { return takes_failed_ == 0 && points_failed_ == 0 && table3_.cross_check_passed(); }

  void print() const {
    const std::filesystem::path page = folder_ / "report" / "report.html";
    if (!arguments_.json) {
      fmt::print("\n{}\nresults:  {}\ncampaign: {}\npage:     {}\n", headline_text(report_.headline),
                 folder_.string(), (folder_ / "campaign").string(), page.string());
      return;
    }
    std::vector<std::string> texts;
    for (const auto& path : results()) texts.push_back(path.string());
    const Json json{{"campaign", (folder_ / "campaign").string()},
                    {"results", texts},
                    {"report", (folder_ / "report" / "report.md").string()},
                    {"page", page.string()},
                    {"answers", report_.headline.answers},
                    {"takes_failed", takes_failed_},
                    {"campaigns_failed", points_failed_},
                    {"cross_check_passed", table3_.cross_check_passed()}};
    fmt::print("{}\n", json_text(json, 2));
  }

 private:
  template <class T>
  static void lower(T& value, std::uint64_t most) {
    if (static_cast<std::uint64_t>(value) > most) value = static_cast<T>(most);
  }
  static Json json_of(const char* text, const std::string& file) {
    return parse_json(text, "pipeline/studies/" + file);
  }
  static StudySpec study_from(const char* text, const std::string& file) {
    return parse_study(json_of(text, file), "pipeline/studies/" + file, {});
  }

  SimulationSpec campaign_spec(const char* text, const std::string& file, std::uint64_t participants) const {
    SimulationSpec spec = parse_simulation(json_of(text, file), "pipeline/studies/" + file, {});
    spec.seed = arguments_.seed;
    lower(spec.participants, participants);
    return spec;
  }
  SimulationSpec paper_campaign() const {
    return campaign_spec(embedded::paper_campaign_json, "paper_campaign.json", scale_.participants);
  }

  SweepPlan sweep_plan(const char* text, const std::string& file, std::uint64_t trials) const {
    SweepSpec spec = parse_sweep(json_of(text, file), "pipeline/studies/" + file);
    spec.seed = arguments_.seed;
    lower(spec.trials, trials);
    return make_sweep_plan(spec, "pipeline/studies/" + file);
  }

  Campaign simulated(const std::string& name, const SimulationSpec& spec) const {
    Progress progress("simulating");
    return simulate_campaign(spec, folder_ / name, {stop_requested, [&](double s) { progress.set(s); }});
  }

  ResultsSummary evaluated(const std::string& name, const StudySpec& study, const Campaign& campaign,
                           bool cross_check) {
    Progress progress("evaluating");
    ResultsSummary summary =
        execute_study(study, campaign, folder_ / name,
                      {arguments_.threads, cross_check, stop_requested, [&](double s) { progress.set(s); }});
    takes_failed_ += summary.takes_failed;
    return summary;
  }

  void run(const std::string& name, const Study& study) const {
    StageProgressBars progress;
    run_study(study, folder_ / name,
              {.threads = arguments_.threads,
               .stop_requested = stop_requested,
               .progress = [&](const std::string& stage, double share) { progress.set(stage, share); }});
  }

  std::vector<std::filesystem::path> results() const {
    std::vector<std::filesystem::path> paths;
    for (const char* name : kResults) paths.push_back(folder_ / name);
    return paths;
  }

  const ReproduceArguments& arguments_;
  Scale scale_;
  std::filesystem::path folder_;
  std::optional<Campaign> campaign_;
  ResultsSummary table3_;
  std::uint64_t takes_failed_ = 0, points_failed_ = 0;
  ReportFiles report_;
};

constexpr std::pair<const char*, void (Reproduction::*)()> kStages[] = {
    {"simulate the paper's campaign", &Reproduction::simulate},
    {"Table III: every method on every take, cross-checked with Ceres", &Reproduction::table3},
    {"Table II: with and without occlusion compensation", &Reproduction::table2},
    {"Table I: threshold against error and time", &Reproduction::table1},
    {"which reading of the paper gives its Table I", &Reproduction::search},
    {"calibration: the wand, a flat wall, whole rigs", &Reproduction::calibration},
    {"Table IV: clock errors, and what a frame costs", &Reproduction::recording},
    {"two to eight sensors, at different heights and at one", &Reproduction::sensors},
    {"the error budget: every source of error alone", &Reproduction::budget},
    {"where in a space of simulations the conclusions hold", &Reproduction::map},
    {"the report", &Reproduction::report}};

std::vector<std::string> reproduction_scales() {
  std::vector<std::string> names;
  for (const Scale& scale : kScales) names.push_back(scale.name);
  return names;
}

int reproduce(const ReproduceArguments& arguments) {
  Reproduction reproduction(arguments);
  reproduction.check_outputs();
  fmt::print(stderr, "reproducing the paper into {} ({} scale, seed {}): {} on two processors{}\n",
             arguments.output.string(), arguments.scale, arguments.seed, reproduction.takes(),
             reproduction.writes().empty() ? "" : ", writes " + reproduction.writes());
  for (std::size_t k = 0; k < std::size(kStages); ++k) {
    const auto start = std::chrono::steady_clock::now();
    on_threads(arguments.threads, [&](int) { (reproduction.*kStages[k].second)(); });
    const std::chrono::duration<double> took_s = std::chrono::steady_clock::now() - start;
    fmt::print(stderr, "{:2}/{} {:<64} {:6.1f} s\n", k + 1, std::size(kStages), kStages[k].first,
               took_s.count());
  }
  reproduction.print();
  return reproduction.passed() ? kDone : kItemsFailed;
}

}  // namespace

void add_reproduce(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<ReproduceArguments>(
      app, code, "reproduce",
      "everything: a simulated campaign after the paper, its studies, and the tables beside the paper's",
      reproduce);
  verb.add_option("-o,--output", a.output, "folder of everything that is made")->capture_default_str();
  verb.add_option("--scale", a.scale,
                  "quick: a look in a minute; paper: its 16 participants for Tables II and III, map and "
                  "calibration in small; full: 200 rigs and the large map too")
      ->check(CLI::IsMember(reproduction_scales()))
      ->capture_default_str();
  verb.add_option("--seed", a.seed, "of every random number")->capture_default_str();
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
