// SPDX-License-Identifier: MIT
// An accuracy study from its campaign to its results.
#include "pipeline/accuracy/accuracy_study.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/item_store.h"
#include "datasets/results/results_file.h"
#include "datasets/results/simulation_assumptions.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take_key.h"
#include "pipeline/accuracy/wand_poses.h"
#include "pipeline/claims/error_measures.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/errors/condition_errors.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_run.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

void replace_all(std::string& text, const std::string& old, const std::string& with) {
  if (old.empty() || old == with) return;
  for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
    text.replace(at, old.size(), with);
}

// Path relative to the campaign's folder, or the name alone where the file lies elsewhere.
std::string place_of(const fs::path& file, const fs::path& folder) {
  const fs::path inside = file.lexically_normal().lexically_relative(folder.lexically_normal());
  return inside.empty() || *inside.begin() == ".." ? file.filename().string() : inside.string();
}

// Results do not depend on where they were computed.
TakeNote within_campaign(TakeNote note, const Take& take, const Campaign& campaign) {
  for (std::string* text : {&note.place, &note.text})
    for (const TakeFile& file : files_of(take))
      replace_all(*text, file.path.string(), place_of(file.path, campaign.folder));
  return note;
}

// A take of the plan, or why it cannot be evaluated: then it fails, and the others go on.
ComputedItem evaluate(const Plan& plan, std::size_t t, const std::vector<TakeInput>& inputs,
                      const WatchedFiles& files, const ErrorSettings& errors, bool cross_check,
                      const fs::path& into, const RunControl& control) {
  const PlannedTake& planned = plan.takes[t];
  TakeResult result;
  try {
    if (!planned.ok) throw InputError(planned.place, planned.problem);
    for (const TakeInput& input : inputs)
      if (input.sha256.empty()) throw InputError(input.file, "cannot be read to its end");
    result = evaluate_take(plan, t, errors, cross_check, into, control);
    files.check();
  } catch (const OutputError&) {
    throw;
  } catch (const InputError& error) {
    for (const fs::directory_entry& entry : fs::directory_iterator(into)) fs::remove_all(entry.path());
    result = {};
    result.notes = {{planned.take.id, true, error.place(), error.problem()}};
  }
  result.inputs = inputs;
  for (TakeNote& note : result.notes) note = within_campaign(note, planned.take, plan.campaign);
  return {json_of(result), !result.evaluated};
}

// The part of a summary that needs no errors.
ResultsSummary summary_head(const Plan& plan, const StudyTotals& outcome) {
  ResultsSummary summary;
  summary.study = plan.study.name;
  summary.paper = name_of(plan.study.paper);
  summary.campaign = plan.campaign.name;
  summary.simulated = plan.simulated;
  if (leaves_sensors_out(plan)) summary.truth = kLeftOutTruth;
  summary.takes = plan.takes.size();
  summary.takes_failed = static_cast<std::uint64_t>(std::ranges::count(outcome.evaluated, false));
  std::set<std::string> participants;
  for (std::size_t t = 0; t < plan.takes.size(); ++t)
    if (outcome.evaluated[t]) participants.insert(plan.takes[t].take.participant);
  summary.participants = participants.size();
  for (const std::string& activity : activities_of(plan)) {
    summary.conditions.push_back(activity);
    if (plan.study.occluded_apart) summary.conditions.push_back(occluded_condition(activity));
  }
  summary.groups = groups_of(plan.names);
  for (const Method& method : plan.methods) {
    const MethodSpec& spec = method.spec;
    summary.methods.push_back(spec.name);
    summary.legend.push_back({spec.name, std::string(spec.kind->what), spec.kind == &external_kind()});
    if (spec.family.empty()) continue;
    if (summary.families.empty() || summary.families.back().name != spec.family)
      summary.families.push_back({spec.family, spec.sensors.size(), {}});
    summary.families.back().methods.push_back(spec.name);
  }
  summary.reference = plan.methods[plan.reference].spec.name;
  for (const AlignmentKind kind : plan.study.alignments) summary.alignments.emplace_back(name_of(kind));
  summary.notes = outcome.notes;
  summary.cross_checks = outcome.cross_checks;
  return summary;
}

