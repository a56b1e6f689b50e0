// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

// 1 to 60 characters that fit into a heading and a cell of a table.
bool is_plain_name(const std::string& name) {
  const auto is_odd = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '|' || c == 127; };
  return !name.empty() && name.size() <= 60 && std::ranges::none_of(name, is_odd);
}

constexpr std::size_t kLeastSensors = 3;
constexpr double kSamePlace_m = 1e-3;
constexpr double kFarthest_m = 1e4;

std::array<double, 3> on_circle(std::size_t i, std::size_t count, double radius_m, double height_m) {
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
  return {radius_m * std::cos(angle), height_m, radius_m * std::sin(angle)};
}

std::vector<std::array<double, 3>> read_circle(JsonObject& object) {
  const Json& value = object.value("heights_m");
  if (!value.is_array()) object.refuse("heights_m", "must be an array of heights");
  const std::vector<double> heights_m = object.numbers("heights_m", value.size());
  const double radius_m = object.positive("radius_m", 2.0);
  std::vector<std::array<double, 3>> sensors_m;
  for (std::size_t i = 0; i < heights_m.size(); ++i)
    sensors_m.push_back(on_circle(i, heights_m.size(), radius_m, heights_m[i]));
  return sensors_m;
}

std::vector<std::array<double, 3>> read_positions(JsonObject& object) {
  const Json& value = object.value("sensors_m");
  object.shape("sensors_m", R"({"type": "array", "items": {"type": "array", "items": {"type": "number"},
      "minItems": 3, "maxItems": 3}})");
  if (!value.is_array()) object.refuse("sensors_m", "must be an array of positions [x, y, z]");
  std::vector<std::array<double, 3>> sensors_m;
  for (const Json& position : value) {
    if (!position.is_array() || position.size() != 3 || !position[0].is_number() ||
        !position[1].is_number() || !position[2].is_number())
      throw InputError(fmt::format("{}/{}", object.place_of("sensors_m"), sensors_m.size()),
                       "must be a position [x, y, z] in metres");
    sensors_m.push_back({position[0].get<double>(), position[1].get<double>(), position[2].get<double>()});
  }
  return sensors_m;
}

RangeProblem problem_at(const std::vector<std::array<double, 3>>& sensors_m) {
  RangeProblem problem;
  problem.count = static_cast<int>(sensors_m.size());
  for (std::size_t i = 0; i < sensors_m.size(); ++i)
    problem.sensor_m[i] = {sensors_m[i][0], sensors_m[i][1], sensors_m[i][2]};
  return problem;
}

void check_sensors(const JsonObject& object, const std::string& key,
                   const std::vector<std::array<double, 3>>& sensors_m) {
  if (sensors_m.size() < kLeastSensors || sensors_m.size() > RangeTrialModel::kMaxSensors)
    object.refuse(key, fmt::format("must place {} to {} sensors, places {}", kLeastSensors,
                                   RangeTrialModel::kMaxSensors, sensors_m.size()));
  for (const auto& sensor_m : sensors_m)
    for (const double coordinate_m : sensor_m)
      if (!(std::abs(coordinate_m) <= kFarthest_m))
        object.refuse(key, fmt::format("must stay within {} m of the origin", kFarthest_m));
  const RangeProblem problem = problem_at(sensors_m);
  for (int i = 0; i < problem.count; ++i)
    for (int j = 0; j < i; ++j)
      if ((problem.sensor_m[i] - problem.sensor_m[j]).norm() < kSamePlace_m)
        object.refuse(key, fmt::format("has sensors {} and {} in one place", j, i));
  if (plane_of(problem).collinear)
    object.refuse(key, "has all sensors on one line, so a whole circle of positions has the same ranges");
}

SweepRig read_rig(JsonObject& object) {
  SweepRig rig;
  rig.name = object.text("name");
  if (!is_plain_name(rig.name) || rig.name.find('/') != std::string::npos)
    object.refuse("name", "must have 1 to 60 printable characters, none of them '/' or '|'");
  const bool circle = object.has("heights_m");
  if (circle == object.has("sensors_m"))
    object.refuse(circle ? "sensors_m" : "heights_m",
                  "a rig has either heights_m on a circle or sensors_m, and one of them");
  rig.sensors_m = circle ? read_circle(object) : read_positions(object);
  check_sensors(object, circle ? "heights_m" : "sensors_m", rig.sensors_m);
  object.about({{"name", "of the rig"},
                {"heights_m", "of sensors on a circle, spread evenly"},
                {"radius_m", "of that circle"},
                {"sensors_m", "positions, instead of heights"}});
  object.finish();
  return rig;
}

