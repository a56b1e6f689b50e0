// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/studies/calibration_summary.h"
#include "datasets/results/studies/sweep_summary.h"
#include "datasets/results/studies/timings.h"
#include "datasets/results/summary.h"

namespace trilat {

// The leading methods' mean errors with intervals, a panel a joint group, the least error on top;
// `with_paper`: the paper's Table III as rings.
Figure methods_figure(const ResultsSummary& summary, const std::string& condition, bool with_paper);

// Mean error by night, with the nights whose change was accepted; nothing without nights. And the last one's
// verdict in words.
std::optional<Figure> history_figure(const History& history);
std::vector<std::string> history_sentences(const History& history);

// The paper's two calibration figures, from simulated samples: error against distance and angle, and depth
// error against image column. Each needs its part of the study.
std::vector<Figure> calibration_figures(const CalibrationSummary& summary);

// Families named "METHOD, N sensors": error against N.
std::vector<Figure> sensor_counts_figure(const ResultsSummary& summary);

// Error, steps, share of answers and, where it was measured, time over the threshold C: a panel for each rig,
// error model and range of errors, a line for each other choice. With the paper's grid its Table I stands
// beside.
std::vector<Figure> sweep_figures(const SweepSummary& summary, const std::optional<SweepTimings>& timings);

// Heights of single joints over time, as in the paper's figures: for the first evaluated take of each
// condition one figure with the truth and a few methods, of the right wrist, elbow or ankle (the paper's
// joints when walking, swinging arms and crossing legs), or of the first joint where none of them was
// measured. The first seconds only; NaN where something is missing. Methods are shown as movement about their
// mean over the take.
std::vector<Figure> trajectory_figures(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
