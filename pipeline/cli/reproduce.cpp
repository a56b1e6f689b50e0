// SPDX-License-Identifier: MIT
// `trilat reproduce` and `trilat demo`.
#include <algorithm>
#include <array>
#include <chrono>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/results/summary.h"
#include "pipeline/claims/judge_claims.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/study/study.h"
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

// A study on a campaign, each of which is built in. A study that makes its own campaigns holds their
// simulation.
struct Part {
  const char* what;
  const char* results;  // the folder
  const char* study;
  const char* campaign = "";  // the folder
  const char* name = "";      // of the study, instead of its own
  bool cross_check = false;
};
constexpr std::array kParts{
    Part{"Table III: every method on every take, cross-checked with Ceres", "table3", "table3", "campaign",
         "", true},
    Part{"Table III stage by stage: the paper's system end to end", "table3_stages", "table3_stages",
         "campaign_stages"},
    Part{"Table II: with and without occlusion compensation", "table2", "table2", "campaign"},
    Part{"Table I: threshold against error and time", "table1", "table1"},
    Part{"calibration: a ball at stated distances, the wand, a flat wall", "calibration", "calibration",
         "campaign_calibration"},
    Part{"Table IV: clock errors, and frames in time", "clocks", "clocks", "campaign_clocks"},
    Part{"two to eight sensors at different heights", "sensors_different_heights", "sensors",
         "campaign_different_heights", "sensors_different_heights"},
    Part{"two to eight sensors at one height", "sensors_equal_heights", "sensors", "campaign_equal_heights",
         "sensors_equal_heights"}};

struct Simulated {
  const char *folder, *simulation;
};
constexpr std::array kCampaigns{Simulated{"campaign", "paper_campaign"},
                                Simulated{"campaign_stages", "stages_campaign"},
                                Simulated{"campaign_clocks", "clocks_campaign"},
                                Simulated{"campaign_calibration", "calibration_campaign"},
                                Simulated{"campaign_different_heights", "sensors_different_heights"},
                                Simulated{"campaign_equal_heights", "sensors_equal_heights"}};

// How long it takes on two processors, and how much it writes; empty: not measured.
struct Cost {
  const char *scale, *takes, *writes;
};
constexpr std::array kCosts{Cost{"demo", "some seconds", "0.05 GB"}, Cost{"quick", "a minute", "0.9 GB"},
                            Cost{"paper", "two minutes", "2.2 GB"}, Cost{"full", "half an hour", ""}};

class Reproduction {
 public:
  explicit Reproduction(const ReproduceArguments& arguments)
      : arguments_(arguments), folder_(arguments.output) {}

  bool is_demo() const { return arguments_.scale == kScales.front(); }
  // A demo shows the first.
  std::span<const Part> parts() const { return std::span(kParts).first(is_demo() ? 1 : kParts.size()); }

  // Everything that will be written, before the work begins.
  void check_outputs() const {
    const auto check = [&](const std::filesystem::path& path, const OutputMark& mark) {
      check_output_folder({path, {}, arguments_.force}, mark);
    };
    check(folder_, kMark);
    for (const Part& part : parts()) {
      if (*part.campaign) check(folder_ / part.campaign, campaign_mark(part.campaign));
      check(folder_ / part.results, results_mark(part));
    }
    check(folder_ / "report", report_mark());
    mark_output(folder_, kMark);
  }

  void do_part(const Part& part) {
    if (*part.campaign && std::ranges::find(simulated_, part.campaign) == simulated_.end())
      simulate(part.campaign);
    const Json study = study_of(part);
    RunArguments run;
    run.study = std::string(part.study) + ".json";
    run.output = folder_ / part.results;
    run.threads = arguments_.threads;
    run.cross_check = part.cross_check;
    if (*part.campaign) run.campaign = folder_ / part.campaign;
    const OpenedStudy opened = find_kind(study.at("kind").get<std::string>())->open(run, study);
    mark_output(run.output, results_mark(part));
    StageProgressBars progress;
    on_threads(arguments_.threads, [&](int) {
      opened.run({.stop_requested = stop_requested,
                  .progress = [&](const std::string& stage, double share) { progress.set(stage, share); }});
    });
    count_failures(run.output);
  }

  void report() {
    mark_output(folder_ / "report", report_mark());
    Progress progress("report");
    report_ = write_report(results(), folder_ / "report",
                           {.paper = is_demo() ? std::nullopt : judge_paper(results()),
                            .progress = [&](double s) { progress.set(s); }});
    if (is_demo()) write_file(own_study(), json_text(study_of(kParts.front()), 2) + "\n");
  }

  bool passed() const { return takes_failed_ == 0 && cross_check_passed_; }

