// SPDX-License-Identifier: MIT
// `trilat run` and `trilat merge` for studies of kind accuracy.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/calibration/calibration.h"
#include "pipeline/cli/merge_kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/execute.h"
#include "pipeline/plan.h"
#include "pipeline/study_part.h"
#include "reports/accuracy_tables.h"
#include "reports/render.h"
#include "reports/sensor_counts.h"

namespace trilat {
namespace {

// `owner`: whose each take is when the work is divided.
Json plan_json(const Plan& plan, const std::vector<PartItem>& owner) {
  Json takes = Json::array(), methods = Json::array(), joints = Json::array();
  for (std::size_t i = 0; i < plan.takes.size(); ++i) {
    const PlannedTake& t = plan.takes[i];
    Json entry{
        {"id", t.take.id}, {"participant", t.take.participant}, {"activity", t.take.activity}, {"ok", t.ok}};
    entry["shard"] = owner[i].shard;
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

int print_plan(const Plan& plan, const Shard& shard, bool json) {
  const bool all_ok =
      std::all_of(plan.takes.begin(), plan.takes.end(), [](const PlannedTake& t) { return t.ok; });
  const std::vector<PartItem> owner = part_items(plan, shard.of);
  if (json) {
    fmt::print("{}\n", json_text(plan_json(plan, owner), 2));
    return all_ok ? kDone : kItemsFailed;
  }
  fmt::print("study {} on campaign {}: {} takes x {} joints x {} methods\n", plan.study.name,
             plan.campaign.name, plan.takes.size(), plan.joints.size(), plan.methods.size());
  fmt::print("methods:");
  for (const Method& m : plan.methods) fmt::print(" {};", m.spec.name);
  fmt::print("\n");
  for (std::size_t i = 0; i < plan.takes.size(); ++i) {
    const PlannedTake& t = plan.takes[i];
    if (owner[i].shard != shard.number) continue;
    if (t.ok)
      fmt::print("  {:<20} {} instants\n", t.take.id, t.instants);
    else
      fmt::print("  {:<20} cannot be evaluated: {}: {}\n", t.take.id, t.place, t.problem);
  }
  return all_ok ? kDone : kItemsFailed;
}

void print_notes(const std::vector<TakeNote>& notes) {
  for (const TakeNote& note : notes)
    fmt::print(stderr, "{}: take {}: {}: {}\n", note.failed ? "failed" : "note", note.take, note.place,
               note.text);
}

void print_cross_check(const ResultsSummary& summary) {
  if (!summary.cross_check) return;
  const CrossCheck& c = *summary.cross_check;
  fmt::print(
      stderr,
      "cross-check of \"{}\" with Ceres: {} samples, worst {:.3g} m at {}, {} answered by one only: {}\n",
      c.method, c.samples, c.worst_m, c.worst_at, c.disagreements,
      c.passed() ? "agrees" : fmt::format("DISAGREES (limit {:g} m)", c.limit_m));
}

Campaign campaign_of(const StudySpec& study, const RunArguments& arguments) {
  const std::filesystem::path folder = arguments.campaign.empty() ? study.campaign : arguments.campaign;
  if (folder.empty())
    throw InputError(arguments.study.string() + " /campaign",
                     "is missing; name it there or with --campaign DIR");
  Campaign campaign = read_campaign(folder, arguments.outside);
  if (!arguments.calibration.empty()) {
    read_calibration(arguments.calibration);  // one error now instead of one a take
    for (Take& take : campaign.takes) take.calibration = arguments.calibration;
  }
  return campaign;
}

std::vector<std::filesystem::path> inputs_of(const Campaign& campaign) {
  std::vector<std::filesystem::path> inputs{campaign.folder};
  for (const Take& t : campaign.takes)
    inputs.insert(inputs.end(), {t.session, t.calibration, t.mocap, t.mapping, t.tracker_truth});
  return inputs;
}

ExecuteOptions options_of(const RunArguments& arguments) {
  ExecuteOptions options;
  options.threads = arguments.threads;
  options.cross_check = arguments.cross_check;
  options.stop_requested = stop_requested;
  options.reuse = reused_results(arguments);
  options.fresh = arguments.fresh;
  if (arguments.memory_mb) options.memory_bytes = *arguments.memory_mb * 1'000'000;
  return options;
}

int run_shard(const RunArguments& arguments, const StudySpec& study, const Campaign& campaign,
              const Shard& shard) {
  ExecuteOptions options = options_of(arguments);
  StudyPart part;
  {
    Progress progress("evaluating");
    options.progress = [&](double share) { progress.set(share); };
    part = run_study_part(study, campaign, shard, arguments.output, options);
  }
  tell_reuse("takes", part.tally);
  print_notes(part.notes);
  if (arguments.json) {
    Json document{{"part", arguments.output.string()},
                  {"shard", name_of(shard)},
                  {"takes", part.takes},
                  {"takes_failed", part.failed}};
    document.update(tally_json(part.tally));
    fmt::print("{}\n", json_text(document, 2));
  } else {
    fmt::print("part {}: {} of {} takes, {} failed: {}\n", name_of(shard), part.takes, part.of, part.failed,
               arguments.output.string());
  }
  const bool failed =
      std::any_of(part.notes.begin(), part.notes.end(), [](const TakeNote& note) { return note.failed; });
  return failed ? kItemsFailed : kDone;
}

int print_results(const ResultsSummary& summary, const std::filesystem::path& output, Json document,
                  bool json) {
  print_notes(summary.notes);
  print_cross_check(summary);
  const bool passed = !summary.cross_check || summary.cross_check->passed();
  if (json) {
    document["takes"] = summary.takes;
    document["takes_failed"] = summary.takes_failed;
    document["cross_check_passed"] = summary.cross_check ? Json(passed) : Json();
    fmt::print("{}\n", json_text(document, 2));
  } else {
    for (const Table& table : accuracy_tables(without_sets(summary))) fmt::print("{}\n", markdown_of(table));
    fmt::print("results: {}\n", output.string());
  }
  return summary.takes_failed == 0 && passed ? kDone : kItemsFailed;
}

}  // namespace

int run_accuracy_study(const RunArguments& arguments, const Json& json) {
  const StudySpec study = parse_study(json, arguments.study.string(), arguments.study.parent_path());
  const Campaign campaign = campaign_of(study, arguments);
  const Shard shard = arguments.shard.empty() ? Shard{} : parse_shard(arguments.shard, "--shard");
  if (arguments.dry_run) return print_plan(make_plan(study, campaign), shard, arguments.json);
  check_run_output(arguments, StudyKind::accuracy, inputs_of(campaign));
  if (!arguments.shard.empty()) return run_shard(arguments, study, campaign, shard);
  ExecuteOptions options = options_of(arguments);
  StudyRun run;
  {
    Progress progress("evaluating");
    options.progress = [&](double share) { progress.set(share); };
    run = run_study(study, campaign, arguments.output, options);
  }
  tell_reuse("takes", run.takes);
  Json document{{"results", arguments.output.string()}, {"unchanged", run.unchanged}};
  document.update(tally_json(run.takes));
  return print_results(run.summary, arguments.output, std::move(document), arguments.json);
}

int merge_accuracy(const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  ResultsSummary summary;
  ExecuteOptions options{.threads = arguments.threads, .stop_requested = stop_requested};
  if (arguments.memory_mb) options.memory_bytes = *arguments.memory_mb * 1'000'000;
  {
    Progress progress("merging");
    options.progress = [&](double share) { progress.set(share); };
    summary = merge_study(parts, arguments.output, options);
  }
  return print_results(summary, arguments.output,
                       {{"results", arguments.output.string()}, {"parts", parts.size()}}, arguments.json);
}

}  // namespace trilat
