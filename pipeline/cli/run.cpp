// SPDX-License-Identifier: MIT
// `trilat run` and `trilat merge`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/known_names.h"
#include "datasets/base/version.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/embedded_studies.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/reused_results.h"
#include "pipeline/cli/terminal/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/study/results_folder.h"

namespace trilat {
namespace {

struct MergeArguments {
  std::vector<std::filesystem::path> parts;
  std::filesystem::path output;
  int threads = 0;
  bool force = false;  // may replace what others wrote
  bool json = false;
  bool tables = false;  // all of them are printed
};

void refuse_what_is_of_no_use(const Kind& kind, const RunArguments& arguments) {
  if (!kind.no_campaign.empty() && (!arguments.campaign.empty() || !arguments.calibration.empty()))
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: " + kind.no_campaign);
  if (arguments.cross_check && kind.kind != StudyKind::accuracy)
    throw InputError("--cross-check", "is for studies of kind accuracy");
}

// Plans and computes what is not known.
ItemTally run_opened(const OpenedStudy& opened, const RunArguments& arguments, const Shard& shard) {
  const std::filesystem::path& output = arguments.output;
  StudyOptions options{.threads = arguments.threads,
                       .stop_requested = stop_requested,
                       .shard = shard,
                       .reuse = reused_results(arguments),
                       .fresh = arguments.fresh};
  StageProgressBars progress;
  options.progress = [&](const std::string& stage, double share) { progress.set(stage, share); };
  ItemTally tally;
  on_threads(arguments.threads, [&](int) {
    const bool is_asked = shard.whole() && !arguments.fresh && std::filesystem::exists(output / "items.json");
    tally.unchanged = is_asked && opened.key && holds_results(output, opened.key({stop_requested, {}}));
    if (tally.unchanged)
      for (const DoneItem& item : read_items(output)) tally.reused.push_back(item.id);
    else
      tally = run_study(opened.plan({stop_requested, [&](double share) { progress.set("planning", share); }}),
                        output, options);
  });
  return tally;
}

MergeArguments checked(const MergeArguments& arguments, const FoundPart& first) {
  if (first.part.build != build_id())
    throw InputError(first.folder.string(), "was made by another build of the program; merge with that one");
  const OutputKind output = first.part.kind == kCampaign ? OutputKind::merged_campaign : OutputKind::results;
  check_output({arguments.output, output, arguments.parts, arguments.force});
  return arguments;
}

void put_together(const Study& study, const MergeArguments& arguments, const std::vector<FoundPart>& parts) {
  StageProgressBars progress;
  merge_parts(study, parts, arguments.output,
              {.threads = arguments.threads,
               .stop_requested = stop_requested,
               .progress = [&](const std::string& stage, double share) { progress.set(stage, share); }});
}

// A file, or the name of a study that is built in.
Json read_study(const std::filesystem::path& study) {
  std::vector<std::string> names;
  for (const auto& built_in : embedded::studies) names.emplace_back(built_in.name);
  const auto found = std::ranges::find(names, study.string());
  if (found != names.end() && !std::filesystem::exists(study))
    return parse_json(embedded::studies[static_cast<std::size_t>(found - names.begin())].text,
                      study.string());
  if (!study.has_extension() && !study.has_parent_path() && !std::filesystem::exists(study))
    throw InputError(study.string(),
                     "is no file and no study that is built in; " + known_names(study.string(), names));
  return read_json(study);
}

int run(const RunArguments& arguments) {
  const Json json = read_study(arguments.study);
  const Shard shard = arguments.shard.empty() ? Shard{} : parse_shard(arguments.shard, "--shard");
  const Kind& kind = *find_kind(name_of(study_kind(json, arguments.study.string())));
  refuse_what_is_of_no_use(kind, arguments);
  const OpenedStudy opened = kind.open(arguments, json);
  if (arguments.dry_run) return opened.print_plan(shard, arguments.json, {stop_requested, {}});
  check_run_output(arguments, kind.kind, opened.inputs);
  if (shard.whole())
    refuse_other_results(arguments.output, json.value("name", ""),
                         opened.campaign ? &*opened.campaign : nullptr, arguments.force);
  ItemTally tally;
  try {
    tally = run_opened(opened, arguments, shard);
  } catch (const Interrupted&) {
    tell_interrupted(partial_name(output_name(arguments.output)));
    return kInterrupted;
  }
  tell_reuse(kind.items, tally);
  if (shard.whole())
    return kind.print(arguments.output, tally_json(tally), {arguments.json, arguments.tables});
  if (opened.print_part) return opened.print_part(arguments.output, shard, tally, arguments.json);
  print_part(arguments.output, shard, tally, arguments.json);
  return kDone;
}

int merge(const MergeArguments& given) {
  const std::vector<FoundPart> parts = read_parts(given.parts);
  const FoundPart& first = parts.front();
  const MergeArguments arguments = checked(given, first);
  const std::string place = (first.folder / "part.json").string();
  if (first.part.kind == kCampaign) {
    put_together(campaign_of_parts(first.part.work, place), arguments, parts);
    const std::size_t takes = read_campaign(arguments.output).takes.size();
    const Json document{{"campaign", arguments.output.string()}, {"takes", takes}};
    if (arguments.json)
      fmt::print("{}\n", json_text(document, 2));
    else
      fmt::print("{} simulated takes: {}\n", takes, (arguments.output / "campaign.json").string());
    return kDone;
  }
  const Kind* kind = find_kind(first.part.kind);
  if (!kind)
    throw InputError(first.folder.string(),
                     "is a part of kind " + first.part.kind + ", which cannot be merged");
  put_together(kind->of_parts(first.part.work, place), arguments, parts);
  return kind->print(arguments.output, {{"parts", parts.size()}}, {arguments.json, arguments.tables});
}

}  // namespace

void add_run(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<RunArguments>(
      app, code, "run",
      "a study: takes x methods, a threshold sweep, calibration, clocks or an error budget -> results", run);
  verb.add_option("study", a.study, "study.json, or the name of one that is built in: table3")->required();
  verb.add_option("--campaign", a.campaign, "folder of takes, instead of the study's own");
  verb.add_option("--calibration", a.calibration, "calibration.json, instead of the takes' own");
  verb.add_option("-o,--output", a.output, "results folder; not needed with --dry-run");
  add_threads(verb, a.threads);
  verb.add_flag("--cross-check", a.cross_check,
                "solve again with Ceres, report the worst difference and fail beyond the study's limit");
  verb.add_flag("--dry-run", a.dry_run, "print the plan and stop");
  verb.add_option("--shard", a.shard, "k/n: compute only part k of n, into a folder for `trilat merge`");
  verb.add_option("--reuse", a.reuse,
                  "earlier results: what did not change since is taken from there; may be repeated. What "
                  "--output holds is always asked");
  verb.add_flag("--fresh", a.fresh, "compute all again, whatever --output holds");
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.add_flag("--tables", a.tables, "accuracy: print all tables, as Markdown");
}

void add_merge(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<MergeArguments>(
      app, code, "merge", "the parts that --shard has written -> what one run would have", merge);
  verb.add_option("parts", a.parts, "folders of all parts, in any order")->required();
  verb.add_option("-o,--output", a.output, "results or campaign")->required();
  add_threads(verb, a.threads);
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.add_flag("--tables", a.tables, "accuracy: print all tables, as Markdown");
}

}  // namespace trilat
