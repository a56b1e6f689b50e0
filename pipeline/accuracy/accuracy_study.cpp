// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/accuracy_study.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/results/declared_parameters.h"
#include "datasets/results/item_store.h"
#include "datasets/results/results_file.h"
#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/shown/accuracy_shown.h"
#include "pipeline/accuracy/take/hidden_views.h"
#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/take_key.h"
#include "pipeline/accuracy/wand_poses.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/errors/numbers.h"
#include "pipeline/study/machine.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

// The first part of the ids of takes.
std::string item_of(const PlannedTake& planned) { return "takes/" + planned.take.id; }

// The state that all items of one study share.
struct AccuracyRun {
  Plan plan;
  bool cross_check = false;
  std::shared_ptr<HashCache> hashes;
  ErrorSettings errors;
  std::vector<TakeNote> notes;                    // on the campaign
  std::vector<WatchedFiles> files;                // by take, from before the plan was made
  std::vector<std::vector<TakeInput>> inputs;     // by take, once its key was asked for
  std::vector<std::optional<TakeErrors>> tables;  // by take, of those that were evaluated
  std::vector<DeclaredParameter> parameters;      // of the simulator that made the campaign
};

void replace_all(std::string& text, const std::string& old, const std::string& with) {
  if (old.empty() || old == with) return;
  for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
    text.replace(at, old.size(), with);
}

// From the campaign's folder; the name alone where the file lies elsewhere.
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

std::string key_of_take(AccuracyRun& run, std::size_t t, const Watch& watch) {
  const PlannedTake& planned = run.plan.takes[t];
  run.inputs[t] = inputs_of(planned.take, *run.hashes, watch.stop_requested);
  const bool read =
      std::ranges::none_of(run.inputs[t], [](const TakeInput& input) { return input.sha256.empty(); });
  if (!planned.ok || !read || run.files[t].changed()) return "";
  return trilat::key_of_take(run.plan, t, run.inputs[t], run.cross_check);
}

TakeResult evaluate(AccuracyRun& run, std::size_t t, const fs::path& into, const Watch& watch) {
  const PlannedTake& planned = run.plan.takes[t];
  if (!planned.ok) throw InputError(planned.place, planned.problem);
  for (const TakeInput& input : run.inputs[t])
    if (input.sha256.empty()) throw InputError(input.file, "cannot be read to its end");
  auto [result, table] = evaluate_take(run.plan, t, run.errors, run.cross_check, into, watch);
  run.files[t].check();
  run.tables[t] = std::move(table);
  result.inputs = run.inputs[t];
  for (TakeNote& note : result.notes) note = within_campaign(note, planned.take, run.plan.campaign);
  return std::move(result);
}

Computed compute(AccuracyRun& run, std::size_t t, const fs::path& into, const Watch& watch) {
  const Take& take = run.plan.takes[t].take;
  try {
    return json_of(evaluate(run, t, into, watch));
  } catch (const OutputError&) {
    throw;
  } catch (const InputError& error) {
    for (const fs::directory_entry& entry : fs::directory_iterator(into)) fs::remove_all(entry.path());
    TakeResult failed;
    failed.inputs = run.inputs[t];
    failed.notes = {
        within_campaign({take.id, true, error.place(), error.problem()}, take, run.plan.campaign)};
    return {json_of(failed), true};
  }
}

