// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"

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

RangeProblem problem_at(const std::vector<std::array<double, 3>>& sensors_m) {
  RangeProblem problem;
  problem.count = static_cast<int>(sensors_m.size());
  for (std::size_t i = 0; i < sensors_m.size(); ++i)
    problem.sensor_m[i] = {sensors_m[i][0], sensors_m[i][1], sensors_m[i][2]};
  return problem;
}

constexpr std::uint64_t kMaxTrials = 1'000'000'000'000;
constexpr std::uint64_t kMaxTimed = 1'000'000;
constexpr std::size_t kMaxCells = 50'000;
constexpr double kMaxTrialsInAll = 0x1p53;
constexpr double kMaxError_cm = 1e5;

// Centimetres as they were written: 7 cm are not 7.000000000000001.
double centimetres(double length_m) { return std::round(length_m * 1e11) / 1e9; }
// Length as it is read again from what is written.
double as_written_m(double length_cm) {
  return centimetres(length_cm * kMetresPerCentimetre) * kMetresPerCentimetre;
}

// "solver": the setting of every cell, of which the keys are kept that were given.
struct SolverFields {
  SweepSpec* spec;
  std::set<std::string> given = {};

  static void fields(auto& self, Fields& f) {
    SweepSetting& solver = self.spec->solver;
    const auto is_varied = [&](const SweepChoice& choice) {
      return std::ranges::any_of(self.spec->varied, [&](const auto& one) { return one.first == &choice; });
    };
    for (const SweepChoice& choice : sweep_choices())
      if (f.writes_if(!is_varied(choice)))
        f(choice.key, solver.*choice.word, opt(choice.meaning).one_of(choice.known));
    if (f.writes()) return;  // these are lists of one value then
    ErrorRange range{solver.error_low_m, solver.error_high_m};
    f("threshold", solver.threshold, opt("Stopping threshold C, in its unit", kPositive));
    f("error_cm", range, opt("Range of the measurement errors, [low, high]; never below 0"));
    if (!f.reads()) return;
    solver.error_low_m = range.low_m;
    solver.error_high_m = range.high_m;
    self.given = f.keys();
  }
};

// "vary": the keys of "solver" with a list of values each.
struct VaryFields {
  SweepSpec* spec;
  std::set<std::string> constant = {};

  static void fields(auto& self, Fields& f) {
    SweepSpec& s = *self.spec;
    f("threshold", s.thresholds, opt("Values of C", kPositive).items(1));
    f("error_cm", s.ranges, opt("Ranges of the measurement errors").items(1));
    for (const SweepChoice& choice : sweep_choices()) {
      std::vector<std::string> words;
      for (const auto& [varied, names] : s.varied)
        if (varied == &choice) words = names;
      if (!f.has(choice.key, !words.empty())) continue;
      f(choice.key, words, opt(choice.meaning).one_of(choice.known).items(1));
      if (f.reads()) s.varied.emplace_back(&choice, words);
    }
    for (const std::string& key : self.constant)
      if (f.has(key.c_str(), false))
        f.refuse(key.c_str(), "is also in \"solver\"; a value is constant or varies");
  }
};

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
        for (const auto& [low_m, high_m] : spec.ranges) {
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
      {"joint",
       &SweepSetting::joint,
       {"centre", "volume"},
       "Place of the joint. centre: (0, 1, 0) m; volume: uniform, x and z within 0.6 m, y from 0.1 to 1.9 m"},
      {"error_model",
       &SweepSetting::error_model,
       {"range_signed", "displacement", "gaussian"},
       "Model of the measurement errors. range_signed: on ranges, magnitude uniform in error_cm, either "
       "sign; displacement: each sensor sees the joint displaced, length uniform in error_cm, direction "
       "uniform on the sphere; gaussian: on ranges, normal, with the middle of error_cm as mean magnitude"},
      {"threshold_unit",
       &SweepSetting::threshold_unit,
       {"cm2", "m2"},
       "Unit of C; in its square root the printed gradient counts distances"},
      {"gradient",
       &SweepSetting::gradient,
       {"printed", "corrected"},
       "Gradient: eq. 17 as printed, or corrected"},
      {"curvature",
       &SweepSetting::curvature,
       {"gauss_newton", "newton"},
       "Curvature by which a step is made"},
      {"stop",
       &SweepSetting::stop,
       {"printed", "objective", "step"},
       "Stopping rule, as of the method nonlinear"},
      {"damping",
       &SweepSetting::damping,
       {"none", "lm"},
       "Damping of the step, as of the method nonlinear. lm has the mean of the joint as the sensors see it "
       "as a guess, and the cell's root mean square range error as range_sigma_m; without it only sensors "
       "exactly in one plane have the guess"},
      {"start",
       &SweepSetting::start,
       {"linear", "squared_ranges"},
       "Point at which a descent begins, as of the method nonlinear"}};
  return choices;
}

void ErrorRange::read(const Json& json, const JsonPlace& place, const About&) {
  std::array<double, 2> cm{};
  json_value::read_value(json, place, need("cm", {0.0, kMaxError_cm}), cm);
  if (cm[0] > cm[1]) place.refuse(fmt::format("must have the smaller error first, is {}", json.dump()));
  low_m = as_written_m(cm[0]);
  high_m = as_written_m(cm[1]);
}

Json ErrorRange::json() const { return {centimetres(low_m), centimetres(high_m)}; }

Json ErrorRange::schema(const About&) {
  return json_value::schema(std::array<double, 2>{}, need("cm", {0.0, kMaxError_cm}));
}

