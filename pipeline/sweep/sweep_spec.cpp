// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/known_names.h"
#include "datasets/base/settings.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

// 1 to 60 characters that fit into a heading and a cell of a table.
bool is_plain_name(const std::string& name) {
  const auto is_odd = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '|' || c == 127; };
  return !name.empty() && name.size() <= 60 && std::ranges::none_of(name, is_odd);
}

constexpr std::size_t kMinSensors = 3;
constexpr double kSamePlace_m = 1e-3;
constexpr double kMaxDistance_m = 1e4;

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
  if (sensors_m.size() < kMinSensors || sensors_m.size() > RangeTrialModel::kMaxSensors)
    object.refuse(key, fmt::format("must place {} to {} sensors, places {}", kMinSensors,
                                   RangeTrialModel::kMaxSensors, sensors_m.size()));
  for (const auto& sensor_m : sensors_m)
    for (const double coordinate_m : sensor_m)
      if (!(std::abs(coordinate_m) <= kMaxDistance_m))
        object.refuse(key, fmt::format("must stay within {} m of the origin", kMaxDistance_m));
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
constexpr std::uint64_t kMaxTrials = 1'000'000'000'000;
constexpr std::uint64_t kMaxTimed = 1'000'000;
constexpr std::size_t kMaxCells = 50'000;
constexpr double kMaxTrialsInAll = 0x1p53;
constexpr double kMaxError_cm = 1e5;

// Centimetres as they were written: 7 cm are not 7.000000000000001.
double centimetres(double length_m) { return std::round(length_m * 1e11) / 1e9; }
// The same length again from what is written.
double as_written_m(double length_cm) {
  return centimetres(length_cm * kMetresPerCentimetre) * kMetresPerCentimetre;
}

std::array<double, 2> read_range(const std::string& place, const Json& value) {
  const auto refuse = [&](const std::string& problem) { throw InputError(place, problem); };
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    refuse("must be an array of two numbers, as in [5, 15]");
  const double low_cm = value[0].get<double>(), high_cm = value[1].get<double>();
  if (low_cm < 0.0) refuse(fmt::format("must not be below 0, is {}", value.dump()));
  if (low_cm > high_cm) refuse(fmt::format("must have the smaller error first, is {}", value.dump()));
  if (high_cm > kMaxError_cm) refuse(fmt::format("must stay within {} cm", kMaxError_cm));
  return {as_written_m(low_cm), as_written_m(high_cm)};
}

double read_threshold(const std::string& place, const Json& value) {
  if (!value.is_number() || !(value.get<double>() > 0.0))
    throw InputError(place, fmt::format("must be a number greater than 0, is {}", value.dump()));
  return value.get<double>();
}

// The values under a key of "vary", each read by `read`; no two alike.
template <class Value>
std::vector<Value> read_values(JsonObject& object, const char* key,
                               Value (*read)(const std::string&, const Json&)) {
  const Json& values = object.value(key);
  if (!values.is_array() || values.empty()) object.refuse(key, "must be a list of at least one value");
  std::vector<Value> all;
  for (std::size_t i = 0; i < values.size(); ++i) {
    all.push_back(read(fmt::format("{}/{}", object.place_of(key), i), values[i]));
    if (std::ranges::count(all, all.back()) > 1) object.refuse(key, "has " + values[i].dump() + " twice");
  }
  return all;
}

constexpr const char* kRangeShape =
    R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})";

SweepSetting read_solver(JsonObject object) {
  SweepSetting solver;
  for (const SweepChoice& choice : sweep_choices()) {
    std::string& word = solver.*choice.word;
    const auto usual = std::ranges::find(choice.known, word) - choice.known.begin();
    word = choice.known[object.choice(choice.key, choice.known, static_cast<std::size_t>(usual))];
    object.about({{choice.key, choice.meaning}});
  }
  if (object.has("threshold"))
    solver.threshold = read_threshold(object.place_of("threshold"), object.value("threshold"));
  if (object.has("error_cm")) {
    const auto range_m = read_range(object.place_of("error_cm"), object.value("error_cm"));
    solver.error_low_m = range_m[0];
    solver.error_high_m = range_m[1];
  }
  object.shape("threshold", R"({"type": "number", "exclusiveMinimum": 0})");
  object.shape("error_cm", kRangeShape);
  object.about({{"threshold", "C, in its unit"}, {"error_cm", "[low, high] of the measurement errors"}});
  object.finish();
  return solver;
}

