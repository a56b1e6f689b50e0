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

// A folder whose manifest and summary are of different runs.
void refuse_mixed(const FoundResults& found, const Json& study) {
  const auto same = [&](const char* key, const Json& of_manifest, const std::string& wanted) {
    if (of_manifest.is_string() && of_manifest.get<std::string>() != wanted)
      throw InputError((found.folder / "manifest.json").string() + " " + key,
                       fmt::format("is \"{}\", and that of summary.json beside it \"{}\": the folder holds "
                                   "parts of two runs; run the study again",
                                   of_manifest.get<std::string>(), wanted));
  };
  const bool budget = found.kind == StudyKind::error_budget;
  same("/study/kind", study.value("kind", Json()), name_of(budget ? StudyKind::accuracy : found.kind));
  const std::string name = text_of(found.summary, "study"), campaign = text_of(found.summary, "campaign");
  if (!name.empty()) same("/study/name", study.value("name", Json()), name);
  if (!campaign.empty()) same("/campaign", found.manifest.value("campaign", Json()), campaign);
}

FoundResults read_found(const fs::path& folder, const std::string& name) {
  FoundResults found;
  found.folder = folder;
  found.kind = results_kind(folder);
  found.summary = read_results_json(folder);
  found.manifest = read_json(folder / "manifest.json");
  const fs::path manifest = folder / "manifest.json";
  if (!found.manifest.is_object() || found.manifest.value("format", Json()) != "trilat.manifest" ||
      found.manifest.value("version", Json()) != 1)
    throw InputError(manifest.string(),
                     "is no manifest of this program's version (trilat.manifest, version 1)");
  const Json study = found.manifest.value("study", Json::object());
  if (!study.is_object() || !study.contains("name") || !study["name"].is_string())
    throw InputError(manifest.string() + " /study/name", "is missing");
  found.study = study["name"].get<std::string>();
  found.name = name.empty() ? found.study : name;
  refuse_mixed(found, study);
  if (found.summary.value("interrupted", Json(false)) == true)
    throw InputError((folder / "summary.json").string() + " /interrupted",
                     "is true: the run was not finished. Run it again");
  if (found.kind == StudyKind::accuracy) {
    if (!fs::exists(folder / "samples.h5"))
      throw InputError((folder / "samples.h5").string(), "is missing: results are compared sample by sample");
    if (found.summary.value("cells", Json::array()).empty())
      throw InputError((folder / "summary.json").string() + " /cells", "is empty: nothing was evaluated");
  }
  return found;
}

void refuse_unfinished(const fs::path& partial) {
  throw InputError(partial.string(), "is what an unfinished run left. Run it again, or remove it");
}

constexpr std::size_t kMostTold = 5;

std::string escaped(const std::string& key) {
  std::string text;
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

// The place itself, or the beginning of the character that it is inside of.
std::size_t character_at(const std::string& utf8, std::size_t place) {
  while (place > 0 && place < utf8.size() && (static_cast<unsigned char>(utf8[place]) & 0xC0U) == 0x80U)
    --place;
  return std::min(place, utf8.size());
}

// Long text around `place`.
std::string shortened(const std::string& text, std::size_t place = 0) {
  constexpr std::size_t kMost = 80, kBefore = 20;
  if (text.size() <= kMost) return text;
  const std::size_t first = character_at(text, place > kMost - kBefore ? place - kBefore : 0);
  const std::size_t end = character_at(text, first + kMost);
  return (first > 0 ? "…" : "") + text.substr(first, end - first) + (end < text.size() ? "…" : "");
}

std::string shortened(const Json& value) { return shortened(json_text(value, -1)); }

void compare(const Json& now, const Json& before, const std::string& pointer,
             std::vector<JsonDifference>& differences) {
  if (now == before) return;
  if (now.is_object() && before.is_object()) {
    for (const auto& [key, value] : now.items()) {
      const std::string place = pointer + "/" + escaped(key);
      if (before.contains(key))
        compare(value, before.at(key), place, differences);
      else
        differences.push_back({place, shortened(value), "nothing"});
    }
    for (const auto& [key, value] : before.items())
      if (!now.contains(key))
        differences.push_back({pointer + "/" + escaped(key), "nothing", shortened(value)});
    return;
  }
  if (now.is_array() && before.is_array() && now.size() == before.size()) {
    for (std::size_t i = 0; i < now.size(); ++i)
      compare(now[i], before[i], fmt::format("{}/{}", pointer, i), differences);
    return;
  }
  const std::string here = json_text(now, -1), there = json_text(before, -1);
  const auto apart = std::mismatch(here.begin(), here.end(), there.begin(), there.end());
  const auto place = static_cast<std::size_t>(apart.first - here.begin());
  differences.push_back({pointer, shortened(here, place), shortened(there, place)});
}

std::string list_of(const std::vector<JsonDifference>& differences) {
  std::string text;
  for (std::size_t i = 0; i < std::min(differences.size(), kMostTold); ++i)
    text += fmt::format("{}{} is {} here and {} there", i == 0 ? "" : "; ", differences[i].pointer,
                        differences[i].now, differences[i].before);
  if (differences.size() > kMostTold) text += fmt::format("; and {} more", differences.size() - kMostTold);
  return text;
}

}  // namespace

ResultsSet find_results(const fs::path& given) {
  const fs::path folder = given.has_filename() ? given : given.parent_path();
  if (!fs::is_directory(folder))
    throw InputError(folder.string(), "is no folder; results, or a folder that holds several, are needed");
  if (folder.extension() == ".partial") refuse_unfinished(folder);
  ResultsSet set;
  if (is_results(folder)) {
    set.single = true;
    set.results.push_back(read_found(folder, ""));
    return set;
  }
  std::vector<fs::path> inside;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory()) inside.push_back(entry.path());
  std::sort(inside.begin(), inside.end());
  for (const fs::path& path : inside) {
    if (path.extension() == ".partial") refuse_unfinished(path);
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
    const auto there = std::find_if(before.results.begin(), before.results.end(),
                                    [&](const FoundResults& b) { return matches(here, b); });
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

std::vector<JsonDifference> json_differences(const Json& now, const Json& before) {
  std::vector<JsonDifference> differences;
  compare(now, before, "", differences);
  return differences;
}

Json configuration_of(const Json& manifest) {
  static const std::set<std::string> kOfTheCode{"program", "study_sha256", "inputs", "instants",
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
  auto differences =
      json_differences(configuration_of(pair.now.manifest), configuration_of(pair.before.manifest));
  if (!differences.empty())
    throw InputError(place,
                     fmt::format("is a baseline of another configuration than {}: {}. Compare like with "
                                 "like, or make tonight the baseline with --accept",
                                 pair.now.folder.string(), list_of(differences)));
  if (pair.now.manifest.value("simulated", Json(false)) == true) return;
  differences = json_differences({{"inputs", pair.now.manifest.value("inputs", Json::array())}},
                                 {{"inputs", pair.before.manifest.value("inputs", Json::array())}});
  if (!differences.empty())
    throw InputError(place, fmt::format("is a baseline of other recordings than {}: {}",
                                        pair.now.folder.string(), list_of(differences)));
}

}  // namespace trilat
