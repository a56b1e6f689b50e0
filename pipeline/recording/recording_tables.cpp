// SPDX-License-Identifier: MIT
#include "pipeline/recording/recording_tables.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"

namespace trilat {
namespace {

constexpr const char* kThePapers = "the paper's";
constexpr double kMsPerS = 1e3;
constexpr double kUsPerS = 1e6;

constexpr double kPercent = 100.0;

TableValue share_cell(std::uint64_t part, std::uint64_t whole) {
  return TableValue::of(100.0 * share_of(part, whole), 2);
}

// Share of the sensors' runs in which every frame is.
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

// Our rows behind the paper's.
template <class Row>
std::vector<Row> behind(Row papers, const std::vector<Row>& rows) {
  std::vector<Row> all{std::move(papers)};
  all.insert(all.end(), rows.begin(), rows.end());
  return all;
}

// By the method that processes the fewest frames within the paper's ranges below 33 ms; nothing was timed:
// NaN.
double processed_share(const std::optional<StageTimings>& timings) {
  double least = kNoNumber;
  if (!timings) return least;
  for (const StageTiming& s : timings->stages)
    if (s.name == kDepthToJoints) least = std::fmin(least, 1.0 - share_of(s.time.bins.back(), s.time.n));
  return least;
}

std::vector<TableValue> paper_queue_row(const Table& table) {
  const PrintedTable4 paper = printed_table4();
  const std::uint64_t taken = paper.frames - paper.lost_frames;
  const TableValue papers = TableValue::of(kThePapers);
  return row_by_key(table, {{"network", papers},
                            {"method", papers},
                            {"server", papers},
                            {"frames", count_cell(paper.frames)},
                            {"too_late", count_cell(paper.lost_frames)},
                            {"taken_percent", share_cell(taken, paper.frames)},
                            {"processed_percent", share_cell(taken - paper.rows.front().frames, taken)},
                            {"real_time_percent", TableValue::of(paper.real_time_percent, 2)}});
}

// The paper's frames by processing time, or its samples by clock error, as ours are counted.
TimeSpread printed_table4_times(std::uint64_t PrintedTable4::Row::*count) {
  const PrintedTable4 paper = printed_table4();
  TimeSpread printed;
  for (std::size_t b = 0; b < printed.bins.size(); ++b)
    printed.n += printed.bins[b] = paper.rows[paper.rows.size() - 1 - b].*count;
  return printed;
}

Table table4_queue(const RecordingSummary& s, const std::optional<StageTimings>& timings) {
  using R = QueueRow;
  using Q = QueueCounts;
  const double processed = processed_share(timings);
  const auto taken = [](const R& r) { return share_of(r.counts.taken, r.counts.came); };
  Table table = table_of<R>(
      "queue",
      fmt::format("Table IV, frames in real time, simulated: {} frames x {} sensors x {} runs of each "
                  "network, seed {}, limit of the queue {:.1f} ms",
                  s.frames, s.sensors, s.runs, s.seed, s.late_s * kMsPerS),
      s.queues,
      {{"network", "network", as_text(&R::network)},
       {"method", "method", as_text(&R::method)},
       {"the server takes frames", "server", as_text(&R::server)},
       {"frames", "frames", of(&R::counts, as_count(&Q::came))},
       {"without a time", "untimed", of(&R::counts, as_count(&Q::untimed))},
       {"too early", "too_early", of(&R::counts, as_count(&Q::too_early))},
       {"too late", "too_late", of(&R::counts, as_count(&Q::too_late))},
       {"taken (%)", "taken_percent", as_number(2, kPercent, taken, &R::taken_low, &R::taken_high)},
       {"processed within 33 ms (%)", "processed_percent",
        as_number(2, kPercent, [=](const R&) { return processed; })},
       {"in real time (%)", "real_time_percent",
        as_number(2, kPercent, [=](const R& r) { return processed * taken(r); })}});
  table.rows.insert(table.rows.begin(), paper_queue_row(table));
  add_notes(table, "queue");
  return table;
}

Table table4_clocks(const RecordingSummary& s) {
  using R = ClockErrorRow;
  using T = TimeSpread;
  const auto of_asked = [](std::size_t first, std::size_t last) {
    return [=](const R& r) { return share_in_bins(r.error, r.asked, first, last); };
  };
  const auto share = [&](std::size_t first, std::size_t last) {
    return as_number(2, kPercent, of_asked(first, last));
  };
  const auto ms = [](double T::*seconds) { return of(&R::error, as_number(3, kMsPerS, seconds)); };
  const TimeSpread printed = printed_table4_times(&PrintedTable4::Row::clock_samples);
  Table table = table_of<R>(
      "clocks",
      fmt::format(
          "Table IV, clock errors, simulated: {} frames x {} sensors x {} runs of each network, seed {}",
          s.frames, s.sensors, s.runs, s.seed),
      behind(R{kThePapers, kThePapers, printed.n, printed}, s.clocks),
      {{"network", "network", as_text(&R::network)},
       {"method", "method", as_text(&R::method)},
       {"samples", "samples", of(&R::error, as_count(&T::n))},
       {"(0,2) ms (%)", "below_2ms_percent",
        as_number(2, kPercent, of_asked(0, 0), &R::below_2ms_low, &R::below_2ms_high)},
       {"[2,4) (%)", "from_2_to_4ms_percent", share(1, 1)},
       {"[4,11) (%)", "from_4_to_11ms_percent", share(2, 2)},
       {"[11,22) (%)", "from_11_to_22ms_percent", share(3, 3)},
       {"[22,33) (%)", "from_22_to_33ms_percent", share(4, 4)},
       {"33 ms on (%)", "from_33ms_percent", share(5, 5)},
       {"below 4 ms (%)", "below_4ms_percent", share(0, 1)},
       {"sensors' runs wholly below 4 ms (%)", "units_below_4ms_percent",
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

Table table4_fits(const RecordingSummary& s) {
  using R = ClockFitRow;
  Table table = table_of<R>(
      "fits", "What the corrected clocks say of their own error, simulated: means over sensors and runs",
      s.fits,
      {{"network", "network", as_text(&R::network)},
       {"standard deviation (ms)", "offset_sigma_ms", as_number(3, kMsPerS, &R::offset_sigma_s)},
       {"bound of unlike delays (ms)", "offset_bound_ms", as_number(3, kMsPerS, &R::offset_bound_s)},
       {"frames within both (%)", "within_bound_percent", in_percent(&R::within_bound_share)},
       {"exchanges used (%)", "exchanges_used_percent", in_percent(&R::exchanges_used_share)}});
  add_notes(table, "fits");
  return table;
}

Table table4_processing(const StageTimings& t) {
  using R = StageTiming;
  using T = TimeSpread;
  const auto share = [](std::size_t first, std::size_t last) {
    return of(&R::time, as_number(2, kPercent,
                                  [=](const T& time) { return share_in_bins(time, time.n, first, last); }));
  };
  const auto us = [](double T::*seconds) { return of(&R::time, as_number(1, kUsPerS, seconds)); };
  // three of our bins make the paper's shortest
  Table table = table_of<R>(
      "processing", fmt::format("Table IV, processing time of a frame, measured on {}", t.processor),
      behind(R{"depth image to joints", kThePapers, printed_table4_times(&PrintedTable4::Row::frames)},
             t.stages),
      {{"stage", "stage", as_text(&R::name)},
       {"method", "method", as_text(&R::method)},
       {"frames", "frames", of(&R::time, as_count(&T::n))},
       {"(0,11) ms (%)", "below_11ms_percent", share(0, 2)},
       {"[11,22) (%)", "from_11_to_22ms_percent", share(3, 3)},
       {"[22,33) (%)", "from_22_to_33ms_percent", share(4, 4)},
       {"33 ms on (%)", "from_33ms_percent", share(5, 5)},
       {"median (us)", "median_us", us(&T::median_s)},
       {"p95 (us)", "p95_us", us(&T::p95_s)},
       {"p99 (us)", "p99_us", us(&T::p99_s)},
       {"p99.9 (us)", "p999_us", us(&T::p999_s)},
       {"max (us)", "max_us", us(&T::max_s)}});
  add_notes(table, "processing");
  return table;
}

// E11.
std::string clock_effect(const RecordingSummary& s) {
  if (s.clocks.empty()) return {};
  const auto median_ms = [&](const std::string& method) {
    for (const ClockErrorRow& row : s.clocks)
      if (row.method == method) return 1e3 * row.error.median_s;
    return kNoNumber;
  };
  return fmt::format("taken for the server's clock, a median error of {:.3g} ms; corrected {:.3g} ms ({})",
                     median_ms("as printed, for the server's clock"), median_ms("corrected"),
                     s.clocks.front().network);
}

}  // namespace

StoredTables recording_tables(const RecordingSummary& summary, const std::optional<StageTimings>& timings) {
  StoredTables shown;
  shown.title = summary.study;
  shown.asked = "How well do the clocks agree, and are frames processed in time?";
  shown.about = fmt::format(
      "Clocks and processing times, **simulated** recordings (seed {}); the times that frames take are "
      "measured.",
      summary.seed);
  shown.errata = {{"E11", clock_effect(summary)}};
  std::vector<Table>& tables = shown.tables;
  if (!summary.clocks.empty()) tables.push_back(table4_clocks(summary));
  if (!summary.queues.empty()) tables.push_back(table4_queue(summary, timings));
  if (!summary.fits.empty()) tables.push_back(table4_fits(summary));
  if (timings && !timings->stages.empty()) tables.push_back(table4_processing(*timings));
  for (Table& table : tables) table.printed = "table4";
  for (std::size_t t = 0; t < 2 && t < tables.size(); ++t) tables[t].shown = Table::Shown::first;
  return shown;
}

}  // namespace trilat
