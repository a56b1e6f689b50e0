// SPDX-License-Identifier: MIT
// `trilat run`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/calibration/calibration.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/execute.h"
#include "pipeline/plan.h"
#include "reports/accuracy_tables.h"
#include "reports/render.h"

namespace trilat {
namespace {

Json plan_json(const Plan& plan) {
  Json takes = Json::array(), methods = Json::array(), joints = Json::array();
  for (const PlannedTake& t : plan.takes) {
    Json entry{
        {"id", t.take.id}, {"participant", t.take.participant}, {"activity", t.take.activity}, {"ok", t.ok}};
    if (t.ok)
      entry["instants"] = t.instants;
    else
      entry["problem"] = t.place + ": " + t.problem;
    takes.push_back(entry);
  }
  for (const Method& m : plan.methods) methods.push_back(m.spec.name);
  for (Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  return {{"study", plan.study.name}, {"campaign", plan.campaign.name},
          {"rig", plan.rig},          {"joints", joints},
          {"methods", methods},       {"takes", takes}};
}

int print_plan(const Plan& plan, bool json) {
  const bool all_ok =
      std::all_of(plan.takes.begin(), plan.takes.end(), [](const PlannedTake& t) { return t.ok; });
  if (json) {
    fmt::print("{}\n", json_text(plan_json(plan), 2));
    return all_ok ? kDone : kItemsFailed;
  }
  fmt::print("study {} on campaign {}: {} takes x {} joints x {} methods\n", plan.study.name,
             plan.campaign.name, plan.takes.size(), plan.joints.size(), plan.methods.size());
  fmt::print("methods:");
  for (const Method& m : plan.methods) fmt::print(" {};", m.spec.name);
  fmt::print("\n");
  for (const PlannedTake& t : plan.takes) {
    if (t.ok)
      fmt::print("  {:<20} {} instants\n", t.take.id, t.instants);
    else
      fmt::print("  {:<20} cannot be evaluated: {}: {}\n", t.take.id, t.place, t.problem);
  }
  return all_ok ? kDone : kItemsFailed;
}

void print_notes(const ResultsSummary& summary) {
  for (const TakeNote& note : summary.notes)
    fmt::print(stderr, "{}: take {}: {}: {}\n", note.failed ? "failed" : "note", note.take, note.place,
               note.text);
  if (!summary.cross_check) return;
  const CrossCheck& c = *summary.cross_check;
  fmt::print(
      stderr,
      "cross-check of \"{}\" with Ceres: {} samples, worst {:.3g} m at {}, {} answered by one only: {}\n",
      c.method, c.samples, c.worst_m, c.worst_at, c.disagreements,
      c.passed() ? "agrees" : fmt::format("DISAGREES (limit {:g} m)", c.limit_m));
}

}  // namespace

int run(const RunArguments& arguments) {
  const Json json = read_json(arguments.study);
  const StudyKind kind = study_kind(json, arguments.study.string());
  if (kind == StudyKind::threshold_sweep) return run_sweep_study(arguments, json);
  if (kind == StudyKind::calibration) return run_calibration_study(arguments, json);
  if (kind == StudyKind::error_budget) return run_budget_study(arguments, json);
  if (kind == StudyKind::recording) return run_recording_study(arguments, json);
  const StudySpec study = parse_study(json, arguments.study.string(), arguments.study.parent_path());
  const std::filesystem::path folder = arguments.campaign.empty() ? study.campaign : arguments.campaign;
  if (folder.empty())
    throw InputError(arguments.study.string() + " /campaign",
                     "is missing; name it there or with --campaign DIR");
  Campaign campaign = read_campaign(folder, arguments.outside);
  if (!arguments.calibration.empty()) {
    read_calibration(arguments.calibration);  // one error now instead of one a take
    for (Take& take : campaign.takes) take.calibration = arguments.calibration;
  }
  if (arguments.dry_run) return print_plan(make_plan(study, campaign), arguments.json);
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  ExecuteOptions options;
  options.threads = arguments.threads;
  if (arguments.memory_mb) options.memory_bytes = *arguments.memory_mb * 1'000'000;
  options.cross_check = arguments.cross_check;
  options.stop_requested = stop_requested;
  ResultsSummary summary;
  {
    Progress progress("evaluating");
    options.progress = [&](double share) { progress.set(share); };
    summary = execute_study(study, campaign, arguments.output, options);
  }
  print_notes(summary);
  const bool passed = !summary.cross_check || summary.cross_check->passed();
  if (arguments.json) {
    const Json document{{"results", arguments.output.string()},
                        {"takes", summary.takes},
                        {"takes_failed", summary.takes_failed},
                        {"cross_check_passed", summary.cross_check ? Json(passed) : Json()}};
    fmt::print("{}\n", json_text(document, 2));
  } else {
    for (const Table& table : accuracy_tables(summary)) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", arguments.output.string());
  }
  return summary.takes_failed == 0 && passed ? kDone : kItemsFailed;
}

}  // namespace trilat
