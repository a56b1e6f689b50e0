// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take_key.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

// Of a study, what a take's samples do not depend on.
constexpr const char* kOfTheSummary[] = {"name",       "conditions",     "occluded_apart",     "reference",
                                         "alignments", "training_share", "cross_check_limit_m"};

// Everything that a take is; its files by their content.
Json json_of(const Take& take, std::span<const TakeInput> inputs) {
  // A field that is added to a take stops this line, so that none is forgotten below.
  const auto& [id, participant, activity, session, calibration, mocap, mapping, mocap_start_host_ns,
               up_axis] = take;
  Json json{{"id", id},
            {"participant", participant},
            {"activity", activity},
            {"mocap_start_host_ns", mocap_start_host_ns},
            {"up_axis", kUpAxisNames.at(static_cast<std::size_t>(up_axis))}};
  for (const TakeInput& input : inputs) json[input.role] = {input.file, input.sha256};
  return json;
}

}  // namespace

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

}  // namespace trilat
