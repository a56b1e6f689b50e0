// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clocks_tables.h"

#include <utility>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "evaluators/metrics/statistics.h"

namespace trilat {
namespace {

constexpr const char* kThePapers = "the paper's";
constexpr double kMsPerS = 1e3;
constexpr double kPercent = 100.0;

TableValue share_cell(std::uint64_t part, std::uint64_t whole) {
  return TableValue::of(100.0 * share_of(part, whole), 2);
}

// Subject of the tables.
std::string about(const ClocksSummary& s) {
  return fmt::format("{}{} recording{}, {} computers of sensors ({})", s.simulated ? "simulated, " : "",
                     s.recordings, s.recordings == 1 ? "" : "s", s.machines.size(), s.campaign);
}

// Share of the recordings of a sensor in which every frame is.
double wholly_below_4ms(const ClockErrorRow& row) {
  std::uint64_t whole = 0;
  for (const ClockUnit& unit : row.units) whole += unit.below_4ms == unit.asked;
  return share_of(whole, row.units.size());
}

// Share of so many times that lies from one bin on up to another.
double share_in_bins(const TimeSpread& time, std::uint64_t of, std::size_t first, std::size_t last) {
  std::uint64_t sum = 0;
  for (std::size_t b = first; b <= last; ++b) sum += time.bins[b];
  return share_of(sum, of);
}

// The paper's frames by processing time, or its samples by clock error, as ours are counted.
TimeSpread printed_times(std::uint64_t PrintedTable4::Row::*count) {
  const PrintedTable4 paper = printed_table4();
  TimeSpread printed;
  for (std::size_t b = 0; b < printed.bins.size(); ++b)
    printed.n += printed.bins[b] = paper.rows[paper.rows.size() - 1 - b].*count;
  return printed;
}

Table queue_table(const ClocksSummary& s) {
  using R = QueueRow;
  using Q = QueueCounts;
  const auto taken = [](const R& r) { return share_of(r.counts.taken, r.counts.came); };
  Table table = table_of<R>(
      "queue",
      fmt::format("Table IV, frames in real time: {}, limit of the queue {:.1f} ms", about(s),
                  s.late_s * kMsPerS),
      s.queues,
      {{"method", "method", as_text(&R::method)},
       {"the server takes frames", "server", as_text(&R::server)},
       {"frames", "frames", of(&R::counts, as_count(&Q::came))},
       {"without a time", "untimed", of(&R::counts, as_count(&Q::untimed))},
       {"too early", "too_early", of(&R::counts, as_count(&Q::too_early))},
       {"too late", "too_late", of(&R::counts, as_count(&Q::too_late))},
       {"taken (%)", "taken_percent", as_number(2, kPercent, taken, &R::taken_low, &R::taken_high)}});
  const PrintedTable4 paper = printed_table4();
  const TableValue papers = TableValue::of(kThePapers);
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
  using R = ClockErrorRow;
  using T = TimeSpread;
  const auto of_asked = [](std::size_t first, std::size_t last) {
    return [=](const R& r) { return share_in_bins(r.error, r.asked, first, last); };
  };
  const auto share = [&](std::size_t first, std::size_t last) {
    return as_number(2, kPercent, of_asked(first, last));
  };
  const auto ms = [](double T::*seconds) { return of(&R::error, as_number(3, kMsPerS, seconds)); };
  const TimeSpread printed = printed_times(&PrintedTable4::Row::clock_samples);
  std::vector<R> rows{R{kThePapers, printed.n, printed}};
  rows.insert(rows.end(), s.clocks.begin(), s.clocks.end());
  Table table = table_of<R>("clocks", "Table IV, clock errors: " + about(s), rows,
                            {{"method", "method", as_text(&R::method)},
                             {"samples", "samples", of(&R::error, as_count(&T::n))},
                             {"(0,2) ms (%)", "below_2ms_percent",
                              as_number(2, kPercent, of_asked(0, 0), &R::below_2ms_low, &R::below_2ms_high)},
                             {"[2,4) (%)", "from_2_to_4ms_percent", share(1, 1)},
                             {"[4,11) (%)", "from_4_to_11ms_percent", share(2, 2)},
                             {"[11,22) (%)", "from_11_to_22ms_percent", share(3, 3)},
                             {"[22,33) (%)", "from_22_to_33ms_percent", share(4, 4)},
                             {"33 ms on (%)", "from_33ms_percent", share(5, 5)},
                             {"below 4 ms (%)", "below_4ms_percent", share(0, 1)},
                             {"sensors' recordings wholly below 4 ms (%)", "units_below_4ms_percent",
                              as_number(2, kPercent, wholly_below_4ms)},
                             {"median (ms)", "median_ms", ms(&T::median_s)},
                             {"p95 (ms)", "p95_ms", ms(&T::p95_s)},
                             {"p99 (ms)", "p99_ms", ms(&T::p99_s)},
                             {"p99.9 (ms)", "p999_ms", ms(&T::p999_s)},
                             {"max (ms)", "max_ms", ms(&T::max_s)}});
  const PrintedTable4 paper = printed_table4();
  add_notes(table, "clock_errors",
            {{"good", std::to_string(printed.bins[0])},
             {"total", std::to_string(printed.n)},
             {"percent", fmt::format("{:.2f}", kPercent * share_in_bins(printed, printed.n, 0, 0))},
             {"printed", fmt::format("{:g}", paper.below_2ms_percent)},
             {"wanted", std::to_string(paper.frames * paper.clients)}});
  return table;
}

Table machines_table(const ClocksSummary& s) {
  using R = MachineRow;
  Table table = table_of<R>(
      "machines", "Each computer's clock and the way of its frames: " + about(s), s.machines,
      {{"take", "take", as_text(&R::take)},
       {"sensor", "sensor", as_text(&R::sensor)},
       {"exchanges", "exchanges", as_count(&R::exchanges)},
       {"used (%)", "exchanges_used_percent", in_percent(&R::exchanges_used_share)},
       {"standard deviation (ms)", "offset_sigma_ms", as_number(3, kMsPerS, &R::offset_sigma_s)},
       {"bound of unlike delays (ms)", "offset_bound_ms", as_number(3, kMsPerS, &R::offset_bound_s)},
       {"off the line (ms)", "bend_ms", as_number(3, kMsPerS, &R::bend_s)},
       {"frames within both (%)", "within_bound_percent", in_percent(&R::within_bound_share)},
       {"frames", "frames", as_count(&R::frames)},
       {"from exposure, median (ms)", "latency_median_ms", as_number(1, kMsPerS, &R::latency_median_s)},
       {"p99 (ms)", "latency_p99_ms", as_number(1, kMsPerS, &R::latency_p99_s)},
       {fmt::format("within {:.1f} ms (%)", s.late_s * kMsPerS), "in_time_percent",
        in_percent(&R::in_time_share)}});
  add_notes(table, "machines");
  constexpr std::size_t kShown = 8;
  table.first_rows = std::min(table.rows.size(), kShown);
  return table;
}

// The paper's alone.
Table processing_table() {
  struct R {
    std::string stage;
    TimeSpread time;
  };
  const auto share = [](std::size_t first, std::size_t last) {
    return of(&R::time, as_number(2, kPercent, [=](const TimeSpread& time) {
      return share_in_bins(time, time.n, first, last);
    }));
  };
  Table table = table_of<R>("processing", "Table IV, processing time of a frame, as the paper prints it",
                            {R{"depth image to joints", printed_times(&PrintedTable4::Row::frames)}},
                            {{"stage", "stage", as_text(&R::stage)},
                             {"frames", "frames", of(&R::time, as_count(&TimeSpread::n))},
                             {"(0,11) ms (%)", "below_11ms_percent", share(0, 2)},
                             {"[11,22) (%)", "from_11_to_22ms_percent", share(3, 3)},
                             {"[22,33) (%)", "from_22_to_33ms_percent", share(4, 4)},
                             {"33 ms on (%)", "from_33ms_percent", share(5, 5)}});
  add_notes(table, "processing");
  return table;
}

// E11.
std::string clock_effect(const ClocksSummary& s) {
  const auto median_ms = [&](const std::string& method) {
    for (const ClockErrorRow& row : s.clocks)
      if (row.method == method) return 1e3 * row.error.median_s;
    return kNoNumber;
  };
  return fmt::format(
      "taken for the server's clock, a median error of {:.3g} ms; corrected, as a live system can, "
      "{:.3g} ms",
      median_ms("as printed, for the server's clock"), median_ms("corrected, causal"));
}

// Sentences on what a live system reaches.
std::vector<std::string> findings(const ClocksSummary& s) {
  std::vector<std::string> found;
  for (const ClockErrorRow& row : s.clocks)
    if (row.method == "corrected, causal")
      found.push_back(
          fmt::format("{} live system puts frames at their times to within {:.3f} ms in the median and "
                      "{:.3f} ms in 99 % of {} frames{}.",
                      s.simulated ? "Simulated: a" : "A", 1e3 * row.error.median_s, 1e3 * row.error.p99_s,
                      row.error.n, s.simulated ? "" : ", against the fit of all exchanges"));
  return found;
}

}  // namespace

StoredTables clocks_tables(const ClocksSummary& summary) {
  StoredTables shown;
  shown.title = summary.study == summary.campaign ? summary.study : summary.study + " on " + summary.campaign;
  shown.asked = "How well do the clocks agree, and do frames come in time?";
  shown.about = fmt::format("Clocks of {} recording{}, {} computers of sensors, {}.", summary.recordings,
                            summary.recordings == 1 ? "" : "s", summary.machines.size(),
                            summary.simulated ? "**simulated**" : "recorded");
  shown.findings = findings(summary);
  for (const std::string& text : summary.left_out) shown.warnings.push_back("Left out: " + text);
  shown.errata = {{"E11", clock_effect(summary)}};
  shown.tables = {errors_table(summary), queue_table(summary), machines_table(summary), processing_table()};
  for (Table& table : shown.tables)
    if (table.id != "machines") table.printed = "table4";
  for (std::size_t t = 0; t < 2; ++t) shown.tables[t].shown = Table::Shown::first;
  return shown;
}

}  // namespace trilat