std::vector<std::string> read_words(JsonObject& object, const SweepChoice& choice) {
  const std::vector<std::string> words = object.texts(choice.key);
  if (words.empty())
    object.refuse(choice.key, fmt::format("must name at least one of: {}", fmt::join(choice.known, ", ")));
  if (const std::string twice = first_repeated(words); !twice.empty())
    object.refuse(choice.key, "has \"" + twice + "\" twice");
  object.words(choice.key, choice.known);
  for (const std::string& word : words)
    if (std::ranges::find(choice.known, word) == choice.known.end())
      object.refuse(choice.key, fmt::format("has \"{}\"; {}", word, known_names(word, choice.known)));
  return words;
}

// `solver`: the object of that key, whose keys must be others.
void read_vary(JsonObject object, const Json& solver, SweepSpec& spec) {
  for (const std::string& key : object.keys())
    if (solver.contains(key)) object.refuse(key, "is also in \"solver\"; a value is constant or varies");
  for (const SweepChoice& choice : sweep_choices()) {
    if (object.has(choice.key)) spec.varied.emplace_back(&choice, read_words(object, choice));
    object.about({{choice.key, choice.meaning}});
  }
  if (object.has("threshold")) spec.thresholds = read_values<double>(object, "threshold", read_threshold);
  if (object.has("error_cm"))
    spec.ranges_m = read_values<std::array<double, 2>>(object, "error_cm", read_range);
  object.shape("threshold", R"({"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}})");
  object.shape("error_cm", fmt::format(R"({{"type": "array", "items": {}}})", kRangeShape).c_str());
  object.about({{"threshold", "values of C"}, {"error_cm", "ranges of the measurement errors"}});
  object.finish();
}

RangeProblem unit_problem(const SweepRig& rig) {
  RangeProblem problem = problem_at(rig.sensors_m);
  for (int i = 0; i < problem.count; ++i) problem.range_m[i] = 1.0;
  return problem;
}

bool makes_sense(const SweepSpec& spec, const SweepSetting& s, const SweepRig& rig) {
  const SweepTrials trials = trials_of(spec, s);
  if (!contradiction_in(trials.options).empty()) return false;
  if (trials.start == SweepStart::linear && !linear_position_m(unit_problem(rig), trials.options.linear))
    return false;
  if (s.stop != "step" || s.gradient == "printed") return true;
  for (const auto& [choice, words] : spec.varied)
    if (choice->word == &SweepSetting::threshold_unit) return s.threshold_unit == words.front();
  return true;
}

// Every combination; rigs vary slowest, ranges of errors quickest.
void make_cells(SweepSpec& spec) {
  for (const SweepRig& rig : spec.rigs) {
    std::vector<SweepSetting> interpretations{spec.solver};
    interpretations.front().rig = rig.name;
    for (const auto& [choice, words] : spec.varied) {
      std::vector<SweepSetting> longer;
      for (const SweepSetting& setting : interpretations)
        for (const std::string& word : words) longer.emplace_back(setting).*choice->word = word;
      interpretations = std::move(longer);
    }
    for (SweepSetting setting : interpretations) {
      if (!makes_sense(spec, setting, rig)) {
        ++spec.skipped;
        continue;
      }
      for (const double threshold : spec.thresholds)
        for (const auto& [low_m, high_m] : spec.ranges_m) {
          setting.threshold = threshold;
          setting.error_low_m = low_m;
          setting.error_high_m = high_m;
          spec.cells.push_back(setting);
        }
    }
  }
}

