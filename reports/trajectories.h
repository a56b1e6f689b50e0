// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "datasets/results/summary.h"
#include "reports/figure.h"

namespace trilat {

// Heights of single joints over time, as in the paper's figures: for the first evaluated take of each
// condition one figure with the truth and a few methods, of the right wrist, elbow or ankle (the paper's
// joints when walking, swinging arms and crossing legs), or of the first joint where none of them was
// measured. The first seconds only; NaN where something is missing. Methods are shown as movement about their
// mean over the take.
std::vector<Figure> trajectory_figures(const std::filesystem::path& results, const ResultsSummary& summary);

}  // namespace trilat