  void print() const {
    const std::filesystem::path page = folder_ / "report" / "report.html", campaign = folder_ / "campaign";
    if (arguments_.json) {
      std::vector<std::string> texts;
      for (const auto& path : results()) texts.push_back(path.string());
      const Json json{{"campaign", campaign.string()},
                      {"results", texts},
                      {"report", (folder_ / "report" / "report.md").string()},
                      {"page", page.string()},
                      {"answers", report_.headline.answers},
                      {"takes_failed", takes_failed_},
                      {"cross_check_passed", cross_check_passed_}};
      fmt::print("{}\n", json_text(json, 2));
      return;
    }
    fmt::print("\n");
    if (is_demo())
      print_stored(results().front());
    else
      fmt::print("{}\n", headline_text(report_.headline));
    fmt::print("results:  {}\ncampaign: {}\npage:     {}\n", folder_.string(), campaign.string(),
               page.string());
    if (is_demo())
      fmt::print("next: change {} and trilat run {} --campaign {} -o {}\n", own_study().string(),
                 shell_word(own_study().string()), shell_word(campaign.string()),
                 shell_word((folder_ / "own").string()));
  }

 private:
  inline static const OutputMark kMark{"reproduce", {}};
  static Json simulation_of(const std::string& campaign, const std::string& scale) {
    return built_in_campaign(std::ranges::find(kCampaigns, campaign, &Simulated::folder)->simulation, scale);
  }
  OutputMark campaign_mark(const std::string& campaign) const {
    return {"simulate", {simulation_of(campaign, arguments_.scale).at("name").get<std::string>()}};
  }
  OutputMark results_mark(const Part& part) const {
    const std::string campaign = *part.campaign ? campaign_mark(part.campaign).names.front() : std::string();
    return {"run", {study_of(part).at("name").get<std::string>()}, campaign};
  }
  OutputMark report_mark() const {
    OutputMark mark{"report", {}};
    for (const Part& part : parts()) mark.names.push_back(study_of(part).at("name").get<std::string>());
    return mark;
  }

  std::filesystem::path own_study() const { return folder_ / "study.json"; }

  Json study_of(const Part& part) const {
    Json study = built_in_study(part.study, arguments_.scale);
    if (*part.name) study["name"] = part.name;
    if (!*part.campaign) study["seed"] = arguments_.seed;
    return study;
  }

  void simulate(const std::string& name) {
    Json json = simulation_of(name, arguments_.scale);
    json["seed"] = arguments_.seed;
    mark_output(folder_ / name, campaign_mark(name));
    Progress progress("simulating");
    simulate_campaign(parse_simulation(json, name, {}), folder_ / name,
                      {stop_requested, [&](double s) { progress.set(s); }});
    simulated_.push_back(name);
  }

  void count_failures(const std::filesystem::path& results) {
    if (results_kind(results) != StudyKind::accuracy) return;
    const ResultsSummary summary = read_results<ResultsSummary>(results);
    takes_failed_ += summary.takes_failed;
    if (!summary.cross_checks.empty()) cross_check_passed_ = summary.cross_check_passed();
  }

  std::vector<std::filesystem::path> results() const {
    std::vector<std::filesystem::path> paths;
    for (const Part& part : parts()) paths.push_back(folder_ / part.results);
    return paths;
  }

  const ReproduceArguments& arguments_;
  std::filesystem::path folder_;
  std::vector<std::string> simulated_;
  std::uint64_t takes_failed_ = 0;
  bool cross_check_passed_ = false;
  ReportFiles report_;
};

int reproduce(const ReproduceArguments& arguments) {
  Reproduction reproduction(arguments);
  reproduction.check_outputs();
  const Cost& cost = *std::ranges::find(kCosts, arguments.scale, &Cost::scale);
  const std::string writes = *cost.writes ? fmt::format(", writes {}", cost.writes) : "";
  fmt::print(stderr, "reproducing the paper into {} ({} scale, seed {}): {} on two processors{}\n",
             arguments.output.string(), arguments.scale, arguments.seed, cost.takes, writes);
  const std::size_t stages = reproduction.parts().size() + 1;
  std::size_t stage = 0;
  const auto timed = [&](const char* what, const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    on_threads(arguments.threads, [&](int) { work(); });
    const std::chrono::duration<double> took_s = std::chrono::steady_clock::now() - start;
    fmt::print(stderr, "{:2}/{} {:<64} {:6.1f} s\n", ++stage, stages, what, took_s.count());
  };
  for (const Part& part : reproduction.parts()) timed(part.what, [&] { reproduction.do_part(part); });
  timed("the report", [&] { reproduction.report(); });
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
                  "demo: a first page in seconds; quick: a look in a minute; paper: its 16 participants for "
                  "Tables II and III, calibration and ranges in small; full: all as the studies say")
      ->check(CLI::IsMember(kScales))
      ->capture_default_str();
  verb.add_option("--seed", a.seed, "of every random number")->capture_default_str();
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
}

void add_demo(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<ReproduceArguments>(
      app, code, "demo",
      "a first page in seconds: simulated walkers, their table and the report; as reproduce --scale demo",
      reproduce);
  a.output = "out/demo";
  a.scale = "demo";
  verb.add_option("-o,--output", a.output, "folder of everything that is made")->capture_default_str();
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