void check_size(const SweepSpec& spec, const std::string& place) {
  if (spec.cells.empty())
    throw InputError(
        place + " /vary",
        fmt::format("leaves nothing to compute: each of the {} combinations contradicts itself "
                    "(printed gradient with damping lm, newton without lm, a linear start for "
                    "sensors in one plane or fewer than four); name another value, or a rig that "
                    "has it",
                    spec.skipped));
  if (spec.cells.size() > kMaxCells)
    throw InputError(place + " /vary", fmt::format("asks for {} cells in all; at most {} can be kept",
                                                   spec.cells.size(), kMaxCells));
  if (static_cast<double>(spec.trials) * static_cast<double>(spec.cells.size()) > kMaxTrialsInAll)
    throw InputError(place + " /trials",
                     fmt::format("is {}, which with {} cells is more than 2^53 trials in all", spec.trials,
                                 spec.cells.size()));
}

void tell_counts(Settings& s, SweepSpec& spec) {
  s.choice("paper", spec.paper, kPaperStudies, kPaperStudyMeaning);
  s("trials", spec.trials, {1, kMaxTrials}, "of each cell");
  s("seed", spec.seed, "of every random number");
  s("max_iterations", spec.max_iterations, {1, kMaxSweepIterations}, "of a descent");
  s("time_problems", spec.time_problems, {0, kMaxTimed},
    "problems of each cell that the scalar solver solves on one thread, timed three times, the fastest "
    "counts; 0: the run's own times are shown");
}

// Root mean square of the range errors of a cell's trials.
double range_rms_m(TrialError error, double low, double high) {
  const double rms_m = std::sqrt((low * low + low * high + high * high) / 3.0);
  switch (error) {
    case TrialError::range_signed:
      return rms_m;
    case TrialError::displacement:
      return rms_m / std::sqrt(3.0);
    case TrialError::gaussian:
      return 0.5 * (low + high) * std::sqrt(0.5 * std::numbers::pi);
  }
  TRILAT_CHECK(false, "an error model is one of the three");
}

// The value of an enum whose words a choice lists in its order.
template <class Enum>
Enum value_of(const SweepSetting& setting, std::string SweepSetting::*word) {
  const auto choice = std::ranges::find(sweep_choices(), word, &SweepChoice::word);
  return static_cast<Enum>(std::ranges::find(choice->known, setting.*word) - choice->known.begin());
}

}  // namespace

const std::vector<SweepChoice>& sweep_choices() {
  static const std::vector<SweepChoice> choices{
      {"joint", &SweepSetting::joint, {"centre", "volume"}, "at the centre of the rig, or anywhere in it"},
      {"error_model",
       &SweepSetting::error_model,
       {"range_signed", "displacement", "gaussian"},
       "of ranges, or of the joint as a sensor sees it"},
      {"threshold_unit", &SweepSetting::threshold_unit, {"cm2", "m2"}, "in which C is counted"},
      {"gradient", &SweepSetting::gradient, {"printed", "corrected"}, "as printed (eq. 17) or corrected"},
      {"curvature", &SweepSetting::curvature, {"gauss_newton", "newton"}, "of the step"},
      {"stop",
       &SweepSetting::stop,
       {"printed", "objective", "step"},
       "the rule: as printed (eq. 19), of the objective, or of the step"},
      {"damping", &SweepSetting::damping, {"none", "lm"}, "of the step"},
      {"start", &SweepSetting::start, {"linear", "squared_ranges"}, "of the descent"}};
  return choices;
}

SweepSpec parse_sweep(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  SweepSpec spec;
  object.format(kFormat);
  object.choice("kind", {"threshold_sweep"});
  spec.name = object.text("name");
  if (!is_plain_name(spec.name)) object.refuse("name", "must have 1 to 60 printable characters without '|'");
  object.removed("digits_trials", "tests hold the solvers against Ceres");
  object.removed("time_repeats", "of three rounds the fastest counts");
  object.removed("search", "scripts/fit_paper ranks interpretations of Table I");
  for (const char* key : {"joints", "error_models", "threshold_units", "gradients", "curvatures", "stops",
                          "dampings", "starts", "thresholds", "error_ranges_cm"})
    object.removed(key,
                   "what is constant stands in \"solver\", as {\"stop\": \"objective\"}, and what varies in "
                   "\"vary\", as {\"gradient\": [\"printed\", \"corrected\"], \"threshold\": [1, 1e-4]}");
  spec.rigs = read_rigs(object, "rigs");
  const Json nothing = Json::object();
  const bool has_solver = object.has("solver");
  if (has_solver) spec.solver = read_solver(object.object("solver"));
  if (object.has("vary"))
    read_vary(object.object("vary"), has_solver ? object.value("solver") : nothing, spec);
  if (spec.thresholds.empty()) spec.thresholds = {spec.solver.threshold};
  if (spec.ranges_m.empty()) spec.ranges_m = {{spec.solver.error_low_m, spec.solver.error_high_m}};
  object.about({{"name", "of the study"},
                {"rigs", "each with its sensors"},
                {"solver", "the setting of every cell, but for what varies"},
                {"vary", "keys of it with a list of values: every combination is a cell"}});
  Settings settings(object);
  tell_counts(settings, spec);
  object.finish();
  make_cells(spec);
  check_size(spec, place);
  return spec;
}

