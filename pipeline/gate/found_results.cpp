// SPDX-License-Identifier: MIT
#include "pipeline/gate/found_results.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"

namespace trilat {
namespace {

namespace fs = std::filesystem;

bool is_results(const fs::path& folder) {
  return fs::exists(folder / "summary.json") || fs::exists(folder / "manifest.json");
}

std::string text_of(const Json& object, const char* key) {
  const Json value = object.value(key, Json());
  return value.is_string() ? value.get<std::string>() : "";
}

FoundResults read_found(const fs::path& folder, const std::string& name) {
  FoundResults found;
  found.folder = folder;
  found.kind = results_kind(folder);
  found.summary = read_results_json(folder);
  found.manifest = read_json(folder / "manifest.json");
  JsonObject manifest(found.manifest, (folder / "manifest.json").string(), "");
  check_format(manifest, "trilat.manifest", 2);
  found.study = manifest.object("study").text("name");
  found.name = name.empty() ? found.study : name;
  check_same_run(manifest, found.kind, text_of(found.summary, "study"), text_of(found.summary, "campaign"));
  if (found.kind == StudyKind::accuracy && found.summary.value("cells", Json::array()).empty())
    throw InputError((folder / "summary.json").string() + " /cells", "is empty: nothing was evaluated");
  return found;
}

// "/seed is 2 here and 1 there; …"; empty when the documents are equal.
std::string differences_of(const Json& now, const Json& before) {
  constexpr std::size_t kMostTold = 5;
  const Json steps = Json::diff(before, now);
  std::string text;
  for (std::size_t i = 0; i < std::min(steps.size(), kMostTold); ++i) {
    const Json::json_pointer place(steps[i].at("path").get<std::string>());
    const auto value = [&](const Json& document) {
      return document.contains(place) ? shortened(document.at(place)) : "nothing";
    };
    text += fmt::format("{}{} is {} here and {} there", i == 0 ? "" : "; ", place.to_string(), value(now),
                        value(before));
  }
  if (steps.size() > kMostTold) text += fmt::format("; and {} more", steps.size() - kMostTold);
  return text;
}

}  // namespace

std::string shortened(const Json& value) {
  constexpr std::size_t kMost = 80;
  if (value.is_null()) return "nothing";
  if (!value.is_structured()) return json_text(value, -1);
  const std::string ascii = value.dump(-1, ' ', true);
  return ascii.size() <= kMost ? ascii : ascii.substr(0, kMost) + "…";
}

ResultsSet find_results(const fs::path& given) {
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "is no folder; results, or a folder that holds several, are needed");
  ResultsSet set;
  if (is_results(folder)) {
    set.single = true;
    set.results.push_back(read_found(folder, ""));
    return set;
  }
  std::vector<fs::path> inside;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) inside.push_back(entry.path());
  std::ranges::sort(inside);
  for (const fs::path& path : inside) {
    if (is_results(path)) set.results.push_back(read_found(path, path.filename().string()));
  }
  if (set.results.empty())
    throw InputError(folder.string(), "holds no results: neither a summary.json nor folders with one");
  return set;
}

PairedSet pair_results(ResultsSet now, ResultsSet before) {
  const bool by_study = now.single || before.single;
  const auto matches = [&](const FoundResults& a, const FoundResults& b) {
    return by_study ? a.study == b.study : a.name == b.name;
  };
  PairedSet set;
  if (now.single &&
      before.single) {  // whatever their names: a difference is then told as one of configuration
    set.pairs.push_back({std::move(now.results[0]), std::move(before.results[0])});
    return set;
  }
  for (FoundResults& here : now.results) {
    const auto there =
        std::ranges::find_if(before.results, [&](const FoundResults& b) { return matches(here, b); });
    if (there == before.results.end()) {
      set.only_now.push_back(here.name);
      continue;
    }
    set.pairs.push_back({std::move(here), std::move(*there)});
    before.results.erase(there);
  }
  for (const FoundResults& there : before.results) set.only_before.push_back(there.name);
  return set;
}

Json configuration_of(const Json& manifest) {
  static const std::set<std::string> kOfTheCode{"program", "study_sha256", "simulator_sha256",
                                                "inputs",  "items",        "instants",
                                                "samples", "cells",        "skipped"};
  Json configuration = Json::object();
  for (const auto& [key, value] : manifest.items())
    if (!kOfTheCode.contains(key)) configuration[key] = value;
  if (configuration.contains("takes") && configuration["takes"].is_array())
    for (Json& take : configuration["takes"])
      if (take.is_object()) take.erase("instants");
  return configuration;
}

bool same_inputs(const Json& now, const Json& before) {
  return now.value("inputs", Json::array()) == before.value("inputs", Json::array());
}

void check_same_configuration(const ResultsPair& pair) {
  const std::string place = (pair.before.folder / "manifest.json").string();
  if (pair.now.kind != pair.before.kind)
    throw InputError(place, fmt::format("is of kind {}, and {} of kind {}", name_of(pair.before.kind),
                                        pair.now.folder.string(), name_of(pair.now.kind)));
  std::string differences =
      differences_of(configuration_of(pair.now.manifest), configuration_of(pair.before.manifest));
  if (!differences.empty())
    throw InputError(place, fmt::format("is a baseline of another configuration than {}: {}. Compare like "
                                        "with like, or make tonight the baseline with --accept",
                                        pair.now.folder.string(), differences));
  if (pair.now.manifest.value("simulated", Json(false)) == true) return;
  differences = differences_of({{"inputs", pair.now.manifest.value("inputs", Json::array())}},
                               {{"inputs", pair.before.manifest.value("inputs", Json::array())}});
  if (!differences.empty())
    throw InputError(place, fmt::format("is a baseline of other recordings than {}: {}",
                                        pair.now.folder.string(), differences));
}

}  // namespace trilat
