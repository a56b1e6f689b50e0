// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <numeric>

#include <fmt/format.h>

#include "datasets/base/words.h"
#include "datasets/paper/printed_tables.h"
#include "pipeline/clocks/clocks_study.h"

namespace trilat {
namespace {

constexpr const char* kPaperRow = "the paper's";
constexpr double kMsPerS = 1e3;
constexpr const char* kCausal = "corrected, causal";

using Row = NumberKey;

TableValue share_cell(std::uint64_t part, std::uint64_t whole) {
  return TableValue::of(100.0 * share_of(part, whole), 2);
}

// Each computer's clock, as its numbers have it: take and sensor.
std::vector<Row> computers(const ClocksSummary& s) {
  std::vector<Row> rows;
  for (const Number& number : s.numbers.all())
    if (number.measure == "clock_fit" && number.statistic == "share_used")
      rows.push_back({.group = number.group, .take = number.take});
  return rows;
}

// Subject of the tables.
std::string about(const ClocksSummary& s) {
  return fmt::format("{}{}, computers of {} ({})", s.simulated ? "simulated, " : "",
                     counted(s.recordings, "recording"), counted(computers(s).size(), "sensor"), s.campaign);
}

// Rows of all computers together that have a number of that measure and statistic.
std::vector<Row> rows_with(const ClocksSummary& s, const char* measure, const char* statistic) {
  std::vector<Row> rows;
  for (const Number& number : s.numbers.all())
    if (number.measure == measure && number.statistic == statistic && number.take.empty())
      rows.push_back({.condition = number.condition, .method = number.method});
  return rows;
}

// The paper's samples by clock error, or its frames by processing time, in each of kTimeRanges.
std::array<std::uint64_t, kTimeRanges.size()> printed_counts(std::uint64_t PrintedTable4::Row::*count) {
  const PrintedTable4 paper = printed_table4();
  std::array<std::uint64_t, kTimeRanges.size()> counts{};
  for (std::size_t r = 0; r < counts.size(); ++r) counts[r] = paper.rows[counts.size() - 1 - r].*count;
  return counts;
}

Table queue_table(const ClocksSummary& s) {
  const auto share = [](const char* statistic) {
    return NumberKey{.measure = "queue", .statistic = statistic};
  };
  Table table = table_of<Row>("queue",
                              fmt::format("Table IV, frames in real time: {}, limit of the queue {:.1f} ms",
                                          about(s), s.late_s * kMsPerS),
                              rows_with(s, "queue", "taken"),
                              {{"method", "method", as_text(&Row::method)},
                               {"the server takes frames", "server", as_text(&Row::condition)},
                               {"frames", "frames", count_of(s.numbers, share("came"))},
                               {"without a time", "untimed", count_of(s.numbers, share("untimed"))},
                               {"too early", "too_early", count_of(s.numbers, share("too_early"))},
                               {"too late", "too_late", count_of(s.numbers, share("too_late"))},
                               {"taken (%)", "taken_percent", interval_of(s.numbers, share("taken"))}});
  const PrintedTable4 paper = printed_table4();
  const TableValue papers = TableValue::of(kPaperRow);
  table.rows.insert(
      table.rows.begin(),
      row_by_key(table, {{"method", papers},
                         {"server", papers},
                         {"frames", count_cell(paper.frames)},
                         {"too_late", count_cell(paper.lost_frames)},
                         {"taken_percent", share_cell(paper.frames - paper.lost_frames, paper.frames)}}));
  add_notes(table, "queue");
  return table;
}

Table errors_table(const ClocksSummary& s) {
  const auto number = [&](const char* statistic, int decimals) {
    return value_of(s.numbers, {.measure = "clock_error", .statistic = statistic}, decimals);
  };
  std::vector<RowColumn<Row>> columns{
      {"method", "method", as_text(&Row::method)},
      {"samples", "samples", count_of(s.numbers, {.measure = "clock_error", .statistic = "median"})},
      {"(0,2) ms (%)", "below_2ms_percent",
       interval_of(s.numbers, {.measure = "clock_error", .statistic = kTimeRanges[0].share})}};
  constexpr std::array kHeads{"[2,4) (%)", "[4,11) (%)", "[11,22) (%)", "[22,33) (%)", "33 ms on (%)"};
  const auto key_of = [](std::size_t range) {
    return std::string(kTimeRanges[range].share).substr(std::string("share_").size()) + "_percent";
  };
  for (std::size_t r = 1; r < kTimeRanges.size(); ++r)
    columns.push_back({kHeads[r - 1], key_of(r), number(kTimeRanges[r].share, 2)});
  const std::vector<RowColumn<Row>> more{{"below 4 ms (%)", "below_4ms_percent", number(kShareBelow4ms, 2)},
                                         {"sensors' recordings wholly below 4 ms (%)",
                                          "units_below_4ms_percent", number("share_of_units_below_4ms", 2)},
                                         {"median (ms)", "median_ms", number("median", 3)},
                                         {"p95 (ms)", "p95_ms", number("p95", 3)},
                                         {"p99 (ms)", "p99_ms", number("p99", 3)},
                                         {"p99.9 (ms)", "p999_ms", number("p999", 3)},
                                         {"max (ms)", "max_ms", number("max", 3)}};
  columns.insert(columns.end(), more.begin(), more.end());
  Table table = table_of<Row>("clocks", "Table IV, clock errors: " + about(s),
                              rows_with(s, "clock_error", "median"), columns);
  const auto printed = printed_counts(&PrintedTable4::Row::clock_samples);
  const std::uint64_t total = std::accumulate(printed.begin(), printed.end(), std::uint64_t{0});
  std::vector<TableValue> papers =
      row_by_key(table, {{"method", TableValue::of(kPaperRow)},
                         {"samples", count_cell(total)},
                         {"below_4ms_percent", share_cell(printed[0] + printed[1], total)}});
  for (std::size_t r = 0; r < printed.size(); ++r) papers.at(2 + r) = share_cell(printed[r], total);
  table.rows.insert(table.rows.begin(), papers);
  const PrintedTable4 paper = printed_table4();
  add_notes(table, "clock_errors",
            {{"good", std::to_string(printed[0])},
             {"total", std::to_string(total)},
             {"percent", fmt::format("{:.2f}", 100.0 * share_of(printed[0], total))},
             {"printed", fmt::format("{:g}", paper.below_2ms_percent)},
             {"wanted", std::to_string(paper.frames * paper.clients)}});
  return table;
}

Table machines_table(const ClocksSummary& s) {
  const auto fit = [&](const char* statistic, int decimals) {
    return value_of(s.numbers, {.measure = "clock_fit", .statistic = statistic}, decimals);
  };
  const auto latency = [&](const char* statistic) {
    return value_of(s.numbers, {.measure = "latency", .statistic = statistic}, 1);
  };
  const NumberKey exchanges{.measure = "clock_fit", .statistic = "share_used"};
  const NumberKey frames{.method = "none", .measure = "clock_error", .statistic = kShareBelow4ms};
  Table table =
      table_of<Row>("machines", "Each computer's clock and the way of its frames: " + about(s), computers(s),
                    {{"take", "take", as_text(&Row::take)},
                     {"sensor", "sensor", as_text(&Row::group)},
                     {"exchanges", "exchanges", count_of(s.numbers, exchanges)},
                     {"used (%)", "exchanges_used_percent", fit("share_used", 1)},
                     {"standard deviation (ms)", "offset_sigma_ms", fit("sigma", 3)},
                     {"bound of unlike delays (ms)", "offset_bound_ms", fit("bound", 3)},
                     {"off the line (ms)", "bend_ms", fit("bend", 3)},
                     {"frames within both (%)", "within_bound_percent", fit("share_within_bound", 1)},
                     {"frames", "frames", count_of(s.numbers, frames)},
                     {"from exposure, median (ms)", "latency_median_ms", latency("median")},
                     {"p99 (ms)", "latency_p99_ms", latency("p99")},
                     {fmt::format("within {:.1f} ms (%)", s.late_s * kMsPerS), "in_time_percent",
                      latency("share_in_time")}});
  add_notes(table, "machines");
  constexpr std::size_t kShown = 8;
  table.first_rows = std::min(table.rows.size(), kShown);
  return table;
}

// The paper's alone.
Table processing_table() {
  using Counts = std::array<std::uint64_t, kTimeRanges.size()>;
  const auto count = [](std::size_t first, std::size_t last) {
    return [=](const Counts& c) { return std::accumulate(&c[first], &c[last] + 1, std::uint64_t{0}); };
  };
  const auto all = count(0, kTimeRanges.size() - 1);
  const auto share = [&](std::size_t first, std::size_t last) {
    return CellOf{[=](const Counts& c) { return share_cell(count(first, last)(c), all(c)); }};
  };
  Table table =
      table_of<Counts>("processing", "Table IV, processing time of a frame, as the paper prints it",
                       {printed_counts(&PrintedTable4::Row::frames)},
                       {{"stage", "stage", as_text([](const Counts&) { return "depth image to joints"; })},
                        {"frames", "frames", as_count(all)},
                        {"(0,11) ms (%)", "below_11ms_percent", share(0, 2)},
                        {"[11,22) (%)", "from_11_to_22ms_percent", share(3, 3)},
                        {"[22,33) (%)", "from_22_to_33ms_percent", share(4, 4)},
                        {"33 ms on (%)", "from_33ms_percent", share(5, 5)}});
  add_notes(table, "processing");
  return table;
}

// Absolute error of a method's clocks, in milliseconds; NaN without the method.
double error_ms(const ClocksSummary& s, const char* method, const char* statistic) {
  return kMsPerS * s.numbers.value({.method = method, .measure = "clock_error", .statistic = statistic});
}

// E11.
std::string clock_effect(const ClocksSummary& s) {
  return fmt::format(
      "taken for the server's clock, a median error of {:.3g} ms; corrected, as a live system can, "
      "{:.3g} ms",
      error_ms(s, "as printed, for the server's clock", "median"), error_ms(s, kCausal, "median"));
}

// One sentence on the error of live clocks; empty where no frame was timed by one.
std::vector<std::string> findings(const ClocksSummary& s) {
  const Number* median = s.numbers.find({.method = kCausal, .measure = "clock_error", .statistic = "median"});
  if (!median) return {};
  return {
      fmt::format("{} live system puts frames at their times to within {:.3f} ms in the median and "
                  "{:.3f} ms in 99 % of {} frames{}.",
                  s.simulated ? "Simulated: a" : "A", kMsPerS * median->value, error_ms(s, kCausal, "p99"),
                  median->n, s.simulated ? "" : ", against the fit of all exchanges")};
}

}  // namespace

StoredTables clocks_tables(const ClocksSummary& summary) {
  StoredTables shown;
  shown.title = summary.study == summary.campaign ? summary.study : summary.study + " on " + summary.campaign;
  shown.asked = "How well do the clocks agree, and do frames come in time?";
  shown.about = fmt::format("Clocks of {}, computers of {}, {}.", counted(summary.recordings, "recording"),
                            counted(computers(summary).size(), "sensor"),
                            summary.simulated ? "**simulated**" : "recorded");
  shown.findings = findings(summary);
  for (const std::string& text : summary.failed) shown.warnings.push_back("Left out: " + text);
  shown.errata = {{"E11", clock_effect(summary)}};
  shown.tables = {errors_table(summary), queue_table(summary), machines_table(summary), processing_table()};
  for (Table& table : shown.tables)
    if (table.id != "machines") table.printed = "table4";
  for (std::size_t t = 0; t < 2; ++t) shown.tables[t].shown = Table::Placement::first;
  return shown;
}

}  // namespace trilat