// Makes takes fail whose recording is that of an earlier one: the same data twice, by name of two persons or
// takes, would look like independent ones, whose intervals are too narrow.
void leave_out_repeated(const Plan& plan, std::vector<TakeResult>& results) {
  std::map<std::vector<std::string>, std::string> known;  // what was recorded -> the first take of it
  for (std::size_t t = 0; t < results.size(); ++t) {
    TakeResult& result = results[t];
    const Take& take = plan.takes[t].take;
    if (!result.evaluated) continue;
    std::vector<std::string> recorded{take.activity};
    for (const TakeInput& input : result.inputs)
      if (input.role == "session" || input.role == "mocap" ||
          (take.session.empty() && input.role.starts_with("joints")))
        recorded.push_back(input.sha256);
    const auto [first, is_new] = known.try_emplace(recorded, take.id);
    if (is_new) continue;
    TakeResult repeated;
    repeated.inputs = std::move(result.inputs);
    repeated.notes = {within_campaign(
        {take.id, true, (take.session.empty() ? take.mocap : take.session).string(),
         fmt::format("is the recording of take {} again{}; it counts once: remove one of both", first->second,
                     take.mocap.empty() ? "" : ", with the same motion capture")},
        take, plan.campaign)};
    result = std::move(repeated);
  }
}

