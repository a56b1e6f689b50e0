// SPDX-License-Identifier: MIT
// `trilat simulate`.
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/words.h"
#include "datasets/session/session_verify.h"
#include "pipeline/cli/check_output.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/progress.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/simulate/calibration_recordings.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

struct SimulateArguments {
  std::filesystem::path spec;
  std::filesystem::path output;
  bool force = false;  // may replace what others wrote
  bool json = false;
};

std::vector<std::filesystem::path> files_of(const SimulateArguments& arguments, const SimulationSpec& spec) {
  std::vector<std::filesystem::path> files{arguments.spec};
  if (spec.recorded) files.insert(files.end(), {spec.recorded->mocap, spec.recorded->mapping});
  if (!spec.body_tracker.file.empty()) files.push_back(spec.body_tracker.file);
  return files;
}

void print_campaign(const std::filesystem::path& folder, const SimulationSpec& spec, bool as_json) {
  const Campaign campaign = read_campaign(folder);
  for (const Take& take : campaign.takes)
    if (has_no_bodies(SessionReader(take.session)))
      fmt::print(stderr, "warning: {}: no sensor sees anybody: do those of \"rig\" look at \"centre_m\"?\n",
                 take.id);
  const std::filesystem::path wand = folder / "wand";
  if (as_json) {
    Json takes = Json::array();
    for (const Take& take : campaign.takes) takes.push_back(take.id);
    Json json{{"campaign", folder.string()}, {"takes", takes}};
    if (spec.wand)
      json["wand"] = {{"session", (wand / "session.h5").string()},
                      {"mocap", (wand / "mocap.csv").string()},
                      {"mocap_start_host_ns", wand_mocap_start(spec).ns}};
    fmt::print("{}\n", json_text(json, 2));
    return;
  }
  const SessionReader first(campaign.takes.front().session);
  std::set<std::string> people, activities;
  for (const Take& take : campaign.takes) {
    people.insert(take.participant);
    activities.insert(take.activity);
  }
  fmt::print("{} of {} and {} ({}): {}\n", counted(campaign.takes.size(), "simulated take"),
             counted(people.size(), "participant"), counted(first.header().sensors.size(), "sensor"),
             fmt::join(activities, ", "), (folder / "campaign.json").string());
  if (spec.wand)
    fmt::print("wand recording: {} (mocap starts at host clock {} ns)\n", (wand / "session.h5").string(),
               wand_mocap_start(spec).ns);
}

// Simulates what the arguments' documents say, as long as they stay as they are.
ItemCounts record(const SimulateArguments& arguments, Progress& progress) {
  WatchedFiles inputs({arguments.spec});
  const SimulationSpec spec = read_simulation(arguments.spec);
  std::string sha256;
  for (const std::filesystem::path& file : files_of(arguments, spec)) {
    if (file != arguments.spec) inputs.add(file);
    sha256 += hash_of_file(file);
  }
  return record_campaign(spec, hash_of_text(sha256), inputs, arguments.output,
                         {.stop_requested = stop_requested,
                          .progress = [&](const std::string&, double share) { progress.set(share); }});
}

int simulate(const SimulateArguments& arguments) {
  const SimulationSpec spec = read_simulation(arguments.spec);
  const OutputMark mark{"simulate", {spec.name}};
  check_output_folder({arguments.output, files_of(arguments, spec), arguments.force}, mark);
  mark_output(arguments.output, mark);
  ItemCounts tally;
  {
    Progress progress("simulating");
    try {
      on_threads(0, [&](int) { tally = record(arguments, progress); });
    } catch (const Interrupted&) {
      tell_interrupted(arguments.output);
      return kInterrupted;
    }
  }
  print_item_counts("recordings", tally);
  print_campaign(arguments.output, spec, arguments.json);
  return kDone;
}

}  // namespace

void add_simulate(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<SimulateArguments>(
      app, code, "simulate", "virtual Kinects watch a generated person or a real OptiTrack take", simulate);
  verb.add_option("spec", a.spec, "simulation.json")->required();
  verb.add_option("-o,--output", a.output, "folder of the campaign")->required();
  add_force(verb, a.force);
  add_json(verb, a.json);
}

}  // namespace trilat
