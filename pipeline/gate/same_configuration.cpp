// SPDX-License-Identifier: MIT
#include "pipeline/gate/same_configuration.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"

namespace trilat {
namespace {

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
