// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/figures/figures.h"
#include "reports/tables/table.h"

namespace trilat {
namespace {

constexpr double kMostPercent = 60.0;  // of the colours

std::string axis_label(const SensitivityFactor& f) {
  return f.unit.empty() ? f.name : fmt::format("{} ({})", f.name, f.unit);
}

std::size_t index_of_factor(const SensitivitySummary& s, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(s.factors, name, &SensitivityFactor::name) -
                                  s.factors.begin());
}

Figure slice_figure(const SensitivitySummary& s, const SensitivitySlice& slice,
                    const SensitivityClaim& claim) {
  const std::size_t fx = index_of_factor(s, slice.x), fy = index_of_factor(s, slice.y);
  Figure figure;
  figure.id = usable_id(fmt::format("slice-{}-{}", slice.name, claim.name));
  figure.title = fmt::format("{} (simulated)", claim.name);
  figure.caption = fmt::format(
      "Simulated, {} participant{} a point; everything else as the simulation has it. Colours: error of {} "
      "over that of the methods it is held against, on common samples{}; below 0 the claim holds.",
      s.participants, s.participants == 1 ? "" : "s", claim.better,
      claim.margin_percent == 0.0 ? std::string() : fmt::format(", less {:g} %", claim.margin_percent));
  figure.x_label = axis_label(s.factors[fx]);
  figure.y_label = axis_label(s.factors[fy]);
  FigureMap map{{}, {}, {}, "difference (%)", -kMostPercent, kMostPercent};
  for (std::size_t k = 0; k < slice.steps; ++k) {
    const double middle = (static_cast<double>(k) + 0.5) / static_cast<double>(slice.steps);
    map.x.push_back(static_cast<double>(k));
    map.y.push_back(s.value_at(fy, middle));
    figure.x_names.push_back(s.factors[fx].values.empty() ? fmt::format("{:.2g}", s.value_at(fx, middle))
                                                          : s.text_at(fx, middle));
  }
  for (const SensitivityPoint& point : s.points)
    if (point.design == slice.name) map.values.push_back(difference_percent(claim, s.methods, point));
  figure.width = FigureWidth::column;
  figure.map = std::move(map);
  return figure;
}

// Every factor's mean difference over its range.
Figure factors_figure(const SensitivityClaim& claim) {
  Figure figure;
  figure.id = usable_id("factors-" + claim.name);
  figure.title = fmt::format("{}, by factor (simulated)", claim.name);
  figure.caption =
      "Simulated: mean difference over the whole space but for one factor, with 95 % intervals. Below the "
      "line the claim holds on average.";
  figure.x_label = "position in the factor's range (0: its low end, 1: its high end)";
  figure.y_label = "difference (%)";
  figure.lines.push_back({0.0, "equal"});
  std::vector<const ClaimByFactor*> factors;
  for (const ClaimByFactor& by : claim.factors) factors.push_back(&by);
  std::ranges::sort(factors, [](const auto* a, const auto* b) { return a->total.value > b->total.value; });
  constexpr std::size_t kMost = 5;  // lines that can be told apart
  for (const ClaimByFactor* by : factors) {
    if (figure.series.size() == kMost) break;
    FigureSeries series{by->factor, FigureSeries::Style::line_and_dots, {}};
    for (const ClaimByFactor::Bin& bin : by->bins)
      series.points.push_back({bin.position, bin.difference_percent.value, bin.difference_percent.low,
                               bin.difference_percent.high});
    figure.series.push_back(std::move(series));
  }
  return figure;
}

}  // namespace

std::vector<Figure> sensitivity_figures(const SensitivitySummary& s) {
  std::vector<Figure> figures;
  for (const SensitivitySlice& slice : s.slices)
    for (const SensitivityClaim& claim : s.claims)
      if (std::ranges::find(slice.claims, claim.name) != slice.claims.end())
        figures.push_back(slice_figure(s, slice, claim));
  for (const SensitivityClaim& claim : s.claims) figures.push_back(factors_figure(claim));
  return figures;
}

}  // namespace trilat
