// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/json_schema.h"
#include "datasets/take/campaign.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/methods/study_spec.h"
#include "pipeline/calibration_study/calibration_study.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/verbs.h"
#include "pipeline/clocks/clocks_study.h"
#include "pipeline/sweep/sweep_spec.h"

namespace trilat {
namespace {

struct SchemaArguments {
  std::string document;
  bool markdown = false;  // of all documents
};

using Text = const char*;

// An example with all that leads its reader to further keys.
Json study(Text kind, Text more) {
  Json json{{"format", "trilat.study"}, {"version", 1}, {"kind", kind}, {"name", kind}};
  json.update(Json::parse(more));
  return json;
}

Json with_methods(Json study, bool as_instants) {
  for (const MethodKind& kind : method_kinds()) {
    if (as_instants && kind.over_time) continue;
    Json method{{"method", kind.name}, {"name", kind.name}, {"each", std::max<std::size_t>(1, kind.sensors)}};
    if (!as_instants && kind.sensors != 1) method["occlusion"] = "corrected";
    study["methods"].push_back(method);
  }
  return study;
}

// A value of groups is one number or an object.
void add_trackers(std::vector<Json>& examples) {
  for (const char* group :
       {"bias_sigma_m", "view_bias_sigma_m", "own_bias_sigma_m", "wander_sigma_m", "view_wander_sigma_m",
        "own_wander_sigma_m", "jitter_sigma_m", "jump_rate_per_minute", "inferred_error_sigma_m"}) {
    examples[0]["body_tracker"][group] = 0.01;
    examples[1]["body_tracker"][group] = Json::object();
  }
}

Json simulation_schema() {
  const Json start{{"format", "trilat.simulation"}, {"version", 1}};
  std::vector<Json> examples(2, start);
  examples[0].update(
      Json::parse(R"({"stature_m": {}, "activities": [{"name": "walking", "marker_joints": ["head"]}],
      "rig": {"heights_m": [1], "centre_m": [0, 1, 0]}, "sensor": {},
      "mocap": {}, "room": {}, "depth": {"takes": true, "axial": {}}, "wand": {}, "bench": {"distances_m": [1, 2], "walls_m": [2]}})"));
  examples[1].update(Json::parse(R"({"recorded": {"mocap": "take.csv", "mapping": "mapping.json"}})"));
  add_trackers(examples);
  return schema_of(examples, [](const Json& json) { parse_simulation(json, "example", {}); });
}

Json campaign_schema() {
  return schema_of({Json::parse(R"({"format": "trilat.campaign", "version": 1, "name": "example",
      "wand": {"session": "w.h5", "mocap": "w.csv", "asset": "wand", "mocap_start_host_ns": 0},
      "stated_distances": [{"session": "b.h5", "places": "places.csv"}],
      "walls": [{"session": "f.h5", "distance_m": 2}], "takes": [
      {"id": "a", "participant": "p", "session": "s.h5", "calibration": "c.json", "mocap": "m.csv",
       "mapping": "mapping.json", "mocap_start_host_ns": 0,
       "joints": [{"method": "m", "file": "m.trc", "mapping": {"head": ["Head"]}}]}]})"),
                    Json::parse(R"({"format": "trilat.campaign", "version": 1, "name": "example", "takes": [
      {"id": "a", "participant": "p", "mocap": "m.csv", "mapping": "mapping.json",
       "joints": [{"method": "m", "file": "m.trc", "mapping": {"head": ["Head"]}}]}]})")},
                   [](const Json& json) { parse_campaign(json, "campaign.json"); });
}

Json mapping_schema() {
  Json example{{"format", "trilat.mapping"}, {"version", 1}};
  for (int j = 0; j < kJointCount; ++j)
    example["joints"][std::string(name_of(static_cast<Joint>(j)))] = {"an asset"};
  return schema_of({example}, [](const Json& json) { parse_mapping(json, "example"); });
}

Json calibration_document_schema() {
  Json example = Json::parse(R"({"format": "trilat.calibration", "version": 1, "method": "wand",
      "sensors": [{"name": "k1", "position_m": [0, 1, 2], "rotation_xyzw": [0, 0, 0, 1]}],
      "rejected": [{"sensor": "k1", "position": 0, "time_s": 0, "off_by_m": 0}],
      "reduced_chi2": 1, "sources": [{"file": "s.h5", "sha256": ""}]})");
  example["sensors"][0]["covariance"] = std::vector<double>(21, 0.0);
  return schema_of({example}, [](const Json& json) { parse_calibration(json, "example"); });
}

