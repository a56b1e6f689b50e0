// SPDX-License-Identifier: MIT
// `trilat gate`.
#include <chrono>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "datasets/results/speed_file.h"
#include "evaluators/metrics/ratio_change.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/gate/accept_results.h"
#include "pipeline/gate/compare_results.h"
#include "pipeline/gate/judge_history.h"
#include "pipeline/gate/judge_speed.h"
#include "pipeline/gate/measure_speed.h"
#include "pipeline/gate/shell_word.h"
#include "pipeline/results_folder.h"

namespace trilat {
namespace {

std::string time_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

SpeedFile measured_speed(const char* label) {
  Progress progress(label);
  MeasureOptions options;
  options.stop_requested = stop_requested;
  options.progress = [&](double share) { progress.set(share); };
  return measure_speed(options);
}

// Tonight's, measured when asked for.
std::optional<SpeedFile> speed_of(const GateArguments& arguments) {
  if (!arguments.speed) return read_speed(arguments.results);
  find_results(arguments.results);  // refuses before the time is spent
  std::vector<SpeedFile> runs;
  for (int run = 0; run < (arguments.accepts ? kBaselineSpeedRuns : 1); ++run)
    runs.push_back(measured_speed("timing the solvers"));
  const SpeedFile speed = joined_speed(runs);
  write_speed(arguments.results, speed);
  return speed;
}

std::string command_of(const GateReport& report) {
  return "trilat gate " + shell_word(report.results) + " --baseline " + shell_word(report.baseline);
}

void add_speed(const GateArguments& arguments, const GateLimits& limits, const SpeedFile& now,
               GateReport& report) {
  const auto before = read_speed(arguments.baseline);
  if (!before) {
    report.speed.note =
        "not judged: the baseline has no speed.json; it gets one by --accept together with --speed";
    return;
  }
  const std::function<SpeedFile()> again = [] { return measured_speed("timing the solvers once more"); };
  SpeedJudgement judged =
      judge_speed(now, *before, limits, arguments.speed ? again : std::function<SpeedFile()>{});
  report.speed = judged.verdict;
  for (GateFinding& f : judged.findings) {
    f.command = command_of(report) + " --speed";
    report.findings.push_back(std::move(f));
  }
}

// What was measured beside other work would look like a drift.
void add_speed_series(const SpeedFile& speed, HistoryEntry& entry) {
  if (is_disturbed(speed)) return;
  for (const SolverSpeed& s : speed.solvers) entry.speed[s.solver] = quantile_of(s.ratios, 0.25);
}

int accept(const GateArguments& arguments, const std::string& time) {
  // read first: a history that cannot be read must not be found out behind a new baseline
  if (!arguments.history.empty()) read_history(arguments.history);
  const auto speed = speed_of(arguments);
  const std::vector<std::string> left_behind = studies_left_behind(arguments.results, arguments.baseline);
  const AcceptedBaseline accepted =
      accept_results(arguments.results, arguments.baseline, arguments.reason, time);
  if (!arguments.history.empty()) {
    HistoryEntry entry;
    entry.time = time;
    entry.program = kProgramVersion;
    entry.accepted = true;
    entry.reason = arguments.reason;
    add_series(find_results(arguments.results), entry);
    if (speed) add_speed_series(*speed, entry);
    append_history(arguments.history, entry);
  }
  if (arguments.json) {
    fmt::print("{}\n", json_text({{"format", "trilat.gate"},
                                  {"version", 1},
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

void add_drifts(const GateArguments& arguments, const GateLimits& limits, HistoryEntry& tonight,
                GateReport& report) {
  const History history = read_history(arguments.history);
  if (!history.torn.empty())
    report.notes.push_back(history.torn + ": is torn, was left out and will be replaced");
  for (const GateFinding& f : report.findings)
    if (f.alarm) tonight.alarms.push_back(key_of(f));
  HistoryJudgement judgement = judge_history(history, tonight, limits, report.findings, report.baseline_time);
  for (GateFinding& drift : judgement.drifts) {
    const bool of_speed = drift.condition.empty();
    drift.command = command_of(report) + (of_speed ? " --speed" : " --method " + shell_word(drift.method));
    if (drift.alarm) tonight.alarms.push_back(key_of(drift));
    report.findings.push_back(std::move(drift));
  }
  sort_findings(report.findings);
  report.notes.push_back(
      fmt::format("history: {} night(s) since the last accepted change", judgement.nights));
}

int exit_code_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::quiet:
      return kDone;
    case Verdict::regression:
      return kItemsFailed;
    case Verdict::not_judged:
      break;
  }
  return kNotJudged;
}

int compare(const GateArguments& arguments, const std::string& time) {
  GateLimits limits;
  limits.smallest_percent = arguments.smallest_percent;
  GateReport report;
  on_threads(arguments.threads, [&](int) {
    report =
        compare_results(arguments.results, arguments.baseline, {limits, arguments.resamples, stop_requested});
  });
  report.time = time;
  HistoryEntry tonight;
  tonight.time = time;
  tonight.program = kProgramVersion;
  if (const auto speed = speed_of(arguments)) {
    add_speed(arguments, limits, *speed, report);
    add_speed_series(*speed, tonight);
  }
  sort_findings(report.findings);
  add_series(find_results(arguments.results), tonight);
  report.history = arguments.history.string();
  if (!arguments.history.empty()) add_drifts(arguments, limits, tonight, report);
  const Verdict verdict = report.verdict();
  tonight.quiet = verdict == Verdict::quiet;
  for (const StudyVerdict& s : report.studies)
    if (s.state == StudyState::not_judged) tonight.not_judged.push_back(s.study);
  if (!arguments.junit.empty()) write_file(arguments.junit, gate_junit(report));
  if (!arguments.history.empty()) append_history(arguments.history, tonight);
  if (arguments.json)
    fmt::print("{}\n", json_text(gate_json(report), 1));
  else
    fmt::print("{}", arguments.method.empty() ? morning_text(report) : cell_table(report, arguments.method));
  return exit_code_of(verdict);
}

}  // namespace

int gate(const GateArguments& arguments) {
  const std::string time = time_now();
  const std::pair<std::filesystem::path, OutputKind> outputs[] = {{arguments.junit, OutputKind::junit},
                                                                  {arguments.history, OutputKind::history}};
  for (const auto& [path, kind] : outputs)
    if (!path.empty()) check_output({path, kind, {arguments.results, arguments.baseline}, arguments.force});
  if (arguments.accepts) return accept(arguments, time);
  try {
    return compare(arguments, time);
  } catch (const InputError& error) {
    if (!arguments.junit.empty()) write_file(arguments.junit, gate_junit_of_error(time, error.what()));
    throw;
  }
}

}  // namespace trilat
