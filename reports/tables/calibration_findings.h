// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/studies/calibration_summary.h"

namespace trilat {

// The ways to find the wand that figures and bins show.
inline constexpr std::array kMainWandMethods{"ours", "corrected", "corrected by the mid-range"};

// The first row of that name; null without one.
const WandRow* wand_row(const CalibrationSummary& summary, const std::string& method,
                        const std::string& scene);
const RigRow* rig_row(const CalibrationSummary& summary, const std::string& method);

// Rows of `method` with sensors that are off by an assumed sigma, the smallest first. Rows of calibrations
// that were found are not among them.
std::vector<EffectRow> assumed_effects(const CalibrationSummary& summary, const std::string& method);

// Means over the columns that had a depth: the two outer parts, where the paper finds more error, and
// between.
struct ColumnMeans {
  double left = ErrorSpread::kNone, middle = ErrorSpread::kNone, right = ErrorSpread::kNone;
  double edge = ErrorSpread::kNone;  // of all columns of both outer parts

  double edge_to_middle() const { return edge / middle; }  // NaN without a middle
};
ColumnMeans column_means(const std::vector<double>& by_column);

// The sensor sigma at which the RMSE of `nonlinear` is `factor` times that of exact sensors: squares are
// interpolated between the listed sigmas, because variances add. None when no listed sigma is that bad.
std::optional<double> sensor_sigma_m_at(const CalibrationSummary& summary, double factor);

// "1.17 cm (95 % interval 0.68 to 1.69 cm)"; says so when there is no answer or no interval.
std::string mean_text(const ErrorSpread& spread);

// What one can take away: the paper's claim, what the study got, why they differ. One sentence or two each;
// none about a part that was not run.
std::vector<std::string> calibration_sentences(const CalibrationSummary& summary);

// What one error of the paper alone does to finding the wand, one sentence an erratum.
std::vector<std::string> wand_errata_sentences(const CalibrationSummary& summary);
// Where nonlinear joints are a tenth worse than with exact sensors; empty without rows.
std::string effect_sentence(const CalibrationSummary& summary);

}  // namespace trilat
