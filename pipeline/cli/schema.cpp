// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/document.h"
#include "datasets/base/error.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "datasets/synthetic/simulation_spec.h"
#include "pipeline/cli/kinds.h"
#include "pipeline/cli/verbs.h"

namespace trilat {
namespace {

struct SchemaArguments {
  std::string document;
  bool markdown = false;  // of all documents
};

struct Document {
  std::string name;
  std::vector<std::pair<std::string, Json (*)()>> schemas;  // a study: of each kind
};

std::vector<Document> documents() {
  Document studies{"study", {}};
  for (const Kind& kind : kinds()) studies.schemas.emplace_back(name_of(kind.kind), kind.schema);
  return {studies,
          {"simulation", {{"", simulation_schema}}},
          {"campaign", {{"", schema_of<Campaign>}}},
          {"mapping", {{"", schema_of<JointMapping>}}},
          {"calibration", {{"", schema_of<Calibration>}}}};
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

std::string markdown_of_document(const Document& document, std::set<std::string>& reported) {
  std::string text;
  for (const auto& [kind, make] : document.schemas)
    text += markdown_of_schema(
        make(), kind.empty() ? document.name + ".json" : fmt::format("Study of kind `{}`", kind), reported);
  return text;
}

int schema(const SchemaArguments& arguments) {
  const std::vector<Document> all = documents();
  if (arguments.markdown) {
    fmt::print(
        "# Keys of the documents that users write\n\n"
        "Made by `trilat schema --markdown`; `trilat schema study` gives the same as JSON Schema, whose "
        "place a document may name as its `$schema`.\n");
    std::set<std::string> reported;
    for (const Document& document : all) fmt::print("{}", markdown_of_document(document, reported));
    return kDone;
  }
  const auto found = std::ranges::find(all, arguments.document, &Document::name);
  if (found == all.end()) {
    std::vector<std::string> known;
    for (const Document& document : all) known.push_back(document.name);
    throw InputError("schema", fmt::format("knows no document \"{}\"; allowed: {}", arguments.document,
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
      OnInterrupt::at_once);
  verb.add_option("document", a.document, "study, simulation, campaign, mapping or calibration");
  verb.add_flag("--markdown", a.markdown, "the keys of all documents as tables");
}

}  // namespace trilat
