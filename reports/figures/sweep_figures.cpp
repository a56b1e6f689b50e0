// SPDX-License-Identifier: MIT
#include <functional>

#include <fmt/format.h>

#include "datasets/base/units.h"
#include "reports/figures/figures.h"
#include "reports/tables/table1.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr const char* kPaper = "the paper's";

using NumberOf = std::function<double(std::size_t threshold, std::size_t range)>;

// One line an error range; they share a look, since they lie in the order of the ranges.
void add_lines(Figure& figure, const std::string& group, const PrintedTable1& paper, const NumberOf& number) {
  for (std::size_t r = 0; r < paper.ranges_cm.size(); ++r) {
    FigureSeries series{fmt::format("{}, {:g}-{:g} cm", group, paper.ranges_cm[r][0], paper.ranges_cm[r][1]),
                        FigureSeries::Style::line_and_dots,
                        {},
                        group,
                        group};
    for (std::size_t t = 0; t < paper.rows.size(); ++t)
      series.points.push_back({paper.rows[t].threshold, number(t, r)});
    figure.series.push_back(std::move(series));
  }
}

Figure empty_figure(const SweepSummary& s, const Table1Readings& readings, const char* what,
                    std::size_t number) {
  Figure figure;
  figure.id = fmt::format("figure_table1_{}{}", what, number == 0 ? "" : fmt::format("-{}", number + 1));
  figure.caption = fmt::format(
      "Simulated ({}; {} trials a point, seed {}). One line for each range of errors; they lie in the order "
      "of the "
      "ranges, the largest errors on top. Printed: eq. 17 as it stands (E7). Both stop when the change of F "
      "is "
      "below C.",
      readings.name, s.trials, s.seed);
  figure.x_label =
      fmt::format("stopping threshold C ({})", s.interpretations[*readings.printed].threshold_unit);
  figure.log_x = true;
  figure.log_y = true;
  return figure;
}

// Of one reading; NaN where nothing answered.
NumberOf of_cells(const SweepSummary& s, std::size_t reading,
                  const std::function<double(const SweepCell&)>& get) {
  return [&s, reading, get](std::size_t t, std::size_t r) { return get(s.cell(reading, t, r)); };
}

Figure error_figure(const SweepSummary& s, const Table1Readings& readings, const PrintedTable1& paper,
                    std::size_t number) {
  Figure figure = empty_figure(s, readings, "error", number);
  figure.title = fmt::format("Table I: error over the threshold, {} (simulated)",
                             s.interpretations[*readings.printed].rig);
  figure.y_label =
      readings.axis_mean ? "mean absolute error of an axis (cm)" : "mean distance to the joint (cm)";
  figure.log_y = false;
  const auto error_cm = [axis_mean = readings.axis_mean](const SweepCell& c) {
    return kCentimetresPerMetre * (axis_mean ? c.axis_mean_mae_m() : c.mae_m);
  };
  add_lines(figure, kPaper, paper, [&](std::size_t t, std::size_t r) { return paper.rows[t].error_cm[r]; });
  add_lines(figure, "printed gradient", paper, of_cells(s, *readings.printed, error_cm));
  add_lines(figure, "corrected gradient", paper, of_cells(s, *readings.corrected, error_cm));
  return figure;
}

Figure steps_figure(const SweepSummary& s, const Table1Readings& readings, const PrintedTable1& paper,
                    std::size_t number) {
  Figure figure = empty_figure(s, readings, "steps", number);
  figure.title = fmt::format("Table I: what a threshold costs, {} (simulated)",
                             s.interpretations[*readings.printed].rig);
  figure.y_label = "mean number of steps";
  const auto steps = [](const SweepCell& c) { return c.mean_iterations; };
  add_lines(figure, "printed gradient", paper, of_cells(s, *readings.printed, steps));
  add_lines(figure, "corrected gradient", paper, of_cells(s, *readings.corrected, steps));
  return figure;
}

NumberOf time_us(const SweepSummary& s, const std::optional<SweepTimings>& timings, std::size_t reading) {
  return [&s, &timings, reading](std::size_t t, std::size_t r) {
    const SweepCellTiming* time = timing_of(timings, s.cell(reading, t, r));
    return time ? time->scalar_median_ns / kNsPerMicrosecond : SweepCell::kNone;
  };
}

std::optional<Figure> time_figure(const SweepSummary& s, const std::optional<SweepTimings>& timings,
                                  const Table1Readings& readings, const PrintedTable1& paper,
                                  std::size_t number) {
  if (!timings || !timing_of(timings, s.cell(*readings.printed, 0, 0))) return std::nullopt;
  Figure figure = empty_figure(s, readings, "time", number);
  figure.title = fmt::format("Table I: time of one solve, {}", s.interpretations[*readings.printed].rig);
  figure.caption +=
      " Times are measured, ours on another machine than the paper's; where the paper prints a bound "
      "(below 0.1 us) there is no point.";
  figure.y_label = "time of a solve (us)";
  add_lines(figure, kPaper, paper, [&](std::size_t t, std::size_t r) {
    return paper.rows[t].time_is_below ? SweepCell::kNone : paper.rows[t].time_us[r];
  });
  add_lines(figure, "printed gradient", paper, time_us(s, timings, *readings.printed));
  add_lines(figure, "corrected gradient", paper, time_us(s, timings, *readings.corrected));
  return figure;
}

}  // namespace

std::vector<Figure> sweep_figures(const SweepSummary& s, const std::optional<SweepTimings>& timings) {
  const PrintedTable1 paper = printed_table1();
  std::vector<Figure> figures;
  std::size_t number = 0;
  for (const Table1Readings& readings : table1_readings(s, paper)) {
    figures.push_back(error_figure(s, readings, paper, number));
    figures.push_back(steps_figure(s, readings, paper, number));
    if (auto time = time_figure(s, timings, readings, paper, number)) figures.push_back(std::move(*time));
    ++number;
  }
  return figures;
}

}  // namespace trilat
