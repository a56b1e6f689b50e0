// SPDX-License-Identifier: MIT
// `trilat run`.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/base/words.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

void refuse_unused_options(const Kind& kind, const RunArguments& arguments) {
  if (!kind.no_campaign.empty() && (!arguments.campaign.empty() || !arguments.calibration.empty()))
    throw InputError(arguments.campaign.empty() ? "--calibration" : "--campaign",
                     "is of no use: " + kind.no_campaign);
  for (const auto& [option, is_given] : {std::pair{"--cross-check", arguments.cross_check},
                                         std::pair{"--calibration", !arguments.calibration.empty()}})
    if (is_given && kind.kind != StudyKind::accuracy)
      throw InputError(option, "is for studies of kind accuracy");
}

ItemCounts plan_and_run(const OpenedStudy& opened, const RunArguments& arguments, const Shard& shard,
                        const OutputMark& mark) {
  StageProgressBars progress;
  const StudyOptions options{
      .stop_requested = stop_requested,
      .progress = [&](const std::string& stage, double share) { progress.set(stage, share); },
      .shard = shard,
      .fresh = arguments.fresh,
      .mark = [&] { mark_output(arguments.output, mark); }};
  ItemCounts tally;
  on_threads(arguments.threads, [&](int) { tally = opened.run(options); });
  return tally;
}

// Prints the shard's item counts; returns the exit code.
int print_shard(const OpenedStudy& opened, const RunArguments& arguments, const Shard& shard,
                const ItemCounts& tally) {
  if (opened.print_failed) opened.print_failed(tally);
  Json document{{"results", arguments.output.string()}, {"shard", name_of(shard)}};
  document.update(tally_json(tally));
  if (arguments.json)
    fmt::print("{}\n", json_text(document, 2));
  else
    fmt::print("shard {}: {} items, {} failed: {}; without --shard they are summarised\n", name_of(shard),
               tally.all(), tally.failed.size(), arguments.output.string());
  return tally.failed.empty() ? kDone : kItemsFailed;
}

OutputMark mark_of(const OpenedStudy& opened, const std::string& study) {
  return {"run", {study}, opened.campaign ? opened.campaign->name : ""};
}

void check_run_output(const RunArguments& arguments, const OpenedStudy& opened, const OutputMark& mark) {
  if (arguments.output.empty()) throw InputError("--output", "is missing: where should the results go?");
  std::vector<std::filesystem::path> inputs = opened.inputs;
  inputs.insert(inputs.end(), {arguments.study, arguments.calibration});
  check_output_folder({arguments.output, inputs, arguments.force}, mark);
}

// Recordings in the place of a study.
void refuse_recordings(const std::filesystem::path& path) {
  const bool is_campaign =
      std::filesystem::exists(path / "campaign.json") || path.filename() == "campaign.json";
  const bool is_session =
      kSessionEndings.contains(lower_extension(path)) && std::filesystem::is_regular_file(path);
  if (!is_campaign && !is_session) return;
  const std::filesystem::path folder = std::filesystem::is_directory(path) ? path : path.parent_path();
  throw InputError(path.string(),
                   is_campaign
                       ? fmt::format("is a campaign, and no study; `trilat run table3 --campaign {} -o "
                                     "RESULTS` evaluates it, and so does any STUDY.json",
                                     shell_word(folder.empty() ? "." : folder.string()))
                       : "is a recording, and no study; `trilat init FOLDER` makes a campaign and a study "
                         "of a folder of them");
}

// A file, or the name of a study that is built in. Its scales are those of `trilat reproduce`.
Json read_study(const std::filesystem::path& study) {
  const std::vector<std::string> names = built_in_studies();
  if (std::ranges::find(names, study.string()) == names.end()) refuse_recordings(study);
  if (std::filesystem::is_regular_file(study) || study.has_extension() || study.has_parent_path()) {
    Json json = read_json(study);
    if (json.is_object()) json.erase("scales");
    return json;
  }
  if (study == "error_budget" || study == "sensitivity" || study == "sensitivity_rigs")
    throw InputError(study.string(), "was removed; scripts/vary varies a simulation (scripts/examples)");
  if (study == "table4")
    throw InputError("table4",
                     "is now the study clocks, on recordings of your own or simulated ones: trilat run "
                     "clocks --campaign DIR -o clocks");
  if (std::ranges::find(names, study.string()) == names.end())
    throw InputError(study.string(),
                     "is neither a file nor a built-in study; " + known_names(study.string(), names));
  return built_in_study(study.string());
}

int run(const RunArguments& arguments) {
  const Json json = read_study(arguments.study);
  const Shard shard = arguments.shard.empty() ? Shard{} : parse_shard(arguments.shard, "--shard");
  const Kind& kind = *find_kind(name_of(study_kind(json, arguments.study.string())));
  refuse_unused_options(kind, arguments);
  const OpenedStudy opened = kind.open(arguments, json);
  if (arguments.dry_run) return opened.print_plan(shard, arguments.json, {stop_requested, {}});
  const OutputMark mark = mark_of(opened, json.value("name", ""));
  check_run_output(arguments, opened, mark);
  ItemCounts tally;
  try {
    tally = plan_and_run(opened, arguments, shard, mark);
  } catch (const Interrupted&) {
    tell_interrupted(arguments.output);
    return kInterrupted;
  }
  print_item_counts(kind.items, tally);
  if (!shard.whole()) return print_shard(opened, arguments, shard, tally);
  return kind.print(arguments.output, tally_json(tally), {arguments.json, arguments.tables});
}

}  // namespace

void add_run(CLI::App& app, int& code) {
  auto [verb, a] =
      add_verb<RunArguments>(app, code, "run",
                             "a study: takes x methods, a threshold sweep, calibration or clocks "
                             "-> results",
                             run);
  verb.add_option("study", a.study, "study.json, or the name of one that is built in: table3")->required();
  verb.add_option("--campaign", a.campaign, "folder of takes, instead of the study's own");
  verb.add_option("--calibration", a.calibration, "calibration.json, instead of the takes' own");
  verb.add_option("-o,--output", a.output, "results folder; not needed with --dry-run");
  add_threads(verb, a.threads);
  verb.add_flag("--cross-check", a.cross_check,
                "solve again with Ceres, report the worst difference and fail beyond the study's limit");
  verb.add_flag("--dry-run", a.dry_run, "print the plan and stop");
  verb.add_option("--shard", a.shard,
                  "k/n: compute only share k of n of the items into --output, for a run without it");
  verb.add_flag("--fresh", a.fresh, "compute all again, whatever --output holds");
  add_force(verb, a.force);
  add_json(verb, a.json);
  verb.add_flag("--tables", a.tables, "accuracy: print all tables, as Markdown");
}

}  // namespace trilat
