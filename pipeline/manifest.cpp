// SPDX-License-Identifier: MIT
#include "pipeline/manifest.h"

#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/parallel.h"

namespace trilat {
namespace {

struct Input {
  std::string take;
  const char* role;
  std::filesystem::path path;
  std::string sha256;  // empty when it could not be read
  std::uintmax_t bytes = 0;
};

std::vector<Input> inputs_of(const Plan& plan) {
  std::vector<Input> inputs;
  for (const PlannedTake& planned : plan.takes) {
    const Take& take = planned.take;
    inputs.push_back({take.id, "session", take.session, {}, 0});
    inputs.push_back({take.id, "calibration", take.calibration, {}, 0});
    inputs.push_back({take.id, "mocap", take.mocap, {}, 0});
    inputs.push_back({take.id, "mapping", take.mapping, {}, 0});
    if (!take.tracker_truth.empty()) inputs.push_back({take.id, "tracker_truth", take.tracker_truth, {}, 0});
  }
  return inputs;
}

void hash_input(Input& input, const std::function<bool()>& stop_requested) {
  try {
    input.sha256 = hash_of_file(input.path, stop_requested);
    input.bytes = std::filesystem::file_size(input.path);
  } catch (const InputError&) {
  } catch (const std::filesystem::filesystem_error&) {
  }
}

}  // namespace

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
                    const std::function<bool()>& stop_requested) {
  std::vector<Input> inputs = inputs_of(plan);
  parallel_for_index(inputs.size(), 1, [&](std::size_t i) {
    if (!stop_requested || !stop_requested()) hash_input(inputs[i], stop_requested);
  });
  if (stop_requested && stop_requested()) throw Interrupted();
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
  for (const Input& input : inputs)
    list.push_back({{"take", input.take},
                    {"role", input.role},
                    {"file", input.path.filename().string()},
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
                      int threads) {
  write_run_record(folder,
                   {{"read_s", times.read_s},
                    {"solve_s", times.solve_s},
                    {"write_s", times.write_s},
                    {"summarise_s", times.summarise_s}},
                   wall_s, threads);
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