// The errors of the takes that were evaluated, and in a repetition of Table III how the truth moves, of which
// a study's errors say nothing.
std::vector<TakeTable> read_tables(const Plan& plan, const ErrorSettings& errors,
                                   std::span<const TakeResult> results,
                                   std::span<const ItemResult* const> outcomes, const RunControl& control) {
  constexpr double kTakesShare = 0.8;  // of the progress
  const auto nonlinear =
      std::ranges::find(plan.methods, std::string("nonlinear"), [](const Method& m) { return m.spec.name; });
  const bool needs_movement = plan.study.paper == PaperStudy::table3 && nonlinear != plan.methods.end();
  std::vector<TakeTable> tables(results.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(tables.size(), 1, [&](std::size_t t) {
    control.check();
    const Take& take = plan.takes[t].take;
    const fs::path& folder = outcomes[t]->folder;
    if (results[t].evaluated) {
      tables[t] = {take.id, take.participant, take.activity,
                   stored_errors(ItemStore(folder.parent_path().parent_path()), outcomes[t]->key, errors),
                   folder / StoredTake::kName};
      if (needs_movement)
        tables[t].movement =
            movement_of(StoredTake::open(tables[t].samples), tables[t].errors,
                        static_cast<std::size_t>(nonlinear - plan.methods.begin()), plan.study.rate_hz);
    }
    control.report(kTakesShare * static_cast<double>(++done) / static_cast<double>(tables.size()));
  });
  std::erase_if(tables, [](const TakeTable& table) { return table.id.empty(); });
  return tables;
}

// The table and the figure of stages come first, and no other.
void show_stages(const StudySpec& study, const ResultsSummary& summary, StoredTables& shown,
                 StoredFigures& figures) {
  for (Table& table : shown.tables)
    if (table.shown == Table::Placement::first) table.shown = Table::Placement::detail;
  std::vector<std::string> names;
  for (const Stage& stage : study.stages) names.push_back(stage.name);
  shown.findings = stages_findings(summary, names);
  shown.warnings = stages_warnings(summary, names);
  figures.figures = stages_figures(summary, names);
  std::vector<Table> tables = stages_tables(summary, names);
  for (Table& table : tables) table.shown = Table::Placement::first;
  shown.tables.insert(shown.tables.begin(), tables.begin(), tables.end());
}

// Everything that the study shows.
void write_shown(const Plan& plan, const ResultsSummary& summary, const TrackingSummary& tracking,
                 const fs::path& folder) {
  StoredTables shown = accuracy_shown(summary, tracking);
  const ResultsSummary rows = shown_summary(summary);
  if (plan.rig.empty()) {
    auto place = shown.tables.begin();
    for (const std::string& condition : summary.conditions) {
      Table table = files_table(summary, condition);
      table.shown = Table::Placement::first;
      place = std::next(shown.tables.insert(place, std::move(table)));
    }
  }
  for (Table& table : angle_tables(rows)) {
    if (plan.rig.empty()) table.shown = Table::Placement::first;
    shown.tables.push_back(std::move(table));
  }
  for (Table& table : agreement_tables(summary)) {
    table.shown = Table::Placement::file;
    shown.tables.push_back(std::move(table));
  }
  StoredFigures figures{accuracy_figures(rows)};
  for (Figure& figure : angle_figures(rows)) figures.figures.push_back(std::move(figure));
  if (!plan.study.stages.empty()) show_stages(plan.study, summary, shown, figures);
  store_tables(folder, std::move(shown));
  write_json_file(folder, figures);
}

// The results of a study whose takes are done.
void write_study(const Plan& plan, const ErrorSettings& errors, const std::vector<TakeNote>& notes,
                 bool cross_check, const ResultsRun& run, const fs::path& folder, const RunControl& control) {
  std::vector<TakeResult> results;
  std::vector<const ItemResult*> outcomes;
  for (std::size_t t = 0; t < plan.takes.size(); ++t) {
    outcomes.push_back(&run.outcome(t));
    results.push_back(read_as<TakeResult>(outcomes[t]->json, outcomes[t]->place()));
  }
  leave_out_repeated(plan, results);
  const StudyTotals outcome = outcome_of(plan, results, cross_check);
  write_json_file(folder, outcome.tracking);
  ResultsSummary summary = summary_head(plan, outcome);
  summary.notes.insert(summary.notes.begin(), notes.begin(), notes.end());
  std::vector<TakeTable> tables = read_tables(plan, errors, results, outcomes, control);
  const StudyErrors study(tables, plan.names, summary);
  set_reference(study, summary);
  const std::vector<MethodPair> pairs = pairs_of(study, summary, compared_with(summary.paper));
  parallel_for_index(tables.size(), 1, [&](std::size_t t) {
    control.check();
    tables[t].pairs = pair_errors(StoredTake::open(tables[t].samples), errors, pairs);
  });
  add_numbers(study, summary);
  const Numbers claimed = claimed_numbers(study);
  for (const Number& number : claimed.all())
    if (!summary.numbers.find(number)) summary.numbers.add(number);
  write_shown(plan, summary, outcome.tracking, folder);
  write_results(folder, summary);
  control.report(1.0);
}

Json inputs_json(const Plan& plan, std::span<const std::vector<TakeInput>> inputs) {
  Json list = Json::array();
  for (std::size_t t = 0; t < inputs.size(); ++t)
    for (const TakeInput& input : inputs[t])
      list.push_back({{"take", plan.takes[t].take.id},
                      {"role", input.role},
                      {"file", input.file},
                      {"bytes", input.bytes},
                      {"sha256", input.sha256.empty() ? Json() : Json(input.sha256)}});
  return list;
}

// The inputs and settings of the results. Files that cannot be read are listed without a hash.
Json manifest_of_plan(const Plan& plan, std::span<const std::vector<TakeInput>> inputs,
                      const std::vector<SimulationAssumption>& simulator) {
  Json methods = Json::array(), takes = Json::array();
  for (const Method& method : plan.methods) methods.push_back(method.spec.name);
  std::uint64_t instants = 0;
  for (const PlannedTake& planned : plan.takes) {
    instants += planned.instants;
    takes.push_back({{"id", planned.take.id},
                     {"participant", planned.take.participant},
                     {"activity", planned.take.activity},
                     {"mocap_start_host_ns", planned.take.mocap_start_host_ns},
                     {"instants", planned.instants}});
  }
  return manifest_of(json_of(plan.study), {{"campaign", plan.campaign.name},
                                           {"calibration", plan.campaign.calibration.filename().string()},
                                           {"simulator_sha256", hash_of_text(json_of(simulator).dump())},
                                           {"simulated", plan.simulated},
                                           {"rig", plan.rig},
                                           {"methods", methods},
                                           {"joints", plan.names},
                                           {"takes", takes},
                                           {"instants", instants},
                                           {"samples", instants * plan.names.size() * plan.methods.size()},
                                           {"inputs", inputs_json(plan, inputs)}});
}

void check_cross_check(const Plan& plan) {
  if (checked_methods(plan).empty())
    throw InputError("study \"" + plan.study.name + '"',
                     "has no nonlinear or newton method with damping lm and stop step that could be checked "
                     "against Ceres");
}

// Removes the methods that leave out the truly hidden views where these are not known.
StudySpec known_methods(StudySpec spec, const Campaign& campaign, std::vector<TakeNote>& notes) {
  if (std::ranges::all_of(campaign.takes, knows_hidden_views)) return spec;
  std::string names;
  for (const MethodSpec& method : spec.methods)
    if (asks_for_hidden(method)) names += (names.empty() ? "" : ", ") + method.name;
  if (names.empty()) return spec;
  std::erase_if(spec.methods, asks_for_hidden);
  if (spec.methods.empty())
    throw InputError("study \"" + spec.name + "\" /methods",
                     "leave out what is truly hidden, which simulations of generated persons alone know");
  notes.push_back(
      {"", false, "campaign.json",
       "is evaluated without " + names + ": simulations alone know which views are truly hidden"});
  return spec;
}

}  // namespace

