// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take_key.h"

#include <nlohmann/json.hpp>

#include "pipeline/accuracy/replay_take.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

// Of a study, what a take's samples do not depend on.
constexpr const char* kOfTheSummary[] = {
    "name",    "conditions", "occluded_apart", "reference",      "alignments",
    "block_s", "resamples",  "clock_error_s",  "training_share", "cross_check_limit_m"};

Json json_of(const Take& take, std::span<const TakeInput> inputs) {
  Json json{{"id", take.id},
            {"participant", take.participant},
            {"activity", take.activity},
            {"mocap_start_host_ns", take.mocap_start_host_ns}};
  for (const TakeInput& input : inputs) json[input.role] = {input.file, input.sha256};
  return json;
}

}  // namespace

std::vector<TakeFile> files_of(const Take& take) {
  std::vector<TakeFile> files{{"session", take.session},
                              {"calibration", take.calibration},
                              {"mocap", take.mocap},
                              {"mapping", take.mapping}};
  if (!take.tracker_truth.empty()) files.push_back({"tracker_truth", take.tracker_truth});
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
                 {"replayed", is_replayed(plan, take)},
                 {"take", json_of(plan.takes[take].take, inputs)}});
}

std::string key_of_run(const RunIdentity& run) {
  Json takes = Json::array(), parameters = Json::array();
  for (std::size_t t = 0; t < run.takes.size(); ++t) takes.push_back(json_of(run.takes[t], run.inputs[t]));
  for (const DeclaredParameter& p : run.parameters) parameters.push_back({p.name, p.value, p.unit, p.source});
  return key_of({{"study", resolved_json(run.study)},
                 {"cross_check", run.cross_check},
                 {"campaign", run.campaign},
                 {"simulated", run.simulated},
                 {"parameters", parameters},
                 {"takes", takes}});
}

}  // namespace trilat
