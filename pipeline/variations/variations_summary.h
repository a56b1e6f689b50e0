// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "datasets/base/described.h"
#include "datasets/results/results_file.h"
#include "datasets/results/summary.h"

namespace trilat {

// A setting of the simulation that is varied: in a range, or over a list.
struct VariedRange {
  std::string name, unit;
  std::string setting;                   // JSON pointer into simulation.json
  std::vector<std::string> values = {};  // of a list, as text; empty: a range
  double low = kNoNumber, high = kNoNumber;
  bool logarithmic = false, whole = false;  // whole numbers only

  double value_at(double position) const;  // in its unit; the number in the list
  std::string text_at(double position) const;

  TRILAT_FIELDS(name, unit, setting, values, low, high, logarithmic, whole)
};

// One simulated campaign and the methods' errors in it. All are the means of the joint groups.
struct VariationPoint {
  std::string name;              // of the patch; empty in a study of ranges
  std::vector<double> position;  // by range, 0 to 1
  // The mean error of each method (row) over the samples that each other one (column) answers too, both
  // aligned on these; of a method with itself over all its answers; NaN: no such samples. One such table
  // behind the other for each alignment.
  std::vector<double> paired_m = {};
  std::vector<double> answered = {};  // by method, share
  // By method the mean errors of each participant under the first alignment, in the order of their names.
  std::vector<std::vector<double>> person_m = {};
  std::string problem = {};  // why there are no errors; empty when there are

  TRILAT_FIELDS(name, position, paired_m, answered, person_m, problem)
};

// First-order index of a range: its share of the variance of the logarithm of the ratio.
struct DecidingRange {
  std::string range;
  Estimate first_order = {};

  TRILAT_FIELDS(range, first_order)
};

// How a comparison fares over the points of the ranges, under one alignment.
struct ComparisonShare {
  std::string alignment;
  std::uint64_t compared = 0;        // points with a sample that both methods answer
  Estimate share = {};               // of these in which it holds; Clopper and Pearson
  Estimate difference_percent = {};  // geometric mean of the ratio, less 1; Student's t between points
  double worst_percent = kNoNumber;
  std::vector<DecidingRange> decided_by = {};

  TRILAT_FIELDS(alignment, compared, share, difference_percent, worst_percent, decided_by)
};

// "This method errs less than all of those": holds where its error over theirs, on the samples that both
// answer, the largest of these ratios, is less than 1 and the margin.
struct MethodComparison {
  std::string name, better;
  std::vector<std::string> than;
  double margin_percent = 0.0;
  std::vector<ComparisonShare> by_alignment = {};

  // At a point, under the alignment of that number; below 0 it holds. NaN without a common sample.
  double difference_percent(const std::vector<std::string>& methods, const VariationPoint& point,
                            std::size_t alignment) const;

  TRILAT_FIELDS(name, better, than, margin_percent, by_alignment)
};

// Share of the points in which a method errs less than every other.
struct BestShare {
  std::string method;
  Estimate share;

  TRILAT_FIELDS(method, share)
};

// summary.json of a study of kind "variations". All of it is simulated.
struct VariationsSummary {
  static constexpr StudyKind kKind = StudyKind::variations;
  std::string study;
  std::vector<std::string> alignments;
  std::uint64_t seed = 0, participants = 0;  // of each campaign
  std::vector<std::string> methods;
  std::vector<VariedRange> ranges;  // of a study of ranges
  std::vector<MethodComparison> comparisons;
  std::vector<BestShare> best;
  std::vector<VariationPoint> points;
  std::vector<std::string> sentences;  // what the study says; **bold** and `code` as in Markdown

  std::uint64_t failed() const {
    return static_cast<std::uint64_t>(
        std::ranges::count_if(points, [](const VariationPoint& p) { return !p.problem.empty(); }));
  }

  static void fields(auto& self, auto&& field) {
    TRILAT_EACH(study)
    field("simulated", true);
    TRILAT_EACH(alignments, seed, participants, methods, ranges, comparisons, best, points, sentences)
  }
  void check(const JsonObject& object) const;
};

}  // namespace trilat
