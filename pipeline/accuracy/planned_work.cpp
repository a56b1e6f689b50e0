// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/planned_work.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

PlannedTake read_planned_take(JsonObject& entry) {
  PlannedTake planned;
  planned.take.id = entry.text("id");
  planned.take.participant = entry.text("participant");
  planned.take.activity = entry.text("activity");
  planned.take.mocap_start_host_ns = entry.integer("mocap_start_host_ns");
  planned.take.up_axis =
      static_cast<UpAxis>(entry.choice("up_axis", {kUpAxisNames.begin(), kUpAxisNames.end()}, 0));
  planned.take.left_out = entry.text("left_out", "");
  planned.ok = entry.boolean("ok", false);
  planned.instants = entry.count("instants");
  entry.finish();
  return planned;
}

// What the files of the takes are: the contents of those that planning reads whole, the sizes of the others,
// which only the shard reads whose take it is.
Json inputs_json(const Campaign& campaign, HashCache& hashes, const Watch& watch) {
  Json takes = Json::object();
  for (const Take& take : campaign.takes)
    for (const TakeFile& file : files_of(take)) {
      Json& entry = takes[take.id][file.role];
      entry["file"] = file.path.filename().string();
      // looked at twice: what fails for a moment must not set this part apart from the others
      if (file.path == take.calibration || file.path == take.mapping) {
        HashedFile hashed = hashes.hash(file.path, watch.stop_requested);
        if (hashed.sha256.empty()) hashed = hashes.hash(file.path, watch.stop_requested);
        entry["sha256"] = hashed.sha256;
      } else if (auto identity = identity_of(file.path); identity || (identity = identity_of(file.path))) {
        entry["bytes"] = identity->bytes;
      }
    }
  return takes;
}

// Of a study, what a take's samples do not depend on.
constexpr const char* kOfTheSummary[] = {"name",      "conditions",     "occluded_apart",
                                         "reference", "alignments",     "block_s",
                                         "resamples", "training_share", "cross_check_limit_m"};

// Everything that a take is; its files by their content.
Json json_of(const Take& take, std::span<const TakeInput> inputs) {
  // A field that is added to a take stops this line, so that none is forgotten below.
  const auto& [id, participant, activity, session, calibration, mocap, mapping, mocap_start_host_ns, up_axis,
               left_out] = take;
  Json json{{"id", id},
            {"participant", participant},
            {"activity", activity},
            {"mocap_start_host_ns", mocap_start_host_ns},
            {"up_axis", kUpAxisNames.at(static_cast<std::size_t>(up_axis))},
            {"left_out", left_out}};
  for (const TakeInput& input : inputs) json[input.role] = {input.file, input.sha256};
  return json;
}

}  // namespace

Json planned_work(const Plan& plan, bool cross_check, HashCache& hashes, const Watch& watch) {
  Json takes = Json::array(), joints = Json::array();
  for (const PlannedTake& t : plan.takes)
    takes.push_back({{"id", t.take.id},
                     {"participant", t.take.participant},
                     {"activity", t.take.activity},
                     {"mocap_start_host_ns", t.take.mocap_start_host_ns},
                     {"up_axis", kUpAxisNames.at(static_cast<std::size_t>(t.take.up_axis))},
                     {"left_out", t.take.left_out},
                     {"ok", t.ok},
                     {"instants", t.instants}});
  for (const Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  return {{"study", resolved_json(plan.study)},
          {"cross_check", cross_check},
          {"campaign", plan.campaign.name},
          {"campaign_simulated", plan.campaign.simulated},
          {"simulated", plan.simulated},
          {"rig", plan.rig},
          {"joints", joints},
          {"takes", takes},
          {"inputs", inputs_json(plan.campaign, hashes, watch)},
          {"parameters", json_of(read_declared_parameters(plan.campaign.folder))}};
}

PlannedWork read_planned_work(const Json& json, const std::string& place) {
  JsonObject work(json, place, "/work");
  PlannedWork read;
  Plan& plan = read.plan;
  plan.study = parse_study(work.value("study"), place, {});
  plan.campaign.name = work.text("campaign");
  plan.campaign.simulated = work.boolean("campaign_simulated", false);
  plan.simulated = work.boolean("simulated", false);
  plan.rig = work.texts("rig");
  plan.methods = resolve_methods(plan.study, plan.rig);
  plan.reference = reference_of(plan.study, plan.methods);
  for (const std::string& name : work.texts("joints")) {
    const auto joint = joint_from_name(name);
    if (!joint) work.refuse("joints", "has \"" + name + "\", which is no joint");
    plan.joints.push_back(*joint);
  }
  for (JsonObject& entry : work.objects("takes")) {
    plan.takes.push_back(read_planned_take(entry));
    plan.campaign.takes.push_back(plan.takes.back().take);
  }
  if (!work.has("cross_check")) work.refuse("cross_check", "is missing");
  read.cross_check = work.boolean("cross_check", false);
  work.value("inputs");
  read.parameters = read_list<DeclaredParameter>(work, "parameters");
  work.finish();
  return read;
}

std::vector<TakeFile> files_of(const Take& take) {
  std::vector<TakeFile> files{{"session", take.session}, {"calibration", take.calibration}};
  if (!take.mocap.empty()) {
    files.push_back({"mocap", take.mocap});
    files.push_back({"mapping", take.mapping});
  }
  return files;
}

WatchedFiles watched_files(const Take& take) {
  WatchedFiles watched;
  for (const TakeFile& file : files_of(take)) watched.add(file.path);
  return watched;
}

std::vector<TakeInput> inputs_of(const Take& take, HashCache& hashes,
                                 const std::function<bool()>& stop_requested) {
  std::vector<TakeInput> inputs;
  for (const TakeFile& file : files_of(take)) {
    const HashedFile hashed = hashes.hash(file.path, stop_requested);
    inputs.push_back({file.role, file.path.filename().string(), hashed.bytes, hashed.sha256});
  }
  return inputs;
}

std::string key_of_take(const Plan& plan, std::size_t take, std::span<const TakeInput> inputs,
                        bool cross_check) {
  Json study = resolved_json(plan.study);
  for (const char* key : kOfTheSummary) study.erase(key);
  Json joints = Json::array();
  for (const Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  return key_of({{"study", study},
                 {"rig", plan.rig},
                 {"joints", joints},
                 {"cross_check", cross_check},
                 {"judges_places", judges_places(plan.study)},
                 {"replayed", is_replayed(plan, take)},
                 {"take", json_of(plan.takes[take].take, inputs)}});
}

std::string key_of_run(const RunIdentity& run) {
  Json takes = Json::array();
  for (std::size_t t = 0; t < run.takes.size(); ++t) takes.push_back(json_of(run.takes[t], run.inputs[t]));
  return key_of({{"study", resolved_json(run.study)},
                 {"cross_check", run.cross_check},
                 {"campaign", run.campaign},
                 {"simulated", run.simulated},
                 {"parameters", json_of(run.parameters)},
                 {"takes", takes}});
}

}  // namespace trilat
