// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker_spec.h"

#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/synthetic/embedded_tracker.h"

namespace trilat {
namespace {

constexpr std::array<const char*, kTrackerGroups> kGroupNames{
    "trunk", "head", "shoulder", "elbow", "wrist", "hand", "hand_tip", "hip", "knee", "ankle", "foot"};

std::string value_text(double value) { return fmt::format("{}", value); }
std::string value_text(const BodyTrackerSpec::Groups& groups) {
  std::string text;
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    text += fmt::format("{}{} {}", g > 0 ? ", " : "", kGroupNames[g], groups[g]);
  return text;
}

std::vector<std::string> keys_of(const auto& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

// Keys of version 0.4.0.
constexpr std::pair<const char*, const char*> kRenamed[] = {{"wander_sigma_m", "drift_sigma_m"},
                                                            {"view_wander_sigma_m", "view_drift_sigma_m"},
                                                            {"own_wander_sigma_m", "own_drift_sigma_m"},
                                                            {"wander_path_m", "drift_path_m"}};

using Interval = std::optional<std::array<double, 2>>;

// A parameter of a document that declares them all.
struct DeclaredValue {
  double value = 0.0;
  std::string unit, source;
  Interval interval;

  static void fields(auto& self, auto&& f) {
    f("unit", self.unit, "value", self.value, "interval", self.interval, "source", self.source);
  }
};
struct DeclaredGroups {
  BodyTrackerSpec::Groups value{};
  std::string unit, source;
  std::map<std::string, std::array<double, 2>> interval;

  static void fields(auto& self, auto&& f) {
    f("unit", self.unit, "source", self.source);
    for (std::size_t g = 0; g < kTrackerGroups; ++g) f(kGroupNames[g], self.value[g]);
    f("interval", self.interval, kMayLack);
  }
};
struct TrackerDocument {
  std::map<std::string, DeclaredGroups> groups;
  std::map<std::string, DeclaredValue> values;

  static void fields(auto& self, auto&& f) {
    f.format("trilat.body_tracker");
    f("groups", self.groups, "values", self.values);
  }
};

void check_limits(const JsonPlace& place, double value, const Range& range) {
  json_value::read_value(Json(value), place, need("number", range), value);
}

struct Declared {
  BodyTrackerSpec spec;
  // Texts by parameter; an interval is empty where the source states none.
  std::map<std::string, std::string> units, sources, intervals;
};

// Visits the parameters and takes each from the document, which must have all of them and no other.
struct Taken {
  const TrackerDocument& document;
  JsonPlace place;
  Declared& declared;

  void operator()(const char* key, BodyTrackerSpec::Groups& into, const Range& range) const {
    const DeclaredGroups& entry = find(document.groups, "groups", key);
    into = entry.value;
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      check_limits(place.at("groups").at(key).at(kGroupNames[g]), into[g], range);
    std::string text;
    for (const char* group : kGroupNames)
      if (const auto ends = entry.interval.find(group); ends != entry.interval.end())
        text += fmt::format("{}{} {:g} to {:g}", text.empty() ? "" : ", ", group, ends->second[0],
                            ends->second[1]);
    describe(key, entry, text);
  }
  void operator()(const char* key, double& into, const Range& range) const {
    const DeclaredValue& entry = find(document.values, "values", key);
    into = entry.value;
    check_limits(place.at("values").at(key).at("value"), into, range);
    describe(key, entry,
             entry.interval ? fmt::format("{:g} to {:g}", entry.interval->at(0), entry.interval->at(1)) : "");
  }

 private:
  template <class Entry>
  const Entry& find(const std::map<std::string, Entry>& entries, const char* part, const char* key) const {
    const auto found = entries.find(key);
    for (const auto& [old, now] : kRenamed)
      if (entries.contains(old)) place.at(part).at(old).refuse(fmt::format("is called \"{}\" now", now));
    if (found == entries.end()) place.at(part).at(key).refuse("is missing");
    if (found->second.source.empty()) place.at(part).at(key).at("source").refuse("must not be empty");
    return found->second;
  }
  void describe(const char* key, const auto& entry, const std::string& interval) const {
    declared.units[key] = entry.unit;
    declared.sources[key] = entry.source;
    declared.intervals[key] = interval;
  }
};

Declared take_document(const Json& json, const JsonPlace& place) {
  const auto document = read_as<TrackerDocument>(json, place);
  Declared declared;
  BodyTrackerSpec::fields(declared.spec, Taken{document, place, declared});
  for (const auto& [part, keys] :
       {std::pair("groups", keys_of(document.groups)), std::pair("values", keys_of(document.values))})
    for (const std::string& key : keys)
      if (!declared.units.contains(key)) place.at(part).at(key).refuse("is an unknown key");
  return declared;
}

const Declared& declared() {
  static const Declared value =
      take_document(declared_body_tracker(), {"datasets/synthetic/body_tracker.json"});
  return value;
}

// Visits the parameters as settings, each with what it is and rests on.
struct AsSettings {
  Fields& f;
  void operator()(const char* key, auto& member, const Range& range) const {
    f(key, member, opt(declared().units.at(key) + "; " + declared().sources.at(key), range));
  }
};
struct SomeValues {
  BodyTrackerSpec& spec;
  static void fields(auto& self, Fields& f) {
    for (const auto& [old, now] : kRenamed) f.renamed(old, now);
    BodyTrackerSpec::fields(self.spec, AsSettings{f});
  }
};

}  // namespace

void BodyTrackerSpec::Groups::read(const Json& json, const JsonPlace& place, const About& about) {
  if (!json.is_object()) {
    double of_all = 0.0;
    json_value::read_value(json, place, about, of_all);
    fill(of_all);
    return;
  }
  for (const auto& [name, value] : json.items()) {
    const std::size_t group =
        json_value::read_word(name, place.at(name), {kGroupNames.begin(), kGroupNames.end()});
    json_value::read_value(value, place.at(name), about, at(group));
  }
}

Json BodyTrackerSpec::Groups::schema(const About& about) {
  Json schema = json_value::schema(0.0, about);
  schema["properties"] = Json::object();
  for (const char* name : kGroupNames) schema["properties"][name] = json_value::schema(0.0, about);
  schema["required"] = Json::array();
  schema["additionalProperties"] = false;
  schema["type"] = {"number", "object"};
  return schema;
}

void BodyTrackerSpec::read(const Json& json, const JsonPlace& place, const About& about) {
  if (json.is_string()) {
    std::filesystem::path named;
    json_value::read_value(json, place, about, named);
    read(read_json(named), named, about);
    file = named;
  } else if (json.is_object() && json.contains("format")) {
    *this = take_document(json, place).spec;
  } else {
    *this = default_body_tracker();
    SomeValues values{*this};
    read_document(json, place, values);
  }
}

Json BodyTrackerSpec::schema(const About&) {
  BodyTrackerSpec usual = default_body_tracker();
  Json schema = json_value::struct_schema(SomeValues{usual});
  schema["type"] = {"object", "string"};
  return schema;
}

TrackerGroup tracker_group_of(Joint joint) {
  switch (joint) {
    case Joint::head:
      return TrackerGroup::head;
    case Joint::shoulder_left:
    case Joint::shoulder_right:
      return TrackerGroup::shoulder;
    case Joint::elbow_left:
    case Joint::elbow_right:
      return TrackerGroup::elbow;
    case Joint::wrist_left:
    case Joint::wrist_right:
      return TrackerGroup::wrist;
    case Joint::hand_left:
    case Joint::hand_right:
      return TrackerGroup::hand;
    case Joint::hand_tip_left:
    case Joint::hand_tip_right:
    case Joint::thumb_left:
    case Joint::thumb_right:
      return TrackerGroup::hand_tip;
    case Joint::hip_left:
    case Joint::hip_right:
      return TrackerGroup::hip;
    case Joint::knee_left:
    case Joint::knee_right:
      return TrackerGroup::knee;
    case Joint::ankle_left:
    case Joint::ankle_right:
      return TrackerGroup::ankle;
    case Joint::foot_left:
    case Joint::foot_right:
      return TrackerGroup::foot;
    case Joint::spine_base:
    case Joint::spine_mid:
    case Joint::spine_shoulder:
    case Joint::neck:
      return TrackerGroup::trunk;
  }
  TRILAT_CHECK(false, "every joint has a group");
}

std::string_view name_of(TrackerGroup group) { return kGroupNames[static_cast<std::size_t>(group)]; }

BodyTrackerSpec exact_body_tracker() { return {}; }

Json declared_body_tracker() {
  return parse_json(embedded::body_tracker_json, "datasets/synthetic/body_tracker.json");
}

const BodyTrackerSpec& default_body_tracker() { return declared().spec; }

std::vector<SimulationAssumption> tracker_parameters(const BodyTrackerSpec& spec) {
  const Declared& known = declared();
  std::map<std::string, std::string> usual;
  std::vector<SimulationAssumption> list;
  BodyTrackerSpec::fields(
      known.spec, [&](const char* key, const auto& value, const Range&) { usual[key] = value_text(value); });
  BodyTrackerSpec::fields(spec, [&](const char* key, const auto& value, const Range&) {
    const std::string& interval = known.intervals.at(key);
    list.push_back(
        {key, value_text(value), known.units.at(key),
         value_text(value) != usual[key]
             ? kSetInTheSimulation
             : (interval.empty() ? "" : "95 % interval " + interval + "; ") + known.sources.at(key)});
  });
  return list;
}

}  // namespace trilat
