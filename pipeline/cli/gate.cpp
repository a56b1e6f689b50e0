// SPDX-License-Identifier: MIT
// `trilat gate`.
#include <chrono>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/found_results.h"
#include "pipeline/gate/gate_report.h"

namespace trilat {
namespace {

struct GateArguments {
  std::filesystem::path results, baseline;
  std::filesystem::path history;  // or empty
  double smallest_percent = 1.0;
  std::optional<std::string> accept_reason;  // the results become the baseline
  bool force = false;                        // may replace what others wrote
  bool json = false;
};

std::string time_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

int accept(const GateArguments& arguments, const std::string& time) {
  std::optional<FolderLock> lock;
  if (!arguments.history.empty()) lock.emplace(arguments.history);
  // read first: a history that cannot be read must not be found out behind a new baseline
  if (!arguments.history.empty()) read_history(arguments.history);
  const std::vector<std::string> left_behind =
      studies_only_in_baseline(arguments.results, arguments.baseline);
  const AcceptedBaseline accepted =
      accept_results(arguments.results, arguments.baseline, *arguments.accept_reason, time);
  if (!arguments.history.empty()) {
    add_to_history(arguments.history, {.time = time,
                                       .program = kProgramVersion,
                                       .verdict = NightVerdict::accepted,
                                       .reason = *arguments.accept_reason,
                                       .mean_error_m = mean_errors_of(find_results(arguments.results))});
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text({{"format", "trilat.gate"},
                                  {"version", 3},
                                  {"time", time},
                                  {"verdict", "accepted"},
                                  {"baseline", arguments.baseline.string()},
                                  {"reason", accepted.reason},
                                  {"sha256", accepted.sha256},
                                  {"replaces_sha256", accepted.replaces_sha256},
                                  {"left_behind", left_behind}},
                                 2));
    return kDone;
  }
  fmt::print("ACCEPTED: {} is the baseline now, {}\n", arguments.results.string(),
             arguments.baseline.string());
  fmt::print("because: {}\n", accepted.reason);
  if (!accepted.replaces_sha256.empty())
    fmt::print("it replaces {} {}\n", accepted.replaces_sha256.substr(0, 12),
               accepted.replaces_time.empty() ? "" : "of " + accepted.replaces_time);
  if (!left_behind.empty()) fmt::print("not in the baseline any more: {}\n", fmt::join(left_behind, ", "));
  return kDone;
}

// Says of the report's alarms since when they are, and adds the night.
void add_night(const std::filesystem::path& history, GateReport& report) {
  report.history = history.string();
  report.notes.push_back(fmt::format("history: {} night(s) since the last accepted change",
                                     set_since(read_history(history), report)));
  Night night{.time = report.time,
              .program = kProgramVersion,
              .verdict = report.verdict(),
              .mean_error_m = mean_errors_of(find_results(report.results))};
  for (const GateFinding& f : report.findings)
    if (f.alarm) night.alarms.push_back(key_of(f));
  for (const StudyVerdict& s : report.studies)
    if (s.state == StudyState::not_judged) night.not_judged.push_back(s.study);
  add_to_history(history, night);
}

int exit_code_of(NightVerdict verdict) {
  switch (verdict) {
    case NightVerdict::quiet:
    case NightVerdict::accepted:
      return kDone;
    case NightVerdict::regression:
      return kItemsFailed;
    case NightVerdict::not_judged:
      break;
  }
  return kNotJudged;
}

int compare(const GateArguments& arguments, const std::string& time) {
  GateLimits limits;
  limits.smallest_percent = arguments.smallest_percent;
  std::optional<FolderLock> lock;  // from reading the history to adding to it
  if (!arguments.history.empty()) lock.emplace(arguments.history);
  GateReport report = compare_results(arguments.results, arguments.baseline, limits);
  report.time = time;
  if (!arguments.history.empty()) add_night(arguments.history, report);
  if (arguments.json)
    fmt::print("{}\n", json_text(gate_json(report), 1));
  else
    fmt::print("{}", gate_summary(report));
  return exit_code_of(report.verdict());
}

int gate(const GateArguments& arguments) {
  const std::string time = time_now();
  if (!arguments.history.empty()) {
    const bool is_own = begins_with(arguments.history, kHistoryHeader) ||
                        begins_with(arguments.history, "trilat.history");  // which read_history() refuses
    check_output_file({arguments.history, {arguments.results, arguments.baseline}, arguments.force}, is_own);
  }
  return arguments.accept_reason ? accept(arguments, time) : compare(arguments, time);
}

}  // namespace

void add_gate(CLI::App& app, int& code) {
  auto [verb, a] =
      add_verb<GateArguments>(app, code, "gate", "nightly: is anything worse than the baseline", gate);
  verb.add_option("results", a.results, "a results folder, or a folder that holds several")->required();
  verb.add_option("--baseline", a.baseline, "what to compare with: a folder of the same shape")->required();
  verb.add_option("--history", a.history, "history.csv: says since when, and gets one line more");
  verb.add_option("--smallest-effect", a.smallest_percent, "percent; smaller changes are no alarm")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  removed_option(verb, "--junit", "the exit code, the text and --json say the verdict");
  verb.add_option("--accept", a.accept_reason,
                  "make these results the baseline, for the reason given, and compare nothing");
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.footer(
      "Of the same recordings an alarm is a mean error that grew by more than the smallest effect and 0.1 "
      "mm, answers that fell by more than 0.5 %, or a take that lost a tenth of them. Other recordings are "
      "judged by Student's t between eight participants or more.\n\n"
      "Exit codes: 0 quiet; 1 something is worse; 2 cannot be compared, with the place; 3 not judged: other "
      "recordings of too few participants to tell a change from chance.");
}

}  // namespace trilat