void SweepRig::fields(SweepRig& self, Fields& f) {
  f("name", self.name, need("Name of the rig"));
  if (f.writes()) return f("sensors_m", self.sensors_m, opt("positions"));
  const bool is_circle = f.has("heights_m", false);
  if (f.reads() && is_circle == f.has("sensors_m", false))
    f.refuse(is_circle ? "sensors_m" : "heights_m",
             "a rig has either heights_m on a circle or sensors_m, and one of them");
  std::vector<double> heights_m;
  double radius_m = 2.0;
  if (is_circle) {
    f("heights_m", heights_m,
      opt("Heights of 3 to 8 sensors on a circle; sensor i of n stands at 360 i / n degrees (x = r cos, z = "
          "r sin)"));
    f("radius_m", radius_m, opt("Radius of that circle", {0.0, kMaxDistance_m, true}));
  }
  if (f.has("sensors_m", false))
    f("sensors_m", self.sensors_m,
      opt("Positions of 3 to 8 sensors, instead of heights; not all on one line"));
  if (f.reads())
    for (std::size_t i = 0; i < heights_m.size(); ++i)
      self.sensors_m.push_back(on_circle(i, heights_m.size(), radius_m, heights_m[i]));
}

void SweepRig::check(const JsonPlace& place) const {
  if (!is_plain_name(name) || name.find('/') != std::string::npos)
    place.at("name").refuse("must have 1 to 60 printable characters, none of them '/' or '|'");
  if (sensors_m.size() < kMinSensors || sensors_m.size() > RangeTrialModel::kMaxSensors)
    place.refuse(fmt::format("must place {} to {} sensors, places {}", kMinSensors,
                             RangeTrialModel::kMaxSensors, sensors_m.size()));
  for (const auto& sensor_m : sensors_m)
    for (const double coordinate_m : sensor_m)
      if (!(std::abs(coordinate_m) <= kMaxDistance_m))
        place.refuse(fmt::format("must stay within {} m of the origin", kMaxDistance_m));
  const RangeProblem problem = problem_at(sensors_m);
  for (int i = 0; i < problem.count; ++i)
    for (int j = 0; j < i; ++j)
      if ((problem.sensor_m[i] - problem.sensor_m[j]).norm() < kSamePlace_m)
        place.refuse(fmt::format("has sensors {} and {} in one place", j, i));
  if (plane_of(problem).collinear)
    place.refuse("has all sensors on one line, so a whole circle of positions has the same ranges");
}

void SweepSpec::fields(SweepSpec& spec, Fields& f) {
  std::size_t kind = 0;
  f.format("trilat.study");
  f.tag("kind", kind, {name_of(StudyKind::threshold_sweep)}, "");
  f("name", spec.name, need("Name of the study"));
  f.removed("digits_trials", "tests hold the solvers against Ceres");
  f.removed("time_repeats", "of three rounds the fastest counts");
  f.removed("search", "scripts/fit_paper ranks interpretations of Table I");
  for (const char* key : {"joints", "error_models", "threshold_units", "gradients", "curvatures", "stops",
                          "dampings", "starts", "thresholds", "error_ranges_cm"})
    f.removed(key,
              "what is constant stands in \"solver\", as {\"stop\": \"objective\"}, and what varies in "
              "\"vary\", as {\"gradient\": [\"printed\", \"corrected\"], \"threshold\": [1, 1e-4]}");
  f("rigs", spec.rigs, need("Rigs, each with its sensors").items(1));
  SolverFields solver{&spec};
  f("solver", solver, opt("Setting of every cell, but for what varies"));
  VaryFields vary{&spec, solver.given};
  f("vary", vary,
    opt("Keys of the solver, each with a list of values: every combination is a cell. Skipped and counted "
        "are the printed gradient with lm, newton without it, a linear start for sensors in one plane or "
        "fewer than four, and step with the corrected gradient in a second unit"));
  f("paper", spec.paper, opt(kPaperStudyMeaning));
  f("trials", spec.trials, opt("Trials of each cell", {1.0, kMaxTrials}));
  f("seed", spec.seed,
    opt("Seed of every random number; a trial's depend on the seed and its number only, so that all cells "
        "see the same"));
  f("max_iterations", spec.max_iterations,
    opt("Largest number of iterations of a descent", {1.0, kMaxSweepIterations}));
  f("time_problems", spec.time_problems,
    opt("Problems of each cell that the scalar solver solves on one thread, timed three times, of which the "
        "fastest counts; 0: the run's own times are shown",
        {0.0, kMaxTimed}));
}

void SweepSpec::check(const JsonPlace& place) const {
  if (!is_plain_name(name)) place.at("name").refuse("must have 1 to 60 printable characters without '|'");
  for (std::size_t r = 0; r < rigs.size(); ++r)
    for (std::size_t before = 0; before < r; ++before) {
      const JsonPlace name_place = place.at("rigs").at(r).at("name");
      if (rigs[before].name == rigs[r].name)
        name_place.refuse("is \"" + rigs[r].name + "\", which an earlier rig has");
      if (rigs[before].sensors_m == rigs[r].sensors_m)
        name_place.refuse("names the same sensors as \"" + rigs[before].name + '"');
    }
  const auto check_differ = [&](const char* key, const auto& values) {
    for (auto value = values.begin(); value != values.end(); ++value)
      if (std::find(values.begin(), value, *value) != value)
        place.at("vary").at(key).refuse(
            fmt::format("has {} twice", json_text(json_value::written(*value, {}), -1)));
  };
  check_differ("threshold", thresholds);
  check_differ("error_cm", ranges);
}

SweepSpec parse_sweep(const Json& json, const std::string& place) {
  auto spec = read_as<SweepSpec>(json, {place});
  if (spec.thresholds.empty()) spec.thresholds = {spec.solver.threshold};
  if (spec.ranges.empty()) spec.ranges = {{spec.solver.error_low_m, spec.solver.error_high_m}};
  make_cells(spec);
  check_size(spec, place);
  return spec;
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
