// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/synthetic/range_trials.h"
#include "evaluators/solvers/nonlinear.h"
#include "evaluators/solvers/sensor_plane.h"
#include "pipeline/study/study.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// In a document {"name", "heights_m": […], "radius_m"}, sensor i at angle 360 i / n degrees of a circle
// around the origin (x = r cos, z = r sin), or {"name", "sensors_m": [[x, y, z], …]}.
struct SweepRig {
  std::string name;
  std::vector<std::array<double, 3>> sensors_m;  // world

  static void fields(SweepRig& self, Fields& f);
  void check(const JsonPlace& place) const;  // 3 to 8 sensors, no two in one place and not all on one line
};

// A key of a setting whose value is one of some words.
struct SweepChoice {
  const char* key;
  std::string SweepSetting::*word;
  std::vector<std::string> known;
  const char* meaning;
};
const std::vector<SweepChoice>& sweep_choices();

inline constexpr std::uint64_t kMaxSweepIterations = 20'000;

// Range of measurement errors; in a document [low, high] in centimetres.
struct ErrorRange {
  double low_m = 0.0, high_m = 0.0;
  bool operator==(const ErrorRange&) const = default;
  void read(const Json& json, const JsonPlace& place, const About& about);
  Json json() const;
  static Json schema(const About& about);
};

// study.json, format 1, kind "threshold_sweep": trials for every combination of the values that vary.
struct SweepSpec {
  std::string name;
  PaperStudy paper = PaperStudy::none;
  std::vector<SweepRig> rigs;
  SweepSetting solver;  // of every cell, but for what varies
  std::vector<std::pair<const SweepChoice*, std::vector<std::string>>> varied;
  std::vector<double> thresholds;  // C
  std::vector<ErrorRange> ranges;
  std::uint64_t trials = 5000;  // of each cell
  std::uint64_t seed = 1;
  std::uint64_t max_iterations = 10000;
  std::uint64_t time_problems = 0;  // solved by the scalar solver on one thread; 0: times as the run took
  std::vector<SweepSetting> cells;  // every combination that makes sense, in the order of the results
  std::uint64_t skipped = 0;        // combinations that contradict themselves or repeat another

  static void fields(SweepSpec& spec, Fields& f);
  void check(const JsonPlace& place) const;
};

// Skipped are combinations that contradiction_in() names, a linear start for a rig that linear trilateration
// has no answer for, and the stop rule step in a second unit, as it uses no C. InputError at `place` when
// nothing is left, or it is more than can be counted or kept.
SweepSpec parse_sweep(const Json& json, const std::string& place);

enum class SweepStart : std::uint8_t {
  linear,          // linear trilateration, as the paper
  squared_ranges,  // solve_squared_ranges()
};

// The trials of one cell, and how they are solved.
struct SweepTrials {
  RangeTrialModel model;
  NonlinearOptions options;
  SweepStart start = SweepStart::linear;
  SensorPlane plane;     // of the rig
  RangeProblem sensors;  // without ranges
  // The sensors' mean goes along as the problem's guess, to choose between mirror images.
  bool has_guess = false;
};
SweepTrials trials_of(const SweepSpec& spec, const SweepSetting& setting);

// Trials that one thread sums up; the sums of a cell's chunks are added in their order.
inline constexpr std::size_t kChunkTrials = 8192;

// Solves the sweep's trials on the threads of the current arena. An item is the cells of one interpretation,
// or some of them; summary.json is a SweepSummary, timings.json SweepTimings. Throws Interrupted.
ItemCounts run_sweep(const SweepSpec& spec, const std::filesystem::path& folder, const StudyOptions& options);

}  // namespace trilat
