// SPDX-License-Identifier: MIT
// Input and output of `trilat run` for studies of kind accuracy.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/text_output.h"
#include "datasets/rig/calibration.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/shown/accuracy_words.h"
#include "pipeline/accuracy/wand_poses.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/kinds.h"

namespace trilat {
namespace {

// Shard of each take, 1 to `shards`.
std::vector<std::uint64_t> owners_of(const Plan& plan, std::uint64_t shards) {
  std::vector<double> costs;
  for (const PlannedTake& take : plan.takes) costs.push_back(cost_of(take));
  return shards_of(costs, shards);
}

Json plan_json(const Plan& plan, const std::vector<std::uint64_t>& owner) {
  Json takes = Json::array(), methods = Json::array();
  for (std::size_t i = 0; i < plan.takes.size(); ++i) {
    const PlannedTake& t = plan.takes[i];
    Json entry{
        {"id", t.take.id}, {"participant", t.take.participant}, {"activity", t.take.activity}, {"ok", t.ok}};
    entry["shard"] = owner[i];
    if (t.ok)
      entry["instants"] = t.instants;
    else
      entry["problem"] = t.place + ": " + t.problem;
    takes.push_back(entry);
  }
  for (const Method& m : plan.methods) methods.push_back(m.spec.name);
  return {{"study", plan.study.name}, {"campaign", plan.campaign.name},
          {"rig", plan.rig},          {"joints", plan.names},
          {"methods", methods},       {"takes", takes}};
}

int print_plan(const Plan& plan, const Shard& shard, bool json) {
  const bool all_ok = std::ranges::all_of(plan.takes, [](const PlannedTake& t) { return t.ok; });
  const std::vector<std::uint64_t> owner = owners_of(plan, shard.of);
  if (json) {
    fmt::print("{}\n", json_text(plan_json(plan, owner), 2));
    return all_ok ? kDone : kItemsFailed;
  }
  fmt::print("study {} on campaign {}: {} takes x {} joints x {} methods\n", plan.study.name,
             plan.campaign.name, plan.takes.size(), plan.names.size(), plan.methods.size());
  fmt::print("methods:");
  for (const Method& m : plan.methods) fmt::print(" {};", m.spec.name);
  fmt::print("\n");
  const auto first = std::ranges::find_if(plan.takes, &PlannedTake::ok);
  for (std::size_t m = 0; first != plan.takes.end() && m < plan.methods.size(); ++m)
    if (const auto status = status_if_never_solved(first->world_from_sensor, plan.methods[m]))
      fmt::print("note: {} answers nothing on this rig ({}){}\n", plan.methods[m].spec.name, name_of(*status),
                 m == plan.reference ? ": the others are compared with the first that answers" : "");
  for (std::size_t i = 0; i < plan.takes.size(); ++i) {
    const PlannedTake& t = plan.takes[i];
    if (owner[i] != shard.number) continue;
    if (t.ok)
      fmt::print("  {:<20} {} instants\n", t.take.id, t.instants);
    else
      fmt::print("  {:<20} cannot be evaluated: {}: {}\n", t.take.id, t.place, t.problem);
  }
  return all_ok ? kDone : kItemsFailed;
}

void print_notes(const std::vector<TakeNote>& notes) {
  for (const TakeNote& note : notes)
    fmt::print(stderr, "{}: {}{}: {}\n", note.failed ? "failed" : "note",
               note.take.empty() ? "" : "take " + note.take + ": ", note.place, note.text);
}

void print_cross_check(const ResultsSummary& summary) {
  for (const CrossCheck& c : summary.cross_checks) {
    const std::string verdict = c.passed()       ? "agrees"
                                : c.samples == 0 ? "NOTHING COMPARED: no sample has an answer of both"
                                                 : fmt::format("DISAGREES (limit {:g} m)", c.limit_m);
    fmt::print(
        stderr,
        "cross-check of \"{}\" with Ceres: {} samples, worst {:.3g} m at {}, {} answered by one only, {} "
        "objectives lost: {}\n",
        c.method, c.samples, c.worst_m, c.worst_at.empty() ? "none" : c.worst_at, c.disagreements, c.lost,
        verdict);
  }
}

}  // namespace

Json errors_json(const ResultsSummary& s, std::span<const std::string> alignments) {
  Json rows = Json::array();
  for (const Number& asked : s.numbers.all()) {
    if (asked.measure != "answered" || asked.statistic != "share" || !asked.take.empty()) continue;
    if (std::ranges::find(alignments, asked.alignment) == alignments.end()) continue;
    const auto of = [&](const char* statistic) {
      const Number* number = s.numbers.find(asked.with({.measure = "distance", .statistic = statistic}));
      return number ? *number : Number{};
    };
    const Number error = of("mean");
    rows.push_back({{"condition", asked.condition},
                    {"group", asked.group},
                    {"method", asked.method},
                    {"alignment", asked.alignment},
                    {"asked", asked.n},
                    {"answered", error.n},
                    {"coverage", asked.value},
                    {"mae_m", error.value},
                    {"mae_low_m", error.low},
                    {"mae_high_m", error.high},
                    {"clusters", error.clusters},
                    {"median_m", of("median").value},
                    {"p95_m", of("p95").value}});
  }
  return rows;
}

Campaign campaign_of(const std::filesystem::path& of_study, const RunArguments& arguments) {
  const std::filesystem::path folder = arguments.campaign.empty() ? of_study : arguments.campaign;
  if (folder.empty())
    throw InputError(arguments.study.string() + " /campaign",
                     "is missing; name it there or with --campaign DIR");
  Campaign campaign = read_campaign(folder);
  if (!arguments.calibration.empty()) {
    read_calibration(arguments.calibration);  // one error now instead of one a take
    campaign.calibration = arguments.calibration;
    for (Take& take : campaign.takes) take.calibration = arguments.calibration;
  }
  return campaign;
}

std::vector<std::filesystem::path> inputs_of(const Campaign& campaign) {
  std::vector<std::filesystem::path> inputs{campaign.folder};
  for (const Take& t : campaign.takes)
    inputs.insert(inputs.end(), {t.session, t.calibration, t.mocap, t.mapping});
  if (campaign.wand) inputs.insert(inputs.end(), {campaign.wand->session, campaign.wand->mocap});
  return inputs;
}

OpenedStudy open_accuracy(const RunArguments& arguments, const Json& json) {
  const StudySpec spec = parse_study(json, arguments.study.string(), arguments.study.parent_path());
  const Campaign campaign = campaign_of(spec.campaign, arguments);
  return {.run = [study = AccuracyStudy{spec, campaign, arguments.cross_check}, output = arguments.output](
                     const StudyOptions& options) { return run_accuracy(study, output, options); },
          .print_plan =
              [=](const Shard& shard, bool as_json, const RunControl& control) {
                return print_plan(make_plan(spec, campaign, control), shard, as_json);
              },
          .inputs = inputs_of(campaign),
          .campaign = campaign,
          .print_failed = [](const ItemCounts& tally) { print_notes(notes_of(tally)); }};
}

int print_accuracy(const std::filesystem::path& results, Json document, const PrintOptions& shown) {
  const ResultsSummary summary = read_results<ResultsSummary>(results);
  print_notes(summary.notes);
  print_cross_check(summary);
  const bool passed = summary.cross_checks.empty() || summary.cross_check_passed();
  if (shown.json) {
    document["results"] = results.string();
    document["takes"] = summary.takes;
    document["takes_failed"] = summary.takes_failed;
    document["cross_check_passed"] = summary.cross_checks.empty() ? Json() : Json(passed);
    document["errors"] = errors_json(summary, std::span(summary.alignments).first(1));
    document["best"] = json_of(summary.best);
    document["warnings"] = accuracy_warnings(summary);
    fmt::print("{}\n", json_text(document, 2));
  } else {
    print_stored(results, shown.tables);
    fmt::print("results: {}\n", results.string());
    if (!shown.tables)
      fmt::print("next: trilat report {} -o report; --tables prints all tables here\n",
                 shell_word(results.string()));
  }
  return summary.takes_failed == 0 && passed ? kDone : kItemsFailed;
}

}  // namespace trilat
