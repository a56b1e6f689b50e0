// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/figures/figures.h"
#include "reports/tables/table.h"

namespace trilat {
namespace {

// Shares down to this many percent are seen; nothing is drawn of a range without any.
constexpr double kLeastPercent = 1e-4;

FigureSeries bars_of(const std::string& name, const std::vector<double>& percent, std::size_t place,
                     std::size_t places) {
  const double width = 0.8 / static_cast<double>(places);
  FigureSeries series{name, FigureSeries::Style::bars, {}, {}, place == 0 ? name : "", 0.9 * width};
  for (std::size_t b = 0; b < percent.size(); ++b)
    if (percent[b] > 0.0)
      series.points.push_back({static_cast<double>(b) + (static_cast<double>(place) + 0.5) * width - 0.4,
                               percent[b], kLeastPercent, std::max(percent[b], kLeastPercent)});
  return series;
}

std::vector<double> paper_percent() {
  const PrintedTable4 paper = printed_table4();
  std::uint64_t total = 0;
  for (const PrintedTable4::Row& row : paper.rows) total += row.clock_samples;
  std::vector<double> percent;
  for (auto row = paper.rows.rbegin(); row != paper.rows.rend(); ++row)
    percent.push_back(100.0 * share_of(row->clock_samples, total));
  return percent;
}

std::vector<double> percent_of(const TimeSpread& error) {
  std::vector<double> percent;
  for (std::uint64_t count : error.bins) percent.push_back(100.0 * share_of(count, error.n));
  return percent;
}

Figure histogram(const RecordingSummary& s, const std::string& network) {
  Figure figure;
  figure.id = usable_id("clocks-" + network);
  figure.title = fmt::format("Table IV: clock errors, {} (simulated)", network);
  figure.caption = fmt::format(
      "Simulated: {} frames x {} sensors x {} runs, seed {}; the paper's: its own samples. Shares below {:g} "
      "% "
      "cannot be seen.",
      s.frames, s.sensors, s.runs, s.seed, kLeastPercent);
  figure.x_label = "error of the clock (ms)";
  figure.y_label = "share of the frames (%)";
  figure.log_y = true;
  figure.x_names = {"0 to 2", "2 to 4", "4 to 11", "11 to 22", "22 to 33", "33 on"};
  std::vector<const ClockErrorRow*> rows;
  for (const ClockErrorRow& row : s.clocks)
    if (row.network == network && row.error.n > 0) rows.push_back(&row);
  figure.series.push_back(bars_of("the paper's", paper_percent(), 0, rows.size() + 1));
  for (std::size_t k = 0; k < rows.size(); ++k)
    figure.series.push_back(bars_of(rows[k]->method, percent_of(rows[k]->error), k + 1, rows.size() + 1));
  return figure;
}

}  // namespace

std::vector<Figure> clock_figures(const RecordingSummary& s) {
  std::vector<std::string> networks;
  for (const ClockErrorRow& row : s.clocks)
    if (std::find(networks.begin(), networks.end(), row.network) == networks.end())
      networks.push_back(row.network);
  std::vector<Figure> figures;
  for (const std::string& network : networks) figures.push_back(histogram(s, network));
  return figures;
}

}  // namespace trilat