// The part of a summary that needs no errors.
ResultsSummary summary_head(const Plan& plan, const RunOutcome& outcome) {
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
    summary.legend.push_back({spec.name, std::string(spec.kind->what), spec.kind == &brought_kind()});
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

// Gives the error table of a take, which this run computed or an earlier one stored.
TakeErrors errors_of_take(AccuracyRun& run, std::size_t t, const Outcome& outcome) {
  if (run.tables[t]) return std::move(*std::exchange(run.tables[t], {}));
  return stored_errors(ItemStore(outcome.folder.parent_path().parent_path()), outcome.key, run.errors);
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

// Adds how the truth moves and where nonlinear errs, of which the study's errors say nothing.
void add_movement(const Plan& plan, const Outcome& outcome, TakeTable& table) {
  const auto method =
      std::ranges::find(plan.methods, std::string("nonlinear"), [](const Method& m) { return m.spec.name; });
  if (method == plan.methods.end()) return;
  table.movement = movement_of(StoredTake::open(outcome.folder / StoredTake::kName), table.errors,
                               static_cast<std::size_t>(method - plan.methods.begin()), plan.study.rate_hz);
}

// The table and the figure of stages come first, and no other.
void show_stages(const StudySpec& study, const ResultsSummary& summary, StoredTables& shown,
                 StoredFigures& figures) {
  for (Table& table : shown.tables)
    if (table.shown == Table::Shown::first) table.shown = Table::Shown::detail;
  std::vector<std::string> names;
  for (const Stage& stage : study.stages) names.push_back(stage.name);
  shown.findings = stages_findings(summary, names);
  shown.warnings = stages_warnings(summary, names);
  figures.figures = stages_figures(summary, names);
  std::vector<Table> tables = stages_tables(summary, names);
  for (Table& table : tables) table.shown = Table::Shown::first;
  shown.tables.insert(shown.tables.begin(), tables.begin(), tables.end());
}

void put_together(AccuracyRun& run, const Outcomes& outcomes, const fs::path& folder, const Watch& watch) {
  constexpr double kTakesShare = 0.8;  // of the progress
  std::vector<TakeResult> results;
  std::vector<const Outcome*> of_take;
  for (const PlannedTake& planned : run.plan.takes) {
    const Outcome& outcome = *of_take.emplace_back(&outcomes.at(item_of(planned)));
    results.push_back(read_as<TakeResult>(JsonObject(outcome.json, outcome.place(), "")));
  }
  leave_out_repeated(run.plan, results);
  std::vector<TakeTable> tables(results.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(tables.size(), 1, [&](std::size_t t) {
    watch.check();
    const Take& take = run.plan.takes[t].take;
    if (results[t].evaluated)
      tables[t] = {take.id, take.participant, take.activity, errors_of_take(run, t, *of_take[t]),
                   of_take[t]->folder / StoredTake::kName};
    if (results[t].evaluated && run.plan.study.paper == PaperStudy::table3)
      add_movement(run.plan, *of_take[t], tables[t]);
    watch.tell(kTakesShare * static_cast<double>(++done) / static_cast<double>(tables.size()));
  });
  std::erase_if(tables, [](const TakeTable& table) { return table.id.empty(); });
  const RunOutcome outcome = outcome_of(run.plan, results, run.cross_check);
  write_beside(folder, outcome.tracking);
  ResultsSummary summary = summary_head(run.plan, outcome);
  summary.notes.insert(summary.notes.begin(), run.notes.begin(), run.notes.end());
  const StudyErrors errors(tables, run.plan.names, summary);
  set_reference(errors, summary);
  const std::vector<MethodPair> pairs = pairs_of(errors, summary, compared_with(summary.paper));
  parallel_for_index(tables.size(), 1, [&](std::size_t t) {
    watch.check();
    tables[t].pairs = pair_errors(StoredTake::open(tables[t].samples), run.errors, pairs);
  });
  add_numbers(errors, summary);
  summary.claims = claims_of(errors);
  StoredTables shown = accuracy_shown(summary, outcome.tracking);
  if (run.plan.rig.empty()) {
    auto place = shown.tables.begin();
    for (const std::string& condition : summary.conditions) {
      Table table = files_table(summary, condition);
      table.shown = Table::Shown::first;
      place = std::next(shown.tables.insert(place, std::move(table)));
    }
  }
  for (Table& table : angle_tables(shown_summary(summary))) {
    if (run.plan.rig.empty()) table.shown = Table::Shown::first;
    shown.tables.push_back(std::move(table));
  }
  for (Table& table : agreement_tables(summary)) {
    table.shown = Table::Shown::file;
    shown.tables.push_back(std::move(table));
  }
  StoredFigures figures{accuracy_figures(shown_summary(summary))};
  for (Figure& figure : angle_figures(shown_summary(summary))) figures.figures.push_back(std::move(figure));
  if (!run.plan.study.stages.empty()) show_stages(run.plan.study, summary, shown, figures);
  store_tables(folder, std::move(shown));
  write_beside(folder, figures);
  write_summary(folder, summary);
  watch.tell(1.0);
}

Json inputs_json(const AccuracyRun& run) {
  Json list = Json::array();
  for (std::size_t t = 0; t < run.inputs.size(); ++t)
    for (const TakeInput& input : run.inputs[t])
      list.push_back({{"take", run.plan.takes[t].take.id},
                      {"role", input.role},
                      {"file", input.file},
                      {"bytes", input.bytes},
                      {"sha256", input.sha256.empty() ? Json() : Json(input.sha256)}});
  return list;
}

// The inputs and settings of the results. Files that cannot be read are listed without a hash.
Json manifest_of_run(const AccuracyRun& run) {
  const Plan& plan = run.plan;
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
  return manifest_of(resolved_json(plan.study),
                     {{"campaign", plan.campaign.name},
                      {"calibration", plan.campaign.calibration.filename().string()},
                      {"simulator_sha256", hash_of_text(json_of(run.parameters).dump())},
                      {"simulated", plan.simulated},
                      {"rig", plan.rig},
                      {"methods", methods},
                      {"joints", plan.names},
                      {"takes", takes},
                      {"instants", instants},
                      {"samples", instants * plan.names.size() * plan.methods.size()},
                      {"inputs", inputs_json(run)}});
}

Item item_of_take(const std::shared_ptr<AccuracyRun>& run, std::size_t t) {
  const PlannedTake& planned = run->plan.takes[t];
  return {item_of(planned), cost_of(planned),
          [run, t](const fs::path& into, const Watch& watch) { return compute(*run, t, into, watch); },
          [run, t](const Watch& watch) { return key_of_take(*run, t, watch); }};
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

Study accuracy_study(const StudySpec& given, const Campaign& campaign, bool cross_check,
                     const std::shared_ptr<HashCache>& hashes, const Watch& watch) {
  const auto run = std::make_shared<AccuracyRun>();
  const StudySpec spec = known_methods(given, campaign, run->notes);
  for (const Take& take : takes_of(spec, campaign).takes) run->files.push_back(watched_files(take));
  run->plan = make_plan(spec, campaign, watch);
  if (cross_check) check_cross_check(run->plan);
  run->cross_check = cross_check;
  run->hashes = hashes;
  run->inputs.resize(run->plan.takes.size());
  run->tables.resize(run->plan.takes.size());
  const StudySpec& study_of = run->plan.study;
  run->errors = {study_of.alignments, study_of.training_share, study_of.occluded_apart, study_of.rate_hz};
  for (std::string& text : oddities_of(campaign)) run->notes.push_back({"", false, "campaign.json", text});
  run->parameters = read_declared_parameters(campaign.folder);
  Study study{.kind = name_of(StudyKind::accuracy),
              .settings = resolved_json(run->plan.study),
              .write_beside =
                  [run](const fs::path& folder) {
                    if (!run->parameters.empty()) write_declared_parameters(folder, run->parameters);
                  },
              .reduce = [run](const Outcomes& outcomes, const fs::path& folder,
                              const Watch& reading) { put_together(*run, outcomes, folder, reading); },
              .manifest = [run] { return manifest_of_run(*run); },
              .hashes = hashes};
  for (std::size_t t = 0; t < run->plan.takes.size(); ++t) study.items.push_back(item_of_take(run, t));
  return study;
}

ResultsSummary execute_study(const StudySpec& spec, const Campaign& campaign, const fs::path& output,
                             const ExecuteOptions& options) {
  const auto hashes = std::make_shared<HashCache>();
  hashes->load(output);
  StudyOptions run{.threads = options.threads, .stop_requested = options.stop_requested};
  constexpr double kTakesShare = 0.8;  // of the progress; the rest is the summary
  if (options.progress)
    run.progress = [&](const std::string& stage, double share) {
      if (stage == "takes") options.progress(kTakesShare * share);
      if (stage == "summary") options.progress(kTakesShare + (1.0 - kTakesShare) * share);
    };
  on_threads(options.threads, [&](int) {
    const Watch watch{options.stop_requested, {}};
    run_study(accuracy_study(with_wand_poses(spec, campaign, output, *hashes, watch), campaign,
                             options.cross_check, hashes, watch),
              output, run);
  });
  return read_summary(output);
}

double cost_of(const PlannedTake& take) { return static_cast<double>(take.instants) + 1.0; }

std::vector<TakeNote> notes_of(const ItemTally& tally) {
  std::vector<TakeNote> notes;
  for (const auto& [id, outcome] : tally.failed)
    for (TakeNote& note : read_as<TakeResult>(JsonObject(outcome, id, "")).notes)
      notes.push_back(std::move(note));
  return notes;
}

}  // namespace trilat