// The list of rigs under `key`: names differ, each rig has 3 to 8 sensors, no two in one place and not all on
// one line. A rig is {"name", "heights_m": […], "radius_m"}, sensor i at angle 360 i / n degrees of a circle
// around the origin (x = r cos, z = r sin), or {"name", "sensors_m": [[x, y, z], …]}.
std::vector<SweepRig> read_rigs(JsonObject& object, const std::string& key) {
  std::vector<SweepRig> rigs;
  std::vector<JsonObject> entries = object.objects(key);
  if (entries.empty()) object.refuse(key, "must hold at least one rig");
  for (JsonObject& entry : entries) {
    rigs.push_back(read_rig(entry));
    for (std::size_t before = 0; before + 1 < rigs.size(); ++before) {
      if (rigs[before].name == rigs.back().name)
        entry.refuse("name", "is \"" + rigs.back().name + "\", which an earlier rig has");
      if (rigs[before].sensors_m == rigs.back().sensors_m)
        entry.refuse("name", "names the same sensors as \"" + rigs[before].name + '"');
    }
  }
  return rigs;
}

constexpr const char* kFormat = "trilat.study";
constexpr std::uint64_t kMostTrials = 1'000'000'000'000;
constexpr std::uint64_t kMostTimed = 1'000'000;
constexpr double kLargestError_cm = 1e5;

using Words = std::vector<std::string>;
const Words kJoints{"centre", "volume"};
const Words kErrors{"range_signed", "displacement", "gaussian"};
const Words kUnits{"cm2", "m2"};
const Words kGradients{"printed", "corrected"};
const Words kCurvatures{"gauss_newton", "newton"};
const Words kStops{"printed", "objective", "step"};
const Words kDampings{"none", "lm"};
const Words kStarts{"linear", "squared_ranges"};

template <class Enum>
std::string word(const Words& words, Enum choice) {
  return words.at(static_cast<std::size_t>(choice));
}

[[noreturn]] void refuse_entry(const JsonObject& object, const char* key, std::size_t i,
                               const std::string& problem) {
  throw InputError(fmt::format("{}/{}", object.place_of(key), i), problem);
}

// A list of different words, each of which is known.
template <class Enum>
void tell_choices(Settings& s, const char* key, const Words& known, std::vector<Enum>& choices,
                  const char* meaning) {
  JsonObject* object = s.reading();
  if (object && object->has(key)) {
    const Words words = object->texts(key);
    if (words.empty())
      object->refuse(key, fmt::format("must name at least one of: {}", fmt::join(known, ", ")));
    if (const std::string twice = first_repeated(words); !twice.empty())
      object->refuse(key, "has \"" + twice + "\" twice");
    choices.clear();
    object->words(key, known);
    for (const std::string& word : words) {
      const auto found = std::ranges::find(known, word);
      if (found == known.end())
        object->refuse(key, fmt::format("has \"{}\"; {}", word, known_names(word, known)));
      choices.push_back(static_cast<Enum>(found - known.begin()));
    }
  }
  if (object) object->about({{key, meaning}});
  Json words = Json::array();
  for (const Enum choice : choices) words.push_back(word(known, choice));
  s.write(key, words);
}

void read_thresholds(JsonObject& object, std::vector<double>& thresholds) {
  const char* key = "thresholds";
  if (!object.has(key)) return;
  if (!object.value(key).is_array()) object.refuse(key, "must be a list of numbers above 0");
  thresholds = object.numbers(key, object.value(key).size());
  if (thresholds.empty()) object.refuse(key, "must hold at least one threshold");
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    if (!(thresholds[i] > 0.0))
      refuse_entry(object, key, i, fmt::format("must be greater than 0, is {}", thresholds[i]));
    if (std::find(thresholds.begin(), thresholds.begin() + static_cast<std::ptrdiff_t>(i), thresholds[i]) !=
        thresholds.begin() + static_cast<std::ptrdiff_t>(i))
      object.refuse(key, fmt::format("has {} twice", thresholds[i]));
  }
}

// Centimetres as they were written: 7 cm are not 7.000000000000001.
double centimetres(double length_m) { return std::round(length_m * 1e11) / 1e9; }
// The same length again from what is written.
double as_written_m(double length_cm) {
  return centimetres(length_cm * kMetresPerCentimetre) * kMetresPerCentimetre;
}

SweepSummary::ErrorRange read_range(const JsonObject& object, const char* key, std::size_t i,
                                    const Json& value) {
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    refuse_entry(object, key, i, "must be an array of two numbers, as in [5, 15]");
  const double low_cm = value[0].get<double>(), high_cm = value[1].get<double>();
  if (low_cm < 0.0) refuse_entry(object, key, i, fmt::format("must not be below 0, is {}", value.dump()));
  if (low_cm > high_cm)
    refuse_entry(object, key, i, fmt::format("must have the smaller error first, is {}", value.dump()));
  if (high_cm > kLargestError_cm)
    refuse_entry(object, key, i, fmt::format("must stay within {} cm", kLargestError_cm));
  return {as_written_m(low_cm), as_written_m(high_cm)};
}