struct Document {
  std::string name;
  std::vector<std::pair<std::string, Json (*)()>> schemas;  // a study: of each kind
};

std::vector<Document> documents() {
  Document studies{"study", {}};
  for (const Kind& kind : kinds()) studies.schemas.emplace_back(name_of(kind.kind), kind.schema);
  return {studies,
          {"simulation", {{"", simulation_schema}}},
          {"campaign", {{"", campaign_schema}}},
          {"mapping", {{"", mapping_schema}}},
          {"calibration", {{"", calibration_document_schema}}}};
}

Json schema_of_document(const Document& document) {
  if (document.schemas.size() == 1) return document.schemas[0].second();
  Json schema, choices = Json::array();
  for (const auto& [kind, make] : document.schemas) {
    Json one = make();
    schema["$schema"] = one["$schema"];
    one.erase("$schema");
    choices.push_back(std::move(one));
  }
  schema["oneOf"] = choices;
  return schema;
}

std::string markdown_of_document(const Document& document, std::set<std::string>& told) {
  std::string text;
  for (const auto& [kind, make] : document.schemas)
    text += markdown_of_schema(
        make(), kind.empty() ? document.name + ".json" : fmt::format("Study of kind `{}`", kind), told);
  return text;
}

}  // namespace

Json accuracy_schema() {
  const Json example = with_methods(
      study("accuracy", R"({"alignments": ["mean"], "stages": [{"name": "a", "frames": "newest"}]})"), false);
  return schema_of({example}, [](const Json& json) { parse_study(json, "example", {}); });
}

Json sweep_schema() {
  return schema_of({study("threshold_sweep", R"({"rigs": [{"name": "circle", "heights_m": [1, 2, 1, 2]},
         {"name": "positions", "sensors_m": [[0, 1, 0], [2, 1, 0], [0, 1, 2]]}],
         "solver": {"threshold": 1, "error_cm": [0, 5]},
         "vary": {"joint": ["centre"], "error_model": ["gaussian"], "threshold_unit": ["cm2"], "gradient": ["printed"],
         "curvature": ["gauss_newton"], "stop": ["step"], "damping": ["none"], "start": ["linear"]}})"),
                    study("threshold_sweep", R"({"rigs": [{"name": "circle", "heights_m": [1, 2, 1, 2]}],
         "solver": {"joint": "centre"}, "vary": {"threshold": [1], "error_cm": [[0, 5]]}})")},
                   [](const Json& json) { parse_sweep(json, "example"); });
}

Json calibration_study_schema() {
  return schema_of({study("calibration", "{}")},
                   [](const Json& json) { parse_calibration_spec(json, "example", {}); });
}

Json clocks_schema() {
  return schema_of({study("clocks", "{}")}, [](const Json& json) { parse_clocks_spec(json, "example", {}); });
}

namespace {

int schema(const SchemaArguments& arguments) {
  const std::vector<Document> all = documents();
  if (arguments.markdown) {
    fmt::print(
        "# Keys of the documents that users write\n\n"
        "Made by `trilat schema --markdown`; `trilat schema study` gives the same as JSON Schema, whose "
        "place a document may name as its `$schema`.\n");
    std::set<std::string> told;
    for (const Document& document : all) fmt::print("{}", markdown_of_document(document, told));
    return kDone;
  }
  const auto found = std::ranges::find(all, arguments.document, &Document::name);
  if (found == all.end()) {
    std::vector<std::string> known;
    for (const Document& document : all) known.push_back(document.name);
    throw InputError("schema", fmt::format("knows no document \"{}\"; known are: {}", arguments.document,
                                           fmt::join(known, ", ")));
  }
  fmt::print("{}\n", json_text(schema_of_document(*found), 2));
  return kDone;
}

}  // namespace

void add_schema(CLI::App& app, int& code) {
  auto [verb, a] = add_verb<SchemaArguments>(
      app, code, "schema",
      "JSON Schema of a document that users write, for editors that complete and check it", schema,
      Ends::at_once);
  verb.add_option("document", a.document, "study, simulation, campaign, mapping or calibration");
  verb.add_flag("--markdown", a.markdown, "the keys of all documents as tables");
}

}  // namespace trilat
