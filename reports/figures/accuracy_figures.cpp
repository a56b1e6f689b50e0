// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/table.h"
#include "reports/figures/figures.h"
#include "reports/tables/accuracy_words.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

// From head to foot; what is named otherwise comes behind.
constexpr std::array<std::string_view, 7> kFromHeadToFoot{"head", "shoulder", "elbow", "wrist",
                                                          "hip",  "knee",     "ankle"};

// As many as a figure has panels: from head to foot, and the average of all.
std::vector<std::string> first_groups(std::vector<std::string> groups) {
  constexpr std::size_t kMostPanels = 6;
  if (groups.size() <= kMostPanels) return groups;
  const bool has_average = groups.back() == kAverageGroup;
  if (has_average) groups.pop_back();
  std::ranges::stable_sort(groups, {}, [](const std::string& group) {
    return std::ranges::find(kFromHeadToFoot, std::string_view(group)) - kFromHeadToFoot.begin();
  });
  groups.resize(kMostPanels - has_average);
  if (has_average) groups.emplace_back(kAverageGroup);
  return groups;
}

}  // namespace

Figure methods_figure(const ResultsSummary& s, const std::string& condition, bool with_paper) {
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
  const std::vector<std::string> all = groups_in(s, condition), groups = first_groups(all);
  if (groups.size() < all.size())
    figure.caption += fmt::format(" {} of {} joint groups; the tables have all.", groups.size(), all.size());
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
