// SPDX-License-Identifier: MIT
#include "pipeline/sensitivity/sensitivity_spec.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "evaluators/metrics/sobol_indices.h"
#include "pipeline/accuracy/methods/method.h"

namespace trilat {
namespace {

constexpr std::uint64_t kFewestRows = 4;

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

SensitivityFactor read_factor(JsonObject& object, std::vector<Json>& values) {
  SensitivityFactor f;
  f.setting = object.text("setting");
  f.name = object.text("name", f.setting.substr(f.setting.rfind('/') + 1));
  f.unit = object.text("unit", "");
  if (f.setting.size() < 2 || f.setting[0] != '/')
    object.refuse("setting", "must be a path into simulation.json, as \"/rig/radius_m\"");
  if (object.has("values")) {
    const Json& list = object.value("values");
    if (!list.is_array() || list.size() < 2) object.refuse("values", "must be an array of at least 2 values");
    values.assign(list.begin(), list.end());
    for (const Json& value : values) f.values.push_back(text_of(value));
  } else {
    if (!object.has("low") || !object.has("high"))
      object.refuse("low", "and high are the ends of the range: give both, or a list of values");
    f.low = object.number("low", 0.0);
    f.high = object.number("high", 1.0);
    f.logarithmic = object.boolean("logarithmic", false);
    f.whole = object.boolean("whole", false);
    if (!(f.low < f.high)) object.refuse("high", "must be greater than low");
    if (f.logarithmic && !(f.low > 0.0))
      object.refuse("low", "must be greater than 0 on a logarithmic scale");
    if (f.whole &&
        (f.logarithmic || f.low != std::floor(f.low) || f.high != std::floor(f.high) || f.low < 0.0))
      object.refuse("whole", "needs whole ends of 0 or more and a linear scale");
  }
  object.shape("values", R"({"type": "array", "minItems": 2})");
  object.about({{"setting", "what is varied: a path into simulation.json"},
                {"name", "in tables; without it the last part of the path"},
                {"unit", "of the numbers, for tables"},
                {"values", "a list that is chosen from, instead of low and high"},
                {"low", "end of the range"},
                {"high", "other end"},
                {"logarithmic", "equal ratios are equally likely, not equal differences"},
                {"whole", "whole numbers only"}});
  object.finish();
  return f;
}

void check_method(JsonObject& object, const std::string& key, const std::string& name,
                  const std::vector<std::string>& methods) {
  if (std::ranges::find(methods, name) == methods.end())
    object.refuse(key, fmt::format("has \"{}\", which is none of the methods: \"{}\"", name,
                                   fmt::join(methods, "\", \"")));
}

SensitivityClaim read_claim(JsonObject& object, const std::vector<std::string>& methods) {
  SensitivityClaim claim;
  claim.better = object.text("better");
  check_method(object, "better", claim.better, methods);
  claim.than = object.texts("than");
  if (claim.than.empty()) object.refuse("than", "must name at least one method");
  for (const std::string& name : claim.than) check_method(object, "than", name, methods);
  setting(object, "margin_percent", claim.margin_percent, {-100.0, 1000.0},
          "by which it may err more and the claim still holds");
  claim.name =
      object.text("name", fmt::format("{} errs less than {}", claim.better, fmt::join(claim.than, ", ")));
  object.about({{"name", "in tables"},
                {"better", "the method that is said to err less"},
                {"than", "than each of these"}});
  object.finish();
  return claim;
}

std::vector<std::string> names_of(const std::vector<SensitivityClaim>& claims) {
  std::vector<std::string> names;
  for (const SensitivityClaim& claim : claims) names.push_back(claim.name);
  return names;
}

std::string read_factor_name(JsonObject& object, const std::string& key, const SensitivitySummary& head) {
  std::vector<std::string> factors;
  for (const SensitivityFactor& factor : head.factors) factors.push_back(factor.name);
  const std::string name = object.text(key);
  if (std::ranges::find(factors, name) == factors.end())
    object.refuse(key, fmt::format("is \"{}\", which is none of the factors: \"{}\"", name,
                                   fmt::join(factors, "\", \"")));
  return name;
}

SpacePart read_part(JsonObject& object, const SensitivitySummary& head) {
  SpacePart part;
  part.factor = read_factor_name(object, "factor", head);
  part.low = object.number("low");
  part.high = object.number("high");
  if (!(part.low < part.high)) object.refuse("high", "must be greater than low");
  part.name = object.text("name", fmt::format("{} {:g} to {:g}", part.factor, part.low, part.high));
  object.about({{"name", "in tables"},
                {"factor", "which lies"},
                {"low", "from here"},
                {"high", "to here, in the factor's unit; of a list its numbers from 0"}});
  object.finish();
  return part;
}

SensitivitySlice read_slice(JsonObject& object, const SensitivitySummary& head) {
  SensitivitySlice slice;
  slice.x = read_factor_name(object, "x", head);
  slice.y = read_factor_name(object, "y", head);
  if (slice.x == slice.y) object.refuse("y", "must be another factor than x");
  slice.name = object.text("name", slice.x + " and " + slice.y);
  slice.steps = 7;
  setting(object, "steps", slice.steps, {2, 100}, "of each");
  slice.claims = object.texts("claims", names_of(head.claims));
  for (const std::string& claim : slice.claims)
    if (const auto known = names_of(head.claims); std::ranges::find(known, claim) == known.end())
      object.refuse("claims", "has \"" + claim + "\", which is none of the claims");
  object.about({{"name", "in tables"},
                {"x", "a factor"},
                {"y", "another; all others are as the simulation has them"},
                {"claims", "that are drawn; without it all"}});
  object.finish();
  return slice;
}

// Both ends of every factor by itself, before anything is simulated.
void check_space(JsonObject& object, const SensitivitySpec& spec) {
  const std::size_t count = spec.head.factors.size();
  for (std::size_t f = 0; f < count; ++f)
    for (const double end : {0.0, 1.0}) {
      std::vector<double> position(count, kNoNumber);
      position[f] = end;
      try {
        simulation_at(spec, position, 1);
      } catch (const InputError& error) {
        object.objects("space")[f].refuse(
            "setting", fmt::format("cannot be {}: {}", spec.head.text_at(f, end), error.what()));
      }
    }
}

Json simulation_of(JsonObject& object, const std::filesystem::path& folder, const Json& fallback,
                   std::string& place) {
  place = object.place_of("simulation");
  if (!object.has("simulation")) return fallback;
  const Json& given = object.value("simulation");
  if (given.is_object()) return given;
  const std::filesystem::path path = folder / object.text("simulation");
  place = path.string();
  return read_json(path);
}

void refuse_twice(JsonObject& object, const std::string& key, const std::vector<std::string>& names) {
  if (const std::string twice = first_repeated(names); !twice.empty())
    object.refuse(key, "has \"" + twice + "\" twice");
}

}  // namespace

SensitivitySpec parse_sensitivity(const Json& json, const std::string& place,
                                  const std::filesystem::path& folder, const Json& fallback) {
  JsonObject object(json, place, "");
  object.choice("kind", {"sensitivity"});
  SensitivitySpec spec;
  spec.study = read_accuracy_settings(object, folder);
  if (!spec.study.campaign.empty())
    object.refuse("campaign", "is of no use: a sensitivity study simulates its own campaigns");
  spec.simulation = simulation_of(object, folder, fallback, spec.place);
  SensitivitySummary& head = spec.head;
  head.study = spec.study.name;
  for (const AlignmentKind alignment : spec.study.alignments)
    head.alignments.emplace_back(name_of(alignment));
  head.seed = 1, head.participants = 4, head.rows = 150;
  setting(object, "seed", head.seed, "of the campaigns");
  setting(object, "participants", head.participants, {1, 10'000}, "of each campaign");
  for (const MethodSpec& method : spec.study.methods) head.methods.push_back(method.name);
  std::vector<std::string> factors;
  for (JsonObject& entry : object.objects("space")) {
    head.factors.push_back(read_factor(entry, spec.values.emplace_back()));
    factors.push_back(head.factors.back().name);
  }
  if (factors.empty() || factors.size() > kMostFactors)
    object.refuse("space", fmt::format("must hold 1 to {} factors", kMostFactors));
  refuse_twice(object, "space", factors);
  for (JsonObject& entry : object.objects("claims")) head.claims.push_back(read_claim(entry, head.methods));
  refuse_twice(object, "claims", names_of(head.claims));
  if (object.has("parts"))
    for (JsonObject& entry : object.objects("parts")) head.parts.push_back(read_part(entry, head));
  if (object.has("slices"))
    for (JsonObject& entry : object.objects("slices")) head.slices.push_back(read_slice(entry, head));
  setting(object, "rows", head.rows, {kFewestRows, 1'000'000},
          "of the design; campaigns are as many times the factors and 2");
  object.shape("simulation", R"({"type": ["object", "string"]})");
  object.about({{"simulation", "simulation.json or its path; without it the paper's campaign"},
                {"space", "the settings that are varied"},
                {"claims", "which method is said to err less than which"},
                {"parts", "of the space, in which the claims are judged again"},
                {"slices", "pairs of factors, all others as the simulation has them"}});
  object.finish();
  check_space(object, spec);
  return spec;
}

SimulationSpec simulation_at(const SensitivitySpec& spec, const std::vector<double>& position,
                             std::uint64_t seed) {
  Json json = spec.simulation;
  json["seed"] = seed;
  json["participants"] = spec.head.participants;
  for (std::size_t f = 0; f < position.size(); ++f) {
    if (!std::isfinite(position[f])) continue;
    const double value = spec.head.value_at(f, position[f]);
    try {
      Json& setting = json[Json::json_pointer(spec.head.factors[f].setting)];
      setting = spec.values[f].empty() ? Json(value) : spec.values[f][static_cast<std::size_t>(value)];
      if (spec.head.factors[f].whole) setting = static_cast<std::uint64_t>(value);
    } catch (const Json::exception&) {
      throw InputError(spec.place + " " + spec.head.factors[f].setting,
                       "is no setting of simulation.json that could be varied");
    }
  }
  SimulationSpec simulation = parse_simulation(json, spec.place, {});
  if (!spec.study.conditions.empty())
    std::erase_if(simulation.activities, [&](const ActivitySpec& activity) {
      const std::string& name = activity_names()[static_cast<std::size_t>(activity.activity)];
      return std::ranges::find(spec.study.conditions, name) == spec.study.conditions.end();
    });
  return simulation;
}

}  // namespace trilat
