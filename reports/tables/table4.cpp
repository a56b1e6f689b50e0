// SPDX-License-Identifier: MIT
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "datasets/paper/printed_tables.h"
#include "reports/tables/table.h"
#include "reports/tables/tables.h"

namespace trilat {
namespace {

constexpr double kMsPerS = 1e3;
constexpr double kUsPerS = 1e6;

TableValue ms_cell(double seconds) { return TableValue::of(seconds * kMsPerS, 3); }
TableValue us_cell(double seconds) { return TableValue::of(seconds * kUsPerS, 1); }
TableValue share_cell(std::uint64_t part, std::uint64_t whole) {
  return TableValue::of(100.0 * share_of(part, whole), 2);
}

// Printed from the longest to the shortest.
std::uint64_t printed_count(const PrintedTable4::Row& row, bool clocks) {
  return clocks ? row.clock_samples : row.frames;
}

std::uint64_t printed_total(const PrintedTable4& paper, bool clocks) {
  std::uint64_t total = 0;
  for (const PrintedTable4::Row& row : paper.rows) total += printed_count(row, clocks);
  return total;
}

std::vector<TableValue> paper_clock_row(std::size_t columns) {
  const PrintedTable4 paper = printed_table4();
  const std::uint64_t total = printed_total(paper, true);
  std::vector<TableValue> row(columns, no_cell());
  row[0] = TableValue::of("the paper's");
  row[1] = TableValue::of("the paper's");
  row[2] = count_cell(total);
  for (std::size_t b = 0; b < paper.rows.size(); ++b)
    row[3 + b] = share_cell(paper.rows[paper.rows.size() - 1 - b].clock_samples, total);
  row[9] = share_cell(paper.rows.back().clock_samples + (paper.rows.end() - 2)->clock_samples, total);
  return row;
}

// Share of the sensors' runs, of those with an answer, in which every answer is.
TableValue wholly_below_4ms(const std::vector<ClockUnit>& units) {
  std::uint64_t answering = 0, whole = 0;
  for (const ClockUnit& unit : units) {
    answering += unit.answered > 0;
    whole += unit.answered > 0 && unit.below_4ms == unit.answered;
  }
  return share_cell(whole, answering);
}

std::vector<TableValue> clock_cells(const ClockErrorRow& r) {
  std::vector<TableValue> row{TableValue::of(r.network), TableValue::of(r.method), count_cell(r.error.n)};
  for (std::uint64_t count : r.error.bins) row.push_back(share_cell(count, r.error.n));
  row.push_back(share_cell(r.error.bins[0] + r.error.bins[1], r.error.n));
  row.push_back(wholly_below_4ms(r.units));
  for (double q : {r.error.median_s, r.error.p95_s, r.error.p99_s, r.error.p999_s, r.error.max_s})
    row.push_back(ms_cell(q));
  row[3].low = 100.0 * r.below_2ms_low;
  row[3].high = 100.0 * r.below_2ms_high;
  return row;
}

std::vector<std::string> clock_notes() {
  const PrintedTable4 paper = printed_table4();
  const std::uint64_t good = paper.rows.back().clock_samples, total = printed_total(paper, true);
  return {
      fmt::format(
          "The paper prints {} of {} samples below 2 ms, which are {:.2f} % and not {:g} %, and there "
          "should be {} (E14).",
          good, total, 100.0 * share_of(good, total), paper.below_2ms_percent, paper.frames * paper.clients),
      "An error is that of the time at which a sensor's machine sent a frame; by the sensor's ticks, of the "
      "exposure.",
      "As printed, equations 20 to 22 give a time on the client's clock (E11). Taken for the server's, it is "
      "off by the whole offset of the clocks; compared with the client's, as the paper seems to have done, "
      "by how much the delay of the frame differs from that of the latest exchange.",
      "Corrected is one fit to the whole recording, which no live system has; causal looks at no exchange "
      "that "
      "came after the frame: of the last 8 it takes the offset by that of least delay.",
      "Intervals are over sensors and runs, each with other clocks, and so is the share of sensors' runs in "
      "which every answer is below 4 ms; what a constant difference of the delays "
      "does, no method can see."};
}

// The paper's ranges of processing time: three of ours make its shortest.
std::vector<TableValue> processing_bins(const TimeSpread& time) {
  return {share_cell(time.bins[0] + time.bins[1] + time.bins[2], time.n), share_cell(time.bins[3], time.n),
          share_cell(time.bins[4], time.n), share_cell(time.bins[5], time.n)};
}

std::vector<TableValue> paper_processing_row(std::size_t columns) {
  const PrintedTable4 paper = printed_table4();
  TimeSpread printed;
  for (std::size_t b = 0; b < printed.bins.size(); ++b)
    printed.bins[b] = paper.rows[paper.rows.size() - 1 - b].frames;
  printed.n = std::accumulate(printed.bins.begin(), printed.bins.end(), std::uint64_t{0});
  std::vector<TableValue> row{TableValue::of("depth image to joints"), TableValue::of("the paper's"),
                              count_cell(printed.n)};
  for (TableValue& cell : processing_bins(printed)) row.push_back(std::move(cell));
  row.resize(columns, no_cell());
  return row;
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

std::vector<TableValue> paper_queue_row() {
  const PrintedTable4 paper = printed_table4();
  const std::uint64_t taken = paper.frames - paper.lost_frames;
  return {TableValue::of("the paper's"),
          TableValue::of("the paper's"),
          TableValue::of("the paper's"),
          count_cell(paper.frames),
          no_cell(),
          no_cell(),
          count_cell(paper.lost_frames),
          share_cell(taken, paper.frames),
          share_cell(taken - paper.rows.front().frames, taken),
          TableValue::of(paper.real_time_percent, 2)};
}

std::vector<TableValue> queue_cells(const QueueRow& r, double processed) {
  const auto fine_cell = [](double share) { return TableValue::of(100.0 * share, 2); };
  return {TableValue::of(r.network),
          TableValue::of(r.method),
          TableValue::of(r.server),
          count_cell(r.counts.came),
          count_cell(r.counts.untimed),
          count_cell(r.counts.too_early),
          count_cell(r.counts.too_late),
          number_cell(2, 100.0 * share_of(r.counts.taken, r.counts.came), 100.0 * r.taken_low,
                      100.0 * r.taken_high),
          fine_cell(processed),
          fine_cell(processed * share_of(r.counts.taken, r.counts.came))};
}

}  // namespace

Table table4_queue(const RecordingSummary& s, const std::optional<StageTimings>& timings) {
  Table table;
  table.id = "queue";
  table.title = fmt::format(
      "Table IV, frames in real time, simulated: {} frames x {} sensors x {} runs of each network, seed {}, "
      "limit of the queue {:.1f} ms",
      s.frames, s.sensors, s.runs, s.seed, s.late_s * kMsPerS);
  table.columns = {{"network", "network", true},
                   {"method", "method", true},
                   {"the server takes frames", "server", true},
                   {"frames", "frames"},
                   {"without a time", "untimed"},
                   {"too early", "too_early"},
                   {"too late", "too_late"},
                   interval_column("taken (%)", "taken_percent"),
                   {"processed within 33 ms (%)", "processed_percent"},
                   {"in real time (%)", "real_time_percent"}};
  table.rows.push_back(paper_queue_row());
  const double processed = processed_share(timings);
  for (const QueueRow& row : s.queues) table.rows.push_back(queue_cells(row, processed));
  table.notes = notes("queue");
  return table;
}

Table table4_clocks(const RecordingSummary& s) {
  Table table;
  table.id = "clocks";
  table.title = fmt::format(
      "Table IV, clock errors, simulated: {} frames x {} sensors x {} runs of each network, seed {}",
      s.frames, s.sensors, s.runs, s.seed);
  table.columns = {{"network", "network", true},
                   {"method", "method", true},
                   {"samples", "samples"},
                   interval_column("(0,2) ms (%)", "below_2ms_percent"),
                   {"[2,4) (%)", "from_2_to_4ms_percent"},
                   {"[4,11) (%)", "from_4_to_11ms_percent"},
                   {"[11,22) (%)", "from_11_to_22ms_percent"},
                   {"[22,33) (%)", "from_22_to_33ms_percent"},
                   {"33 ms on (%)", "from_33ms_percent"},
                   {"below 4 ms (%)", "below_4ms_percent"},
                   {"sensors' runs wholly below 4 ms (%)", "units_below_4ms_percent"},
                   {"median (ms)", "median_ms"},
                   {"p95 (ms)", "p95_ms"},
                   {"p99 (ms)", "p99_ms"},
                   {"p99.9 (ms)", "p999_ms"},
                   {"max (ms)", "max_ms"}};
  table.rows.push_back(paper_clock_row(table.columns.size()));
  for (const ClockErrorRow& row : s.clocks) table.rows.push_back(clock_cells(row));
  table.notes = clock_notes();
  return table;
}

Table table4_fits(const RecordingSummary& s) {
  Table table;
  table.id = "fits";
  table.title = "What the corrected clocks say of their own error, simulated: means over sensors and runs";
  table.columns = {{"network", "network", true},
                   {"standard deviation (ms)", "offset_sigma_ms"},
                   {"bound of unlike delays (ms)", "offset_bound_ms"},
                   {"frames within both (%)", "within_bound_percent"},
                   {"exchanges used (%)", "exchanges_used_percent"}};
  for (const ClockFitRow& r : s.fits)
    table.rows.push_back({TableValue::of(r.network), ms_cell(r.offset_sigma_s), ms_cell(r.offset_bound_s),
                          percent_cell(r.within_bound_share), percent_cell(r.exchanges_used_share)});
  table.notes = notes("fits");
  return table;
}

Table table4_processing(const StageTimings& t) {
  Table table;
  table.id = "processing";
  table.title = fmt::format("Table IV, processing time of a frame, measured on {}", t.processor);
  table.columns = {{"stage", "stage", true},
                   {"method", "method", true},
                   {"frames", "frames"},
                   {"(0,11) ms (%)", "below_11ms_percent"},
                   {"[11,22) (%)", "from_11_to_22ms_percent"},
                   {"[22,33) (%)", "from_22_to_33ms_percent"},
                   {"33 ms on (%)", "from_33ms_percent"},
                   {"median (us)", "median_us"},
                   {"p95 (us)", "p95_us"},
                   {"p99 (us)", "p99_us"},
                   {"p99.9 (us)", "p999_us"},
                   {"max (us)", "max_us"}};
  table.rows.push_back(paper_processing_row(table.columns.size()));
  for (const StageTiming& s : t.stages) {
    std::vector<TableValue> row{TableValue::of(s.name), TableValue::of(s.method), count_cell(s.time.n)};
    for (TableValue& cell : processing_bins(s.time)) row.push_back(std::move(cell));
    for (double q : {s.time.median_s, s.time.p95_s, s.time.p99_s, s.time.p999_s, s.time.max_s})
      row.push_back(us_cell(q));
    table.rows.push_back(std::move(row));
  }
  table.notes = notes("processing");
  return table;
}

std::vector<Table> table4(const RecordingSummary& summary, const std::optional<StageTimings>& timings) {
  std::vector<Table> tables;
  if (!summary.clocks.empty()) tables.push_back(table4_clocks(summary));
  if (!summary.queues.empty()) tables.push_back(table4_queue(summary, timings));
  if (!summary.fits.empty()) tables.push_back(table4_fits(summary));
  if (timings && !timings->stages.empty()) tables.push_back(table4_processing(*timings));
  return tables;
}

}  // namespace trilat
