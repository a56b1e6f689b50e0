// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/calibration_study/calibration_summary.h"

namespace trilat {

// The ways to find the wand that figures and bins show.
inline constexpr std::array kMainWandMethods{"ours", "corrected", "corrected by the mid-range"};

// The first row of that name; null without one.
const WandRow* wand_row(const CalibrationSummary& summary, const std::string& method,
                        const std::string& scene);
const RigRow* rig_row(const CalibrationSummary& summary, const std::string& method);

// Means over the columns that had a depth: the two outer parts, where the paper finds more error, and
// between.
struct ColumnMeans {
  double left = ErrorSpread::kNone, middle = ErrorSpread::kNone, right = ErrorSpread::kNone;
  double edge = ErrorSpread::kNone;  // of all columns of both outer parts

  double edge_to_middle() const { return edge / middle; }  // NaN without a middle
};
ColumnMeans column_means(const std::vector<double>& by_column);

// "1.17 cm (95 % interval 0.68 to 1.69 cm)"; says so when there is no answer or no interval.
std::string mean_text(const ErrorSpread& spread);

// Findings: the paper's claim, what the study got, why they differ. One sentence or two each;
// none about a part that was not run.
std::vector<std::string> calibration_sentences(const CalibrationSummary& summary);

// Effect of one error of the paper alone on finding the wand.
struct WandErratum {
  std::string id;       // "E1"
  std::string problem;  // "E1: eq. 3 as printed stops when …"
  std::string effect;   // "inside the recommended range, …"
};
std::vector<WandErratum> wand_errata(const CalibrationSummary& summary);

}  // namespace trilat
