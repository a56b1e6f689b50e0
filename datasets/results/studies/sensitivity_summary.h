// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/base/strict_json.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"

namespace trilat {

// What a sensitivity study varies: a setting of its simulation, in a range or a list.
struct SensitivityFactor {
  std::string name, unit;
  std::string setting;                   // JSON pointer into simulation.json
  std::vector<std::string> values = {};  // of a list, as text; empty: a range
  double low = kNoNumber, high = kNoNumber;
  bool logarithmic = false, whole = false;  // whole numbers only

  TRILAT_FIELDS(name, unit, setting, values, low, high, logarithmic, whole)
};

// One simulated campaign: where in the space it is, and what the methods' errors were.
struct SensitivityPoint {
  std::string design;            // "space", "default" or a slice's name
  std::uint64_t row = 0;         // of the design
  std::vector<double> position;  // by factor, 0 to 1 within its range or list; NaN: as the simulation has it
  // The mean error of each method (row) over the samples that each other one (column) answers too, both
  // aligned on these; of a method with itself over all its answers. Mean of the joint groups; NaN: no such
  // samples. One such table behind the other for each alignment.
  std::vector<double> paired_m = {};
  std::vector<double> answered = {};  // by method, share
  std::string problem = {};           // why there are no errors; empty when there are

  TRILAT_FIELDS(design, row, position, paired_m, answered, problem)
};

// How a claim depends on one factor, all others anywhere in the space.
struct ClaimByFactor {
  std::string factor;
  Estimate first, total;  // Sobol indices of the logarithm of the ratio
  Estimate break_even;    // where the mean difference changes its sign, in the factor's unit
  struct Bin {
    double position = kNoNumber;  // of its middle, 0 to 1
    Estimate difference_percent, share;
    TRILAT_FIELDS(position, difference_percent, share)
  };
  std::vector<Bin> bins;  // equal parts of the range, or the values of the list

  TRILAT_FIELDS(factor, first, total, break_even, bins)
};

// A part of the space: where one factor lies in a range of its own unit.
struct SpacePart {
  std::string name, factor;
  double low = kNoNumber, high = kNoNumber;

  TRILAT_FIELDS(name, factor, low, high)
};

// How a claim fares under one alignment, in one part of the space.
struct ClaimIn {
  std::string alignment, part;  // empty part: all of the space
  std::uint64_t compared = 0;   // points with a sample that both methods answer
  Estimate share = {};          // of these in which it holds
  Estimate difference_percent = {};
  double worst_percent = kNoNumber;
  Estimate default_percent = {};  // of the simulation as it is

  TRILAT_FIELDS(alignment, part, compared, share, difference_percent, worst_percent, default_percent)
};

// "This method errs less than all of those": the difference is its error over theirs on the samples that both
// answer, the largest of these ratios, that less the margin, minus 1; below 0 the claim holds. Means of
// differences are of logarithms of ratios, so that twice and half the error balance each other.
struct SensitivityClaim {
  std::string name, better;
  std::vector<std::string> than;
  double margin_percent = 0.0;
  std::uint64_t silent = 0;  // points of the space without a sample that both answer: in no figure here
  Estimate share = {};       // of the others in which it holds
  Estimate difference_percent = {};  // mean over the space
  double worst_percent = kNoNumber;  // the largest difference in the space
  Estimate default_percent = {};     // of the simulation as it is
  std::vector<ClaimByFactor> factors = {};
  std::vector<ClaimIn> side_by_side = {};  // all alignments, all parts; what is above is of the first

  TRILAT_FIELDS(name, better, than, margin_percent, silent, share, difference_percent, worst_percent,
                default_percent, factors, side_by_side)
};

struct SensitivitySlice {
  std::string name, x, y;           // the factors
  std::uint64_t steps = 0;          // of each
  std::vector<std::string> claims;  // that are drawn

  TRILAT_FIELDS(name, x, y, steps, claims)
};

struct SensitivitySummary {
  static constexpr StudyKind kKind = StudyKind::sensitivity;
  std::string study;
  std::vector<std::string> alignments;                 // claims are of the first unless they say otherwise
  std::uint64_t seed = 0, participants = 0, rows = 0;  // of the design: rows x (factors + 2) campaigns
  std::vector<std::string> methods;
  std::vector<SensitivityFactor> factors;
  std::vector<SpacePart> parts;
  std::vector<SensitivitySlice> slices;
  std::vector<SensitivityClaim> claims;
  std::vector<Estimate> best_share;  // by method: of the space in which it errs least
  std::vector<SensitivityPoint> points;

  double value_at(std::size_t factor, double position) const;  // in the factor's unit; number in a list
  std::string text_at(std::size_t factor, double position) const;

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study)
    field("simulated", true);
    TRILAT_EACH(alignments, seed, participants, rows, methods, factors, parts, slices, claims, best_share,
                points)
  }
  void check(const JsonObject& object) const;
};

// Simulated campaigns that have no errors.
inline std::size_t failed_points(const SensitivitySummary& summary) {
  return static_cast<std::size_t>(
      std::ranges::count_if(summary.points, [](const SensitivityPoint& p) { return !p.problem.empty(); }));
}

// Of the claim at a point under the alignment of that number; NaN when no sample is answered by both.
double difference_percent(const SensitivityClaim& claim, const std::vector<std::string>& methods,
                          const SensitivityPoint& point, std::size_t alignment = 0);

// summary.json (results format 1, kind sensitivity), and points.csv: a row a campaign and method with every
// factor's value.
void write_sensitivity_summary(const std::filesystem::path& folder, const SensitivitySummary& summary);
SensitivitySummary read_sensitivity_summary(const std::filesystem::path& folder);

}  // namespace trilat
