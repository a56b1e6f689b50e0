// SPDX-License-Identifier: MIT
#include "pipeline/variations/variations_spec.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gsl/gsl_qrng.h>

#include "datasets/base/content_hash.h"
#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/take/plan.h"

namespace trilat {
namespace {

constexpr std::uint64_t kFewestPoints = 8;
constexpr std::size_t kMostRanges = 20;

std::string text_of(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

VariedRange read_range(JsonObject& object, std::vector<Json>& values) {
  VariedRange range;
  range.setting = object.text("setting");
  range.name = object.text("name", range.setting.substr(range.setting.rfind('/') + 1));
  range.unit = object.text("unit", "");
  if (range.setting.size() < 2 || range.setting[0] != '/')
    object.refuse("setting", "must be a path into simulation.json, as \"/rig/radius_m\"");
  if (object.has("values")) {
    const Json& list = object.value("values");
    if (!list.is_array() || list.size() < 2) object.refuse("values", "must be an array of at least 2 values");
    values.assign(list.begin(), list.end());
    for (const Json& value : values) range.values.push_back(text_of(value));
  } else {
    if (!object.has("low") || !object.has("high"))
      object.refuse("low", "and high are the ends of the range: give both, or a list of values");
    range.low = object.number("low", 0.0);
    range.high = object.number("high", 1.0);
    range.logarithmic = object.boolean("logarithmic", false);
    range.whole = object.boolean("whole", false);
    if (!(range.low < range.high)) object.refuse("high", "must be greater than low");
    if (range.logarithmic && !(range.low > 0.0))
      object.refuse("low", "must be greater than 0 on a logarithmic scale");
    if (range.whole && (range.logarithmic || range.low != std::floor(range.low) ||
                        range.high != std::floor(range.high) || range.low < 0.0))
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
  return range;
}

void check_known(JsonObject& object, const std::string& key, const std::vector<std::string>& asked,
                 const std::vector<std::string>& known, const std::string& what) {
  for (const std::string& name : asked)
    if (std::ranges::find(known, name) == known.end())
      object.refuse(key, fmt::format("has \"{}\", which is none of the {}: \"{}\"", name, what,
                                     fmt::join(known, "\", \"")));
}

MethodComparison read_comparison(JsonObject& object, const std::vector<std::string>& methods) {
  MethodComparison comparison;
  comparison.better = object.text("better");
  check_known(object, "better", {comparison.better}, methods, "methods");
  comparison.than = object.texts("than");
  if (comparison.than.empty()) object.refuse("than", "must name at least one method");
  check_known(object, "than", comparison.than, methods, "methods");
  setting(object, "margin_percent", comparison.margin_percent, {-100.0, 1000.0},
          "by which it may err more and the comparison still holds");
  comparison.name = object.text(
      "name", fmt::format("{} errs less than {}", comparison.better, fmt::join(comparison.than, ", ")));
  object.about({{"name", "in tables"},
                {"better", "the method that is said to err less"},
                {"than", "than each of these"}});
  object.finish();
  return comparison;
}

void read_simulation(JsonObject& object, const std::filesystem::path& folder, const Json& fallback,
                     VariationsSpec& spec) {
  spec.place = object.place_of("simulation");
  spec.folder = folder;
  spec.simulation = fallback;
  if (object.has("simulation")) {
    spec.simulation = object.value("simulation");
    if (!spec.simulation.is_object()) {
      const std::filesystem::path path = folder / object.text("simulation");
      spec.place = path.string();
      spec.folder = path.parent_path();
      spec.simulation = read_json(path);
      if (spec.simulation.is_object()) spec.simulation.erase("scales");  // of `trilat reproduce`
    }
  }
  if (spec.simulation.contains("body_tracker") && spec.simulation["body_tracker"].is_string()) {
    const std::filesystem::path path = spec.folder / spec.simulation["body_tracker"].get<std::string>();
    spec.simulation["body_tracker"] = read_json(path);
  }
  if (!object.has("patch")) return;
  if (!object.value("patch").is_object()) object.refuse("patch", "must be an object");
  spec.simulation.merge_patch(object.value("patch"));
}

// Points of a Sobol sequence, all shifted alike by chance (Cranley and Patterson 1976): spread evenly, and by
// their seed independent of those of another.
std::vector<std::vector<double>> spread_points(std::uint64_t points, std::size_t ranges, std::uint64_t seed) {
  const std::unique_ptr<gsl_qrng, decltype(&gsl_qrng_free)> sequence(
      gsl_qrng_alloc(gsl_qrng_sobol, static_cast<unsigned>(ranges)), gsl_qrng_free);
  TRILAT_CHECK(sequence, "there is a Sobol sequence of so many dimensions");
  const RandomStream random{seed, Purpose::variation, 0};
  std::vector<std::vector<double>> list(points, std::vector<double>(ranges));
  for (std::vector<double>& position : list) {
    gsl_qrng_get(sequence.get(), position.data());
    for (std::size_t r = 0; r < ranges; ++r) position[r] = std::fmod(position[r] + random.uniform(r), 1.0);
  }
  return list;
}

void read_patches(JsonObject& object, VariationsSpec& spec) {
  std::vector<std::string> names;
  for (JsonObject& entry : object.objects("patches")) {
    const std::string name = entry.text("name");
    if (std::ranges::find(names, name) != names.end()) entry.refuse("name", "is there twice");
    names.push_back(name);
    const Json& patch = entry.value("patch");
    if (!patch.is_object()) entry.refuse("patch", "must be an object");
    entry.shape("patch", R"({"type": "object"})");
    entry.about({{"name", "in tables"}, {"patch", "of simulation.json: a JSON merge patch"}});
    entry.finish();
    spec.patches.push_back(patch);
    spec.head.points.push_back({.name = name, .position = {}});
    try {
      simulation_at(spec, spec.patches.size() - 1);
    } catch (const InputError& error) {
      entry.refuse("patch", fmt::format("cannot be: {}", error.what()));
    }
  }
  if (names.empty()) object.refuse("patches", "must hold one at least");
}

// Both ends of every range by itself, before anything is simulated.
void check_ends(JsonObject& object, const VariationsSpec& spec) {
  for (std::size_t r = 0; r < spec.head.ranges.size(); ++r)
    for (const double end : {0.0, 1.0}) {
      VariationsSpec one = spec;
      one.head.points = {{.name = "", .position = std::vector<double>(spec.head.ranges.size(), kNoNumber)}};
      one.head.points[0].position[r] = end;
      try {
        simulation_at(one, 0);
      } catch (const InputError& error) {
        object.objects("ranges")[r].refuse(
            "setting", fmt::format("cannot be {}: {}", spec.head.ranges[r].text_at(end), error.what()));
      }
    }
}

void read_ranges(JsonObject& object, VariationsSpec& spec) {
  std::uint64_t points = 100;
  setting(object, "points", points, {kFewestPoints, 1'000'000}, "of the ranges: a campaign each");
  std::vector<std::string> names;
  for (JsonObject& entry : object.objects("ranges")) {
    spec.head.ranges.push_back(read_range(entry, spec.values.emplace_back()));
    names.push_back(spec.head.ranges.back().name);
  }
  if (names.empty() || names.size() > kMostRanges)
    object.refuse("ranges", fmt::format("must hold 1 to {} settings", kMostRanges));
  if (const std::string twice = first_repeated(names); !twice.empty())
    object.refuse("ranges", "has \"" + twice + "\" twice");
  check_ends(object, spec);
  for (std::vector<double>& position : spread_points(points, names.size(), spec.head.seed))
    spec.head.points.push_back({.name = "", .position = std::move(position)});
}

// A study that does not fit the simulation is refused before anything is simulated.
void check_fits(JsonObject& object, const StudySpec& study, const SimulationSpec& simulation) {
  std::vector<std::string> activities, rig;
  if (simulation.recorded) activities.push_back(simulation.recorded->activity);
  for (const ActivitySpec& activity : simulation.activities)
    activities.push_back(activity_names()[static_cast<std::size_t>(activity.activity)]);
  for (const SensorPose& pose : rig_poses(simulation.rig, Eigen::Vector3d::Zero())) rig.push_back(pose.name);
  check_known(object, "conditions", study.conditions, activities, "activities of the simulation");
  check_known(object, "sensors", study.sensors, rig, "sensors of the simulation");
  reference_of(study, resolve_methods(study, study.sensors.empty() ? rig : study.sensors));
}

SimulationSpec simulation_of(const VariationsSpec& spec, const Json& json) {
  SimulationSpec simulation = parse_simulation(json, spec.place, spec.folder);
  if (!spec.study.conditions.empty())  // the others are not evaluated
    std::erase_if(simulation.activities, [&](const ActivitySpec& activity) {
      const std::string& name = activity_names()[static_cast<std::size_t>(activity.activity)];
      return std::ranges::find(spec.study.conditions, name) == spec.study.conditions.end();
    });
  return simulation;
}

void watch_inputs(const SimulationSpec& simulation, VariationsSpec& spec) {
  std::vector<std::filesystem::path> files;
  if (simulation.recorded) files = {simulation.recorded->mocap, simulation.recorded->mapping};
  if (files.empty()) return;
  spec.inputs = WatchedFiles(files);
  std::string hashes;
  for (const std::filesystem::path& file : files)
    if (std::filesystem::is_regular_file(file)) hashes += hash_of_file(file);
  spec.inputs_sha256 = hash_of_text(hashes);
}

}  // namespace

VariationsSpec parse_variations(const Json& json, const std::string& place,
                                const std::filesystem::path& folder, const Json& fallback) {
  JsonObject object(json, place, "");
  object.choice("kind", {"variations"});
  VariationsSpec spec;
  spec.study = read_accuracy_settings(object, folder);
  if (!spec.study.campaign.empty())
    object.refuse("campaign", "does not apply: a study of variations simulates its own campaigns");
  read_simulation(object, folder, fallback, spec);
  const SimulationSpec base = simulation_of(spec, spec.simulation);
  VariationsSummary& head = spec.head;
  head.study = spec.study.name;
  head.seed = base.seed;
  head.participants = base.recorded ? 1 : base.participants;
  for (const AlignmentKind alignment : spec.study.alignments)
    head.alignments.emplace_back(name_of(alignment));
  for (const MethodSpec& method : spec.study.methods) head.methods.push_back(method.name);
  if (object.has("patches") == object.has("ranges"))
    object.refuse("patches", "and ranges are two ways to vary a simulation: give one of them");
  if (object.has("patches"))
    read_patches(object, spec);
  else
    read_ranges(object, spec);
  if (object.has("comparisons") && object.has("patches"))
    object.refuse("comparisons", "need ranges: shares of patches say nothing");
  if (object.has("comparisons"))
    for (JsonObject& entry : object.objects("comparisons"))
      head.comparisons.push_back(read_comparison(entry, head.methods));
  object.shape("simulation", R"({"type": ["object", "string"]})");
  object.shape("patch", R"({"type": "object"})");
  object.about({{"simulation", "simulation.json or its path; without it the paper's campaign"},
                {"patch", "of it, in all points: a JSON merge patch"},
                {"patches", "of it, one a campaign, all of the same persons"},
                {"ranges", "of its settings; each point is a campaign of other persons"},
                {"comparisons", "which method is said to err less than which"}});
  object.finish();
  check_fits(object, spec.study, parse_simulation(simulation_json_at(spec, 0), spec.place, spec.folder));
  watch_inputs(base, spec);
  return spec;
}

Json simulation_json_at(const VariationsSpec& spec, std::size_t point) {
  Json json = spec.simulation;
  if (!spec.patches.empty()) {
    json.merge_patch(spec.patches[point]);
    return json;
  }
  json["seed"] = spec.head.seed + 1 + point;
  for (std::size_t r = 0; r < spec.head.ranges.size(); ++r) {
    const double position = spec.head.points[point].position[r];
    if (!std::isfinite(position)) continue;
    const VariedRange& range = spec.head.ranges[r];
    const double value = range.value_at(position);
    try {
      Json& setting = json[Json::json_pointer(range.setting)];
      setting = spec.values[r].empty() ? Json(value) : spec.values[r][static_cast<std::size_t>(value)];
      if (range.whole) setting = static_cast<std::uint64_t>(value);
    } catch (const Json::exception&) {
      throw InputError(spec.place + " " + range.setting,
                       "is not a setting of simulation.json that can be varied");
    }
  }
  return json;
}

SimulationSpec simulation_at(const VariationsSpec& spec, std::size_t point) {
  return simulation_of(spec, simulation_json_at(spec, point));
}

Json resolved_json(const VariationsSpec& spec) {
  Json json = resolved_json(spec.study);
  json["kind"] = "variations";
  json["simulation"] = spec.simulation;
  for (std::size_t p = 0; p < spec.patches.size(); ++p)
    json["patches"].push_back({{"name", spec.head.points[p].name}, {"patch", spec.patches[p]}});
  for (std::size_t r = 0; r < spec.head.ranges.size(); ++r) {
    const VariedRange& range = spec.head.ranges[r];
    Json& entry = json["ranges"].emplace_back(
        Json{{"name", range.name}, {"setting", range.setting}, {"unit", range.unit}});
    if (!spec.values[r].empty())
      entry["values"] = spec.values[r];
    else
      entry.update(Json{{"low", range.low},
                        {"high", range.high},
                        {"logarithmic", range.logarithmic},
                        {"whole", range.whole}});
  }
  if (spec.patches.empty()) json["points"] = spec.head.points.size();
  for (const MethodComparison& comparison : spec.head.comparisons)
    json["comparisons"].push_back({{"name", comparison.name},
                                   {"better", comparison.better},
                                   {"than", comparison.than},
                                   {"margin_percent", comparison.margin_percent}});
  return json;
}

}  // namespace trilat
