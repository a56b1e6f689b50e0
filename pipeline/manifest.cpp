// SPDX-License-Identifier: MIT
#include "pipeline/manifest.h"

#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"

namespace trilat {
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) {
      const auto colon = line.find(": ");
      return colon == std::string::npos ? "unknown" : line.substr(colon + 2);
    }
  return "unknown";
}

void write_manifest(const std::filesystem::path& folder, const Plan& plan,
                    std::span<const EvaluatedTake> evaluated) {
  const Json study = resolved_json(plan.study);
  Json methods = Json::array(), joints = Json::array(), list = Json::array(), takes = Json::array();
  for (const Method& method : plan.methods) methods.push_back(method.spec.name);
  for (Joint joint : plan.joints) joints.push_back(std::string(name_of(joint)));
  std::uint64_t instants = 0;
  for (const PlannedTake& take : plan.takes) instants += take.instants;
  for (const PlannedTake& planned : plan.takes)
    takes.push_back({{"id", planned.take.id},
                     {"participant", planned.take.participant},
                     {"activity", planned.take.activity},
                     {"mocap_start_host_ns", planned.take.mocap_start_host_ns},
                     {"instants", planned.instants}});
  for (std::size_t t = 0; t < plan.takes.size(); ++t)
    for (const TakeInput& input : evaluated[t].result.inputs)
      list.push_back({{"take", plan.takes[t].take.id},
                      {"role", input.role},
                      {"file", input.file},
                      {"bytes", input.bytes},
                      {"sha256", input.sha256.empty() ? Json() : Json(input.sha256)}});
  const Json json{{"format", "trilat.manifest"},
                  {"version", 1},
                  {"program", kProgramVersion},
                  {"study", study},
                  {"study_sha256", hash_of_text(study.dump())},
                  {"campaign", plan.campaign.name},
                  {"simulated", plan.simulated},
                  {"rig", plan.rig},
                  {"methods", methods},
                  {"joints", joints},
                  {"takes", takes},
                  {"instants", instants},
                  {"samples", instants * plan.joints.size() * plan.methods.size()},
                  {"inputs", list}};
  write_file(folder / "manifest.json", json_text(json, 1) + "\n");
}

void write_run_record(const std::filesystem::path& folder, const StageTimes& times, double wall_s,
                      int threads, const ItemTally* takes) {
  Json json{{"read_s", times.read_s},
            {"solve_s", times.solve_s},
            {"write_s", times.write_s},
            {"summarise_s", times.summarise_s}};
  if (takes) json.update(json_of(*takes));
  write_run_record(folder, json, wall_s, threads);
}

void write_run_record(const std::filesystem::path& folder, const Json& times, double wall_s, int threads) {
  Json json{{"format", "trilat.run"},
            {"version", 1},
            {"processor", processor_name()},
            {"processors", std::thread::hardware_concurrency()},
            {"threads", threads},
            {"compiler", __VERSION__},
            {"wall_s", wall_s}};
  json.update(times);
  write_file(folder / "run.json", json.dump(1) + "\n");
}

}  // namespace trilat
