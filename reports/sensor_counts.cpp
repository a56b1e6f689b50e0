// SPDX-License-Identifier: MIT
#include "reports/sensor_counts.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include "reports/accuracy_words.h"
#include "reports/table_cells.h"

namespace trilat {
namespace {

struct Counted {
  std::string method;
  int sensors = 0;
  const SummaryCell* cell = nullptr;
};

// "nonlinear, 4 sensors" is nonlinear with 4.
std::optional<Counted> counted(const std::string& name) {
  constexpr std::string_view kEnd = " sensors";
  const auto comma = name.rfind(", ");
  if (comma == std::string::npos || !name.ends_with(kEnd)) return std::nullopt;
  Counted result{name.substr(0, comma), 0, nullptr};
  const char* from = name.data() + comma + 2;
  const char* to = name.data() + name.size() - kEnd.size();
  const auto [end, error] = std::from_chars(from, to, result.sensors);
  if (error != std::errc() || end != to) return std::nullopt;
  return result;
}

// All of them, or nothing when the study has methods of other names or only one number of sensors.
std::vector<Counted> counted_methods(const ResultsSummary& s, const std::string& condition,
                                     const std::string& alignment) {
  std::vector<Counted> all;
  for (const std::string& name : s.methods) {
    auto method = counted(name);
    if (!method) return {};
    method->cell = find_cell(s, name, condition, kAverageGroup, alignment);
    if (method->cell) all.push_back(*method);
  }
  const bool several =
      std::any_of(all.begin(), all.end(), [&](const Counted& c) { return c.sensors != all[0].sensors; });
  return several ? all : std::vector<Counted>{};
}

}  // namespace

std::vector<Table> sensor_counts_table(const ResultsSummary& s) {
  std::vector<Table> tables;
  for (const std::string& condition : s.conditions)
    for (const std::string& alignment : s.alignments) {
      const auto methods = counted_methods(s, condition, alignment);
      if (methods.empty()) continue;
      Table table;
      table.id = usable_id(fmt::format("sensors-{}-{}", condition, alignment));
      table.title = "Number of sensors: mean absolute error, average over the joint groups (" +
                    about(s, condition, alignment) + ")";
      table.columns = {{"method", "method", true},
                       {"sensors", "sensors", false, true},
                       {"MAE (cm)", "mae_cm"},
                       {"from", "mae_from_cm"},
                       {"to", "mae_to_cm"},
                       {"n", "n"},
                       {"coverage (%)", "coverage_percent"}};
      for (const Counted& m : methods)
        table.rows.push_back({TableValue::of(m.method), TableValue::of(m.sensors, 0), cm_cell(m.cell->mae_m),
                              cm_cell(m.cell->mae_low_m), cm_cell(m.cell->mae_high_m),
                              count_cell(m.cell->answered), percent_cell(m.cell->coverage())});
      table.notes = {interval_note(s)};
      tables.push_back(std::move(table));
    }
  return tables;
}

std::vector<Figure> sensor_counts_figure(const ResultsSummary& s) {
  std::vector<Figure> figures;
  const std::string alignment = s.alignments.empty() ? "" : s.alignments.front();
  for (const std::string& condition : s.conditions) {
    Figure figure;
    for (const Counted& m : counted_methods(s, condition, alignment)) {
      auto series = std::find_if(figure.series.begin(), figure.series.end(),
                                 [&](const FigureSeries& other) { return other.name == m.method; });
      if (series == figure.series.end())
        series = figure.series.insert(figure.series.end(),
                                      {m.method, FigureSeries::Style::line_and_dots, {}, {}, m.method});
      series->points.push_back({static_cast<double>(m.sensors), m.cell->mae_m * kCentimetresPerMetre,
                                m.cell->mae_low_m * kCentimetresPerMetre,
                                m.cell->mae_high_m * kCentimetresPerMetre});
    }
    if (figure.series.empty()) continue;
    figure.id = usable_id(fmt::format("sensors-{}", condition));
    figure.title =
        fmt::format("Number of sensors, {}, {}{}", s.campaign, condition, s.simulated ? ", simulated" : "");
    figure.caption = fmt::format(
        "{}Mean absolute error with its interval, average over the joint groups, alignment {}; the table has "
        "how "
        "many samples each method answers.",
        s.simulated ? "Simulated. " : "", alignment);
    figure.x_label = "sensors";
    figure.y_label = "mean absolute error (cm)";
    figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace trilat
