// SPDX-License-Identifier: MIT
#include "pipeline/cli/built_in.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "pipeline/cli/embedded_campaigns.h"
#include "pipeline/cli/embedded_studies.h"

namespace trilat {
namespace {

template <class List>
Json document(const List& list, const std::string& name, const std::string& scale) {
  const auto found = std::ranges::find_if(list, [&](const auto& entry) { return entry.name == name; });
  TRILAT_CHECK(found != std::end(list), "a document that is built in has a name that is known");
  Json json = parse_json(found->text, "pipeline/studies/" + name + ".json");
  const Json scales = json.value("scales", Json::object());
  json.erase("scales");
  if (scales.contains(scale)) json.merge_patch(scales[scale]);
  return json;
}

}  // namespace

Json built_in_study(const std::string& name, const std::string& scale) {
  return document(embedded::studies, name, scale);
}
Json built_in_campaign(const std::string& name, const std::string& scale) {
  return document(embedded::campaigns, name, scale);
}

std::vector<std::string> built_in_studies() {
  std::vector<std::string> names;
  for (const auto& study : embedded::studies) names.emplace_back(study.name);
  return names;
}

}  // namespace trilat