Json resolved_json(const SweepSpec& given) {
  SweepSpec spec = given;
  Json json{{"format", kFormat}, {"version", 1}, {"kind", "threshold_sweep"}, {"name", spec.name}};
  for (const SweepRig& rig : spec.rigs)
    json["rigs"].push_back({{"name", rig.name}, {"sensors_m", rig.sensors_m}});
  json["solver"] = Json::object();
  json["vary"] = {{"threshold", spec.thresholds}, {"error_cm", Json::array()}};
  for (const auto& [low_m, high_m] : spec.ranges_m)
    json["vary"]["error_cm"].push_back({centimetres(low_m), centimetres(high_m)});
  for (const SweepChoice& choice : sweep_choices()) json["solver"][choice.key] = spec.solver.*choice.word;
  for (const auto& [choice, words] : spec.varied) {
    json["solver"].erase(choice->key);
    json["vary"][choice->key] = words;
  }
  Settings settings(json);
  tell_counts(settings, spec);
  return json;
}

NumberKey SweepSetting::key() const {
  return {
      .condition = fmt::format("{}, {}, {}, {} to {} m", rig, joint, error_model, error_low_m, error_high_m),
      .group = fmt::format("C = {} {}", threshold, threshold_unit),
      .method = fmt::format("{} gradient, {}, stop {}, damping {}, start {}", gradient, curvature, stop,
                            damping, start)};
}

SweepTrials trials_of(const SweepSpec& spec, const SweepSetting& s) {
  const SweepRig& rig = *std::ranges::find(spec.rigs, s.rig, &SweepRig::name);
  const bool is_cm = s.threshold_unit == "cm2";
  SweepTrials t;
  t.sensors = problem_at(rig.sensors_m);
  t.plane = plane_of(t.sensors);
  t.start = value_of<SweepStart>(s, &SweepSetting::start);
  t.model.seed = spec.seed;
  t.model.sensors = t.sensors.count;
  for (std::size_t i = 0; i < rig.sensors_m.size(); ++i) t.model.sensor_m[i] = rig.sensors_m[i];
  t.model.joint = value_of<TrialJoint>(s, &SweepSetting::joint);
  t.model.error = value_of<TrialError>(s, &SweepSetting::error_model);
  t.model.low_m = s.error_low_m;
  t.model.high_m = s.error_high_m;
  NonlinearOptions& o = t.options;
  o.gradient = value_of<Gradient>(s, &SweepSetting::gradient);
  o.curvature = value_of<Curvature>(s, &SweepSetting::curvature);
  o.stop = value_of<StopRule>(s, &SweepSetting::stop);
  o.damping = value_of<Damping>(s, &SweepSetting::damping);
  o.max_iterations = static_cast<int>(spec.max_iterations);
  o.printed_unit_m = is_cm ? kMetresPerCentimetre : 1.0;
  o.threshold_m2 = s.threshold * (is_cm ? kSquareMetresPerSquareCentimetre : 1.0);
  o.start = t.start == SweepStart::linear ? Start::linear : Start::squared_ranges;
  o.range_sigma_m = range_rms_m(t.model.error, s.error_low_m, s.error_high_m);
  t.has_guess = t.plane.exact || o.damping == Damping::lm;
  return t;
}

}  // namespace trilat
