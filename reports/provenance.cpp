// SPDX-License-Identifier: MIT
#include "reports/provenance.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/results/table.h"

namespace trilat {
namespace {

std::string scalar_text(const Json& json, const std::string& key) {
  const auto found = json.find(key);
  if (found == json.end() || found->is_null()) return {};
  if (found->is_string()) return found->get<std::string>();
  return found->is_number_float() ? fmt::format("{:.1f}", found->get<double>()) : found->dump();
}

void read_manifest_into(const std::filesystem::path& results, const std::string& campaign, Provenance& p) {
  const Manifest manifest = read_manifest(results);
  check_same_run(manifest, name_of(p.kind), p.study, campaign);
  p.program = manifest.program;
  p.campaign = campaign;
  p.config = json_text(manifest.settings, 1);
  p.seed = scalar_text(manifest.settings, "seed");
  p.study_sha256 = manifest.study_sha256;
  p.calibration = manifest.calibration;
  p.rig = manifest.rig;
  p.inputs = manifest.inputs;
}

// Keys of run.json about the machine and the run.
struct RunRecord {
  static constexpr bool kHasMore = true;
  Provenance& p;
  std::string verb = {};

  static void fields(auto& self, auto&& f) {
    f.format("trilat.run");
    f("processor", self.p.processor);
    f("compiler", self.p.compiler, kMayLack);
    f("verb", self.verb, kMayLack);
  }
};

void read_run_record(const std::filesystem::path& path, Provenance& p) {
  RunRecord run{p};
  const Json json = read_json(path);
  read_document(json, {path}, run);
  p.threads = scalar_text(json, "threads");
  p.wall_s = scalar_text(json, "wall_s");
  p.is_compared = run.verb == "compare";
}

}  // namespace

std::filesystem::path whole_path(const std::filesystem::path& folder) {
  const std::filesystem::path whole = std::filesystem::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

std::string folder_name(const std::filesystem::path& folder) {
  return whole_path(folder).filename().string();
}

Provenance read_provenance(const std::filesystem::path& results, StudyKind kind, const std::string& study,
                           const std::string& campaign) {
  Provenance provenance;
  provenance.folder = folder_name(results);
  provenance.kind = kind;
  provenance.study = study;
  provenance.campaign = campaign;
  if (const auto path = results / "manifest.json"; std::filesystem::exists(path))
    read_manifest_into(results, campaign, provenance);
  if (const auto path = results / "run.json"; std::filesystem::exists(path))
    read_run_record(path, provenance);
  return provenance;
}

std::string study_file(const Provenance& provenance) {
  return "studies/" + file_name_from(provenance.folder) + ".json";
}

std::string commands_of(const Provenance& p) {
  const bool wants_campaign = p.kind == StudyKind::accuracy;
  const std::string folder = file_name_from(p.folder);
  if (p.is_compared) {
    std::string files, mapping;
    for (const Manifest::Input& input : p.inputs)
      (input.role == "mapping" ? mapping : files) +=
          (input.role == "mapping" ? " --mapping " : " ") + input.file;
    return fmt::format("trilat compare{}{} -o {}\ntrilat report {} -o report", files, mapping, folder,
                       folder);
  }
  return fmt::format("trilat run {}{}{} -o {}\ntrilat report {} -o report", study_file(p),
                     wants_campaign ? " --campaign CAMPAIGN" : "",
                     p.calibration.empty() ? "" : " --calibration " + p.calibration, folder, folder);
}

Table parameters_table(const std::vector<SimulationAssumption>& parameters, const std::string& studies) {
  using R = SimulationAssumption;
  Table table = table_of<R>(
      "simulator", fmt::format("What the simulation behind {} assumes, with sources", studies), parameters,
      {{"parameter", "name", as_text(&R::name)},
       {"value", "value", as_text(&R::value)},
       {"unit", "unit", as_text(&R::unit)},
       {"source", "source", as_text(&R::source)}});
  const bool any_set = std::ranges::any_of(
      parameters, [](const SimulationAssumption& p) { return p.source == kSetInTheSimulation; });
  if (!any_set) add_notes(table, "parameters");
  return table;
}

}  // namespace trilat
