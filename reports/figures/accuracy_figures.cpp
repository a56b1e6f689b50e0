// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
Figure methods_figure(const ResultsSummary& s, const std::string& condition, bool with_paper) {
  constexpr std::size_t kMostPanels = 6;
  const std::string& alignment = s.alignments.front();
  Figure figure;
  figure.id = usable_id("errors-" + (condition.empty() ? "all" : condition));
  figure.title =
      fmt::format("Mean error by method and joint{}", with_paper ? ", the paper's beside ours" : "");
  figure.caption = fmt::format("{} {}, {} participant{}: mean error with its 95 % interval, alignment {}{}.",
                               s.simulated ? "Simulated" : "Recorded", condition, s.participants,
                               s.participants == 1 ? "" : "s", alignment,
                               with_paper ? "; rings: what the paper prints" : "");
  figure.x_label = "mean error (cm)";
  figure.y_names = leading_methods(s, condition);
  std::vector<std::string> groups = groups_in(s, condition);
  if (groups.size() > kMostPanels) groups.erase(groups.begin(), groups.end() - kMostPanels);
  const std::string origin = s.simulated ? "ours, simulated" : "recorded";
  for (std::size_t g = 0; g < groups.size(); ++g) {
    FigureSeries ours{origin, FigureSeries::Style::dots, {}, {}, "nonlinear"},
        paper{"the paper", FigureSeries::Style::dots, {}, {}, "truth"};
    ours.panel = paper.panel = g;
    paper.hollow = true;
    for (std::size_t m = 0; m < figure.y_names.size(); ++m) {
      const auto y = static_cast<double>(m);
      if (const SummaryCell* c = find_cell(s, figure.y_names[m], condition, groups[g], alignment))
        ours.points.push_back({c->mae_m * kCentimetresPerMetre, y, c->mae_low_m * kCentimetresPerMetre,
                               c->mae_high_m * kCentimetresPerMetre});
      if (const double printed_cm = printed_table3_cm(s, condition, groups[g], figure.y_names[m]);
          with_paper && std::isfinite(printed_cm))
        paper.points.push_back({printed_cm, y});
    }
    figure.series.push_back(std::move(ours));
    if (!paper.points.empty()) figure.series.push_back(std::move(paper));
    figure.panels.push_back(groups[g]);
  }
  return figure;
}

}  // namespace trilat
