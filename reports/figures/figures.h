// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/results/figure.h"
#include "datasets/results/gate_history.h"
#include "datasets/results/summary.h"

namespace trilat {

// The leading methods' mean errors with intervals, a panel a joint group, the least error on top;
// `with_paper`: the paper's Table III as rings.
Figure methods_figure(const ResultsSummary& summary, const std::string& condition, bool with_paper);

// Mean error by night, with the nights whose change was accepted; nothing without nights. And the last one's
// verdict in words.
std::optional<Figure> history_figure(const History& history);
std::vector<std::string> history_sentences(const History& history);

// Families named "METHOD, N sensors": error against N.
std::vector<Figure> sensor_counts_figure(const ResultsSummary& summary);

// Heights of single joints over time, as in the paper's figures: for the first evaluated take of each
// condition one figure with the truth and a few methods, of the right wrist, elbow or ankle (the paper's
// joints when walking, swinging arms and crossing legs), or of the first joint where none of them was
// measured. The first seconds only; NaN where something is missing. Methods are shown as movement about their
// mean over the take.
std::vector<Figure> trajectory_figures(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
