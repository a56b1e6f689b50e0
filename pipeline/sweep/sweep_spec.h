// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/synthetic/range_trials.h"
#include "evaluators/solvers/descent.h"
#include "pipeline/sweep/sweep_summary.h"

namespace trilat {

// The unit of length of the program that is imitated: it counts C in its square, and the printed gradient's
// distances in it.
enum class ThresholdUnit : std::uint8_t { cm2, m2 };

enum class SweepStart : std::uint8_t {
  linear,          // linear trilateration, as the paper
  squared_ranges,  // squared_range_position_m()
};

struct SweepRig {
  std::string name;
  std::vector<std::array<double, 3>> sensors_m;  // world
};

inline constexpr std::uint64_t kMostSweepIterations = 20'000;

// study.json, format 1, kind "threshold_sweep": stopping threshold x range of measurement errors x trials,
// for every combination of what the paper leaves open. The defaults are the paper's Table I.
struct SweepSpec {
  std::string name;
  std::vector<SweepRig> rigs;
  std::vector<TrialJoint> joints{TrialJoint::volume};
  std::vector<TrialError> error_models{TrialError::range_signed};
  std::vector<ThresholdUnit> threshold_units{ThresholdUnit::cm2};
  std::vector<Gradient> gradients{Gradient::printed, Gradient::corrected};
  std::vector<Curvature> curvatures{Curvature::gauss_newton};
  std::vector<StopRule> stops{StopRule::printed, StopRule::objective};
  std::vector<Damping> dampings{Damping::none};
  std::vector<SweepStart> starts{SweepStart::linear};
  std::vector<double> thresholds{1.0, 1e-2, 1e-4, 1e-6};  // C, in each threshold unit
  std::vector<SweepSummary::ErrorRange> ranges{{0.15, 0.30}, {0.05, 0.15}, {0.0, 0.05}};
  std::uint64_t trials = 5000;  // of each cell
  std::uint64_t seed = 1;
  std::uint64_t max_iterations = 10000;
  std::uint64_t time_problems = 0;  // solved by the scalar solver on one thread; 0: times as the run took
};

SweepSpec parse_sweep(const Json& json, const std::string& place);

// Every setting written out, defaults included: what goes into the manifest and its hash.
Json resolved_json(SweepSpec spec);

// The words of the study for each choice.
std::string word_of(TrialJoint joint);
std::string word_of(TrialError error);
std::string word_of(ThresholdUnit unit);
std::string word_of(Gradient gradient);
std::string word_of(Curvature curvature);
std::string word_of(StopRule stop);
std::string word_of(Damping damping);
std::string word_of(SweepStart start);

}  // namespace trilat