ItemCounts run_accuracy(const AccuracyStudy& asked, const fs::path& folder, const StudyOptions& options) {
  const RunControl planning = control_of(options, "planning");
  HashCache hashes;
  hashes.load(folder);
  std::vector<TakeNote> notes;
  if (asks_for_wand(asked.study) && options.mark) options.mark();  // its poses are kept beside the results
  const StudySpec spec = known_methods(with_wand_poses(asked.study, asked.campaign, folder, hashes, planning),
                                       asked.campaign, notes);
  for (std::string& text : suspicious_names(asked.campaign))
    notes.push_back({"", false, "campaign.json", std::move(text)});
  std::vector<WatchedFiles> files;  // from before they are read
  for (const Take& take : takes_of(spec, asked.campaign).takes) files.push_back(watched_files(take));
  const Plan plan = make_plan(spec, asked.campaign, planning);
  if (asked.cross_check) check_cross_check(plan);
  const ErrorSettings errors{plan.study.alignments, plan.study.training_share, plan.study.occluded_apart,
                             plan.study.rate_hz};
  const std::vector<SimulationAssumption> simulator = read_simulation_assumptions(asked.campaign.folder);

  std::vector<ResultsRun::Item> items;
  for (const PlannedTake& planned : plan.takes)
    items.push_back({"takes/" + planned.take.id, cost_of(planned)});
  ResultsRun run(folder, items, options);
  std::vector<std::vector<TakeInput>> inputs(plan.takes.size());
  run.find_keys([&](std::size_t t, const RunControl& control) {
    inputs[t] = inputs_of(plan.takes[t].take, hashes, control.stop_requested);
    const bool read =
        std::ranges::none_of(inputs[t], [](const TakeInput& input) { return input.sha256.empty(); });
    if (!plan.takes[t].ok || !read || files[t].changed()) return std::string();
    return key_of_take(plan, t, inputs[t], asked.cross_check);
  });
  const Json manifest = manifest_of_plan(plan, inputs, simulator);
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  if (run.is_whole()) hashes.save(folder);
  run.compute([&](std::size_t t, const fs::path& into, const RunControl& control) {
    return evaluate(plan, t, inputs[t], files[t], errors, asked.cross_check, into, control);
  });
  if (run.is_whole())
    run.publish_results(manifest, [&](const fs::path& into) {
      if (!simulator.empty()) write_simulation_assumptions(into, simulator);
      write_study(plan, errors, notes, asked.cross_check, run, into, run.control("summary"));
    });
  return run.tally();
}

ResultsSummary execute_study(const StudySpec& spec, const Campaign& campaign, const fs::path& output,
                             const ExecuteOptions& options) {
  StudyOptions run{.stop_requested = options.stop_requested};
  constexpr double kTakesShare = 0.8;  // of the progress; the rest is the summary
  if (options.progress)
    run.progress = [&](const std::string& stage, double share) {
      if (stage == "takes") options.progress(kTakesShare * share);
      if (stage == "summary") options.progress(kTakesShare + (1.0 - kTakesShare) * share);
    };
  on_threads(options.threads, [&](int) { run_accuracy({spec, campaign, options.cross_check}, output, run); });
  return read_results<ResultsSummary>(output);
}

double cost_of(const PlannedTake& take) { return static_cast<double>(take.instants) + 1.0; }

std::vector<TakeNote> notes_of(const ItemCounts& tally) {
  std::vector<TakeNote> notes;
  for (const auto& [id, outcome] : tally.failed)
    for (TakeNote& note : read_as<TakeResult>(outcome, {id, {}}).notes) notes.push_back(std::move(note));
  return notes;
}

}  // namespace trilat
