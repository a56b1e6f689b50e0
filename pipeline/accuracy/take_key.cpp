// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take_key.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "pipeline/accuracy/evaluate_take.h"
#include "pipeline/study/hash_cache.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

// Keys of a study that a take's samples do not depend on.
constexpr const char* kOfTheSummary[] = {"name",      "paper",      "conditions",     "occluded_apart",
                                         "reference", "alignments", "training_share", "cross_check_limit_m"};

// Everything that a take is; its files by their content.
Json json_of(const Take& take, std::span<const TakeInput> inputs) {
  // A field that is added to a take stops this line, so that none is forgotten below.
  const auto& [id, participant, activity, session, calibration, mocap, mapping, mocap_start_host_ns, up_axis,
               joints] = take;
  Json json{{"id", id},
            {"participant", participant},
            {"activity", activity},
            {"mocap_start_host_ns", mocap_start_host_ns},
            {"up_axis", word_of(up_axis.value_or(UpAxis::y))}};
  for (const TakeInput& input : inputs) json[input.role] = {input.file, input.sha256};
  for (const ExternalJoints& one : joints) {
    Json points = Json::object();
    for (const NamedPoint& point : one.mapping) points[point.name] = point.assets;
    json["external"].push_back({one.method, points, one.clock_by_motion});
  }
  return json;
}

}  // namespace

std::vector<TakeFile> files_of(const Take& take) {
  std::vector<TakeFile> files{{"session", take.session},
                              {"calibration", take.calibration},
                              {"mocap", take.mocap},
                              {"mapping", take.mapping}};
  for (const ExternalJoints& joints : take.joints)
    files.push_back({"joints of " + joints.method, joints.file});
  std::erase_if(files, [](const TakeFile& file) { return file.path.empty(); });
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
  Json study = json_of(at_stage(plan.study, plan.takes[take].stage));
  for (const char* key : kOfTheSummary) study.erase(key);
  Json external = Json::array();
  for (std::size_t m = first_external(plan); m < plan.methods.size(); ++m)
    external.push_back(plan.methods[m].spec.name);
  return key_of({{"study", study},
                 {"rig", plan.rig},
                 {"joints", plan.names},
                 {"external", external},
                 {"cross_check", cross_check},
                 {"compares_absolute_positions", compares_absolute_positions(plan.study)},
                 {"take", json_of(plan.takes[take].take, inputs)}});
}

}  // namespace trilat