void read_ranges(JsonObject& object, std::vector<SweepSummary::ErrorRange>& ranges) {
  const char* key = "error_ranges_cm";
  if (!object.has(key)) return;
  const Json& values = object.value(key);
  object.shape(key, R"({"type": "array", "items": {"type": "array", "items": {"type": "number"},
      "minItems": 2, "maxItems": 2}, "minItems": 1})");
  if (!values.is_array() || values.empty()) object.refuse(key, "must hold at least one [low, high]");
  ranges.clear();
  for (std::size_t i = 0; i < values.size(); ++i) {
    ranges.push_back(read_range(object, key, i, values[i]));
    for (std::size_t before = 0; before < i; ++before)
      if (values[before] == values[i]) object.refuse(key, "has " + values[i].dump() + " twice");
  }
}

}  // namespace

std::string word_of(TrialJoint joint) { return word(kJoints, joint); }
std::string word_of(TrialError error) { return word(kErrors, error); }
std::string word_of(ThresholdUnit unit) { return word(kUnits, unit); }
std::string word_of(Gradient gradient) { return word(kGradients, gradient); }
std::string word_of(Curvature curvature) { return word(kCurvatures, curvature); }
std::string word_of(StopRule stop) { return word(kStops, stop); }
std::string word_of(Damping damping) { return word(kDampings, damping); }
std::string word_of(SweepStart start) { return word(kStarts, start); }

namespace {

void tell(Settings& s, SweepSpec& spec) {
  JsonObject* object = s.reading();
  tell_choices(s, "joints", kJoints, spec.joints, "at the centre of the rig, or anywhere in it");
  tell_choices(s, "error_models", kErrors, spec.error_models,
               "of ranges, or of the joint as a sensor sees it");
  tell_choices(s, "threshold_units", kUnits, spec.threshold_units, "in which C is counted");
  tell_choices(s, "gradients", kGradients, spec.gradients, "as printed (eq. 17) or corrected");
  tell_choices(s, "curvatures", kCurvatures, spec.curvatures, "of the step");
  tell_choices(s, "stops", kStops, spec.stops,
               "the rule: as printed (eq. 19), of the objective, or of the step");
  tell_choices(s, "dampings", kDampings, spec.dampings, "of the step");
  tell_choices(s, "starts", kStarts, spec.starts, "of the descent");
  if (object) {
    read_thresholds(*object, spec.thresholds);
    read_ranges(*object, spec.ranges);
    object->about({{"thresholds", "C, in each unit"}, {"error_ranges_cm", "[low, high] of the errors"}});
  }
  Json ranges = Json::array();
  for (const auto& range : spec.ranges)
    ranges.push_back({centimetres(range.low_m), centimetres(range.high_m)});
  s.write("thresholds", spec.thresholds);
  s.write("error_ranges_cm", ranges);
  s("trials", spec.trials, {1, kMostTrials}, "of each cell");
  s("seed", spec.seed, "of every random number");
  s("max_iterations", spec.max_iterations, {1, kMostSweepIterations}, "of a descent");
  s("time_problems", spec.time_problems, {0, kMostTimed},
    "problems of each cell that the scalar solver solves on one thread, timed three times, the fastest "
    "counts; 0: the "
    "run's own times are shown");
}

}  // namespace

SweepSpec parse_sweep(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  SweepSpec spec;
  object.format(kFormat);
  object.choice("kind", {"threshold_sweep"});
  spec.name = object.text("name");
  if (!is_plain_name(spec.name)) object.refuse("name", "must have 1 to 60 printable characters without '|'");
  spec.rigs = read_rigs(object, "rigs");
  object.about({{"name", "of the study"}, {"rigs", "each with its sensors"}});
  object.removed("digits_trials", "tests hold the solvers against Ceres");
  object.removed("time_repeats", "of three rounds the fastest counts");
  object.removed("search", "scripts/fit_paper ranks readings of Table I");
  Settings settings(object);
  tell(settings, spec);
  object.finish();
  return spec;
}

Json resolved_json(SweepSpec spec) {
  Json json{{"format", kFormat}, {"version", 1}, {"kind", "threshold_sweep"}, {"name", spec.name}};
  json["rigs"] = Json::array();
  for (const SweepRig& rig : spec.rigs)
    json["rigs"].push_back({{"name", rig.name}, {"sensors_m", rig.sensors_m}});
  Settings settings(json);
  tell(settings, spec);
  return json;
}

}  // namespace trilat
