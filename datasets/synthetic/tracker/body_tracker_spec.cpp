// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker_spec.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "datasets/synthetic/embedded_tracker.h"

namespace trilat {
namespace {

constexpr std::array<std::string_view, kTrackerGroups> kGroupNames{
    "trunk", "head", "shoulder", "elbow", "wrist", "hand", "hand_tip", "hip", "knee", "ankle", "foot"};

struct GroupsField {
  const char* key;
  BodyTrackerSpec::Groups BodyTrackerSpec::*member;
  double most;
};
constexpr GroupsField kGroupsFields[] = {
    {"bias_sigma_m", &BodyTrackerSpec::bias_sigma_m, 1.0},
    {"view_bias_sigma_m", &BodyTrackerSpec::view_bias_sigma_m, 1.0},
    {"own_bias_sigma_m", &BodyTrackerSpec::own_bias_sigma_m, 1.0},
    {"wander_sigma_m", &BodyTrackerSpec::wander_sigma_m, 1.0},
    {"view_wander_sigma_m", &BodyTrackerSpec::view_wander_sigma_m, 1.0},
    {"own_wander_sigma_m", &BodyTrackerSpec::own_wander_sigma_m, 1.0},
    {"jitter_sigma_m", &BodyTrackerSpec::jitter_sigma_m, 1.0},
    {"jump_rate_per_minute", &BodyTrackerSpec::jump_rate_per_minute, 60.0},
    {"inferred_error_sigma_m", &BodyTrackerSpec::inferred_error_sigma_m, 1.0},
};

struct ValueField {
  const char* key;
  double BodyTrackerSpec::*member;
  double most;
  double least = 0.0;
};
constexpr ValueField kValueFields[] = {
    {"wander_path_m", &BodyTrackerSpec::wander_path_m, 100.0},
    {"ray_ratio", &BodyTrackerSpec::ray_ratio, 100.0, 0.01},
    {"unit_depth_share", &BodyTrackerSpec::unit_depth_share, 1.0},
    {"lag_s", &BodyTrackerSpec::lag_s, 10.0},
    {"jump_size_m", &BodyTrackerSpec::jump_size_m, 1.0},
    {"jump_duration_s", &BodyTrackerSpec::jump_duration_s, 60.0},
    {"least_visible_share", &BodyTrackerSpec::least_visible_share, 1.0},
    {"hidden_as_tracked_share", &BodyTrackerSpec::hidden_as_tracked_share, 1.0},
    {"back_view_angle_rad", &BodyTrackerSpec::back_view_angle_rad, std::numbers::pi},
    {"exchanged_share", &BodyTrackerSpec::exchanged_share, 1.0},
};

constexpr const char* kFormat = "trilat.body_tracker";

struct Declared {
  BodyTrackerSpec spec;
  // In the order of the fields, those of groups first; an interval as text, empty where there is none.
  std::vector<std::string> units, sources, intervals;
};

std::string interval_text(JsonObject& entry, const std::string& key) {
  const std::vector<double> ends = entry.numbers(key, 2);
  return fmt::format("{:g} to {:g}", ends[0], ends[1]);
}

Declared read_document(JsonObject object) {
  object.format(kFormat);
  Declared declared;
  const auto describe = [&](JsonObject& entry) {
    declared.units.push_back(entry.text("unit"));
    declared.sources.push_back(entry.text("source"));
    if (declared.sources.back().empty()) entry.refuse("source", "must not be empty");
    entry.finish();
  };
  JsonObject groups = object.object("groups");
  for (const GroupsField& field : kGroupsFields) {
    JsonObject entry = groups.object(field.key);
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      (declared.spec.*field.member)[g] =
          number_within(entry, std::string(kGroupNames[g]), {}, 0.0, field.most);
    std::string& text = declared.intervals.emplace_back();
    if (entry.has("interval")) {
      JsonObject intervals = entry.object("interval");
      for (const std::string_view name : kGroupNames)
        if (const std::string group(name); intervals.has(group))
          text += fmt::format("{}{} {}", text.empty() ? "" : ", ", group, interval_text(intervals, group));
      intervals.finish();
    }
    describe(entry);
  }
  groups.finish();
  JsonObject values = object.object("values");
  for (const ValueField& field : kValueFields) {
    JsonObject entry = values.object(field.key);
    declared.spec.*field.member = number_within(entry, "value", {}, field.least, field.most);
    declared.intervals.push_back(entry.has("interval") ? interval_text(entry, "interval") : "");
    describe(entry);
  }
  values.finish();
  object.finish();
  return declared;
}

const Declared& declared() {
  static const Declared value = [] {
    const Json json = declared_body_tracker();
    return read_document(JsonObject(json, "datasets/synthetic/body_tracker.json", ""));
  }();
  return value;
}

}  // namespace

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

BodyTrackerSpec read_body_tracker(JsonObject& parent) {
  constexpr const char* kKey = "body_tracker";
  const bool is_document = parent.value(kKey).is_object() && parent.value(kKey).contains("format");
  JsonObject object = parent.object(kKey);
  if (is_document) return read_document(std::move(object)).spec;
  BodyTrackerSpec spec = default_body_tracker();
  for (const GroupsField& field : kGroupsFields) {
    if (!object.has(field.key)) continue;
    BodyTrackerSpec::Groups& groups = spec.*field.member;
    if (!object.value(field.key).is_object()) {
      groups.fill(number_within(object, field.key, {}, 0.0, field.most));
      continue;
    }
    JsonObject some = object.object(field.key);
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      groups[g] = number_within(some, std::string(kGroupNames[g]), groups[g], 0.0, field.most);
    some.finish();
  }
  for (const ValueField& field : kValueFields)
    spec.*field.member = number_within(object, field.key, spec.*field.member, field.least, field.most);
  for (const DeclaredParameter& parameter : tracker_parameters(default_body_tracker()))
    object.about({{parameter.name.c_str(), (parameter.unit + "; " + parameter.source).c_str()}});
  object.finish();
  return spec;
}

std::vector<DeclaredParameter> tracker_parameters(const BodyTrackerSpec& spec) {
  const Declared& known = declared();
  std::vector<DeclaredParameter> list;
  const auto add = [&](const char* key, const std::string& value, bool same) {
    const std::size_t i = list.size();
    list.push_back({key, value, known.units[i],
                    same ? (known.intervals[i].empty() ? "" : "95 % interval " + known.intervals[i] + "; ") +
                               known.sources[i]
                         : kSetInTheSimulation});
  };
  for (const GroupsField& field : kGroupsFields) {
    const BodyTrackerSpec::Groups& groups = spec.*field.member;
    std::string text;
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      text += fmt::format("{}{} {}", g > 0 ? ", " : "", kGroupNames[g], groups[g]);
    add(field.key, text, groups == known.spec.*field.member);
  }
  for (const ValueField& field : kValueFields)
    add(field.key, fmt::format("{}", spec.*field.member), spec.*field.member == known.spec.*field.member);
  return list;
}

}  // namespace trilat
