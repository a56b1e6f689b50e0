// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/base/time.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/ceres/ceres_trilateration.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"

namespace trilat {

// What a study.json asks for; each kind has its own reader.
enum class StudyKind : std::uint8_t { accuracy, threshold_sweep, calibration };
StudyKind study_kind(const Json& json, const std::string& place);

enum class MethodKind { linear, geometric, nonlinear, newton, ceres, mean, tracked_mean, single };
const std::vector<std::string>& method_kind_names();

// One method with its settings, before it is known which sensors the rig has. Only the options of its own
// kind count.
struct MethodSpec {
  MethodKind kind = MethodKind::nonlinear;
  std::string name;                  // of its rows; unique in the study
  std::vector<std::string> sensors;  // those it may use; empty: all. geometric uses the first three
  std::string reference;             // linear: the reference sensor; empty: the first
  LinearOptions linear;
  NonlinearOptions nonlinear;  // of nonlinear and newton
  CeresOptions ceres;
};

// study.json, format 1, kind "accuracy": takes x methods -> errors.
struct StudySpec {
  std::string name;
  std::filesystem::path campaign;    // relative to the study's file; may be given on the command line instead
  std::vector<std::string> sensors;  // empty: those of the take that has most, the first of equals
  std::vector<std::string> joints;   // empty: all that the mappings map
  std::vector<AlignmentKind> alignments{AlignmentKind::mean};
  double rate_hz = 30.0;              // of the instants that are evaluated
  double sensor_gap_s = 0.1;          // a sensor is not interpolated across a longer gap
  double truth_gap_s = 0.05;          // nor the ground truth
  double cross_check_limit_m = 1e-7;  // `run --cross-check` fails beyond
  std::vector<MethodSpec> methods;
};

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder);
StudySpec read_study(const std::filesystem::path& path);

// Every setting written out, defaults included: what goes into the manifest and its hash.
Json resolved_json(const StudySpec& spec);

}  // namespace trilat
