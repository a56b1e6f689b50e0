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

// Mean error by night, with the nights whose change was accepted; nothing without nights. And the last one's
// verdict in words.
std::optional<Figure> history_figure(const std::vector<Night>& history);
std::vector<std::string> history_sentences(const std::vector<Night>& history);

// Heights of single joints over time, as in the paper's figures: for the first evaluated take of each
// condition one figure with the truth and a few methods, of the right wrist, elbow or ankle (the paper's
// joints when walking, swinging arms and crossing legs), or of the first joint where none of them was
// measured. The first seconds only; NaN where something is missing. Methods are shown as movement about their
// mean over the take.
std::vector<Figure> trajectory_figures(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
