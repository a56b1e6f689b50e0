// SPDX-License-Identifier: MIT
#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "pipeline/study/parallel.h"
#include "pipeline/study/results_run.h"
#include "pipeline/study/study.h"
#include "pipeline/sweep/sweep_cell.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_tables.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

// An item has no more trials than that, some seconds, unless a single cell has more.
constexpr std::uint64_t kItemTrials = std::uint64_t{1} << 22;

double us_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// Microseconds a solve of the first problems of a cell, one after the other, each with its start.
double scalar_us(const SweepSpec& spec, std::size_t cell) {
  const SweepTrials trials = trials_of(spec, spec.cells[cell]);
  SweepBlock block(trials);
  std::vector<PointEstimate> estimates(kBlockTrials);
  double us = 0.0;
  for (std::uint64_t first = 0; first < spec.time_problems; first += kBlockTrials) {
    const std::uint64_t left = spec.time_problems - first;
    block.make_trials(first, static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, left)));
    const auto problems = block.problems();
    const auto start = Clock::now();
    for (std::size_t i = 0; i < problems.size(); ++i)
      estimates[i] = solve_nonlinear(problems[i], trials.options);
    us += us_since(start);
  }
  return us / static_cast<double>(spec.time_problems);
}

// Times every cell on one thread by the scalar solver; of three rounds over all cells the fastest counts, so
// that a busy moment of the machine spoils none.
void time_into(const std::filesystem::path& folder, const SweepSpec& spec, const RunControl& control) {
  constexpr std::size_t kRounds = 3;
  const std::size_t cells = spec.cells.size();
  SweepTimings timings{spec.name, processor_name(), spec.time_problems, {}};
  timings.solve_us.assign(cells, std::numeric_limits<double>::infinity());
  for (std::size_t round = 0; round < kRounds; ++round)
    for (std::size_t cell = 0; cell < cells; ++cell) {
      control.check();
      timings.solve_us[cell] = std::min(timings.solve_us[cell], scalar_us(spec, cell));
      control.report(static_cast<double>(round * cells + cell + 1) / static_cast<double>(kRounds * cells));
    }
  write_json_file(folder, timings);
}

constexpr std::uint64_t kChunksAtOnce = 64;  // whose sums are in memory

// Cells of one item, which follow each other.
struct Cells {
  std::size_t first = 0, count = 0;
};

std::vector<Cells> items_of(const SweepSpec& spec) {
  const std::size_t interpretation = spec.thresholds.size() * spec.ranges.size();
  const auto most = static_cast<std::size_t>(std::max<std::uint64_t>(1, kItemTrials / spec.trials));
  std::vector<Cells> items;
  for (std::size_t begin = 0; begin < spec.cells.size(); begin += interpretation)
    for (std::size_t first = begin; first < begin + interpretation; first += most)
      items.push_back({first, std::min(most, begin + interpretation - first)});
  return items;
}

std::string id_of(const Cells& item) { return fmt::format("trials/from-cell-{}", item.first + 1); }

// One chunk of one cell's trials.
struct Chunk {
  SweepSums sums;
  double us = 0.0;  // that solving them took
  void add(const Chunk& later) {
    sums.add(later.sums);
    us += later.us;
  }
};

Chunk solve_chunk(const SweepSpec& spec, std::size_t cell, std::uint64_t chunk, const RunControl& control) {
  SweepBlock block(trials_of(spec, spec.cells[cell]));
  const std::uint64_t end = std::min((chunk + 1) * kChunkTrials, spec.trials);
  Chunk solved;
  for (std::uint64_t trial = chunk * kChunkTrials; trial < end; trial += kBlockTrials) {
    control.check();
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, end - trial));
    const auto start = Clock::now();
    block.make_trials(trial, count);
    block.solve_into(solved.sums);
    solved.us += us_since(start);
  }
  return solved;
}

// Leaves the numbers of each cell, and how long its trials took, in the item's folder.
Json compute(const SweepSpec& spec, const Cells& item, const std::filesystem::path& into,
             const RunControl& control) {
  const std::uint64_t per_cell = (spec.trials + kChunkTrials - 1) / kChunkTrials;
  const std::uint64_t chunks = item.count * per_cell;
  std::vector<Chunk> of_cell(item.count), solved(std::min(kChunksAtOnce, chunks));
  std::atomic<std::uint64_t> done{0};
  for (std::uint64_t first = 0; first < chunks; first += solved.size()) {
    const std::size_t count = std::min<std::uint64_t>(solved.size(), chunks - first);
    parallel_for_index(count, 1, [&](std::size_t i) {
      solved[i] = solve_chunk(spec, item.first + (first + i) / per_cell, (first + i) % per_cell, control);
      control.report(static_cast<double>(++done) / static_cast<double>(chunks));
    });
    control.check();  // cancelled from outside, chunks are left out without a word
    for (std::size_t i = 0; i < count; ++i) of_cell[(first + i) / per_cell].add(solved[i]);
  }
  Numbers numbers;
  SweepTimings timings{spec.name, processor_name(), 0, {}};
  for (std::size_t c = 0; c < of_cell.size(); ++c) {
    numbers.add(numbers_of(of_cell[c].sums, spec.cells[item.first + c].key()));
    timings.solve_us.push_back(of_cell[c].us / static_cast<double>(spec.trials));
  }
  write_numbers(into, numbers);
  write_json_file(into, timings);
  return {{"rows", numbers.all().size()}};
}

// The times of all items' trials, as the runs that solved them took them.
void gather_times(const SweepSpec& spec, const std::vector<Cells>& items, const ResultsRun& run,
                  const std::filesystem::path& folder) {
  SweepTimings all{spec.name, processor_name(), 0, {}};
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto of_item = read_json_file<SweepTimings>(run.outcome(i).folder);
    for (std::size_t cell = 0; cell < items[i].count; ++cell)
      all.solve_us.push_back(of_item ? of_item->solve_us.at(cell) : kNaN);
  }
  write_json_file(folder, all);
}

SweepSummary summary_of(const SweepSpec& spec, const std::vector<Cells>& items, const ResultsRun& run) {
  SweepSummary s;
  s.study = spec.name;
  s.paper = name_of(spec.paper);
  s.seed = spec.seed;
  s.trials = spec.trials;
  s.max_iterations = spec.max_iterations;
  s.skipped = spec.skipped;
  s.thresholds = spec.thresholds.size();
  s.ranges = spec.ranges.size();
  for (const SweepSetting& setting : spec.cells) s.cells.push_back({setting});
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ItemResult& outcome = run.outcome(i);
    s.numbers.add(read_numbers(outcome.folder, outcome.json.at("rows").get<std::uint64_t>()));
  }
  add_interpretations(s);
  return s;
}

// Equal for items of equal outcome, whatever else their studies hold.
std::string key_of_item(const SweepSpec& spec, const Cells& item) {
  Json cells = Json::array();
  for (std::size_t cell = item.first; cell < item.first + item.count; ++cell) {
    const SweepSetting& setting = spec.cells[cell];
    cells.push_back(
        {json_of(setting), std::ranges::find(spec.rigs, setting.rig, &SweepRig::name)->sensors_m});
  }
  return key_of({{"kind", "trials of a threshold sweep"},
                 {"cells", cells},
                 {"seed", spec.seed},
                 {"trials", spec.trials},
                 {"max_iterations", spec.max_iterations}});
}

}  // namespace

ItemCounts run_sweep(const SweepSpec& spec, const std::filesystem::path& folder,
                     const StudyOptions& options) {
  const std::vector<Cells> items = items_of(spec);
  std::vector<ResultsRun::Item> named;
  for (const Cells& item : items)
    named.push_back({id_of(item), static_cast<double>(item.count * spec.trials)});
  ResultsRun run(folder, named, options);
  run.find_keys([&](std::size_t i, const RunControl&) { return key_of_item(spec, items[i]); });
  const Json manifest = manifest_of(json_of(spec), {{"simulated", true},
                                                    {"skipped", spec.skipped},
                                                    {"cells", spec.cells.size()},
                                                    {"trials", spec.cells.size() * spec.trials},
                                                    {"inputs", Json::array()}});
  if (run.is_finished(manifest)) return run.tally();
  run.begin(manifest);
  run.compute([&](std::size_t i, const std::filesystem::path& into, const RunControl& control) {
    return compute(spec, items[i], into, control);
  });
  if (run.is_whole())
    run.publish_results(manifest, [&](const std::filesystem::path& into) {
      if (spec.time_problems > 0)
        time_into(into, spec, run.control("timing"));
      else
        gather_times(spec, items, run, into);
      const SweepSummary summary = summary_of(spec, items, run);
      const SweepTimings timings = read_json_file<SweepTimings>(into).value();
      store_tables(into, sweep_tables(summary, timings));
      write_json_file(into, StoredFigures{sweep_figures(summary, timings)});
      write_results(into, summary);
    });
  return run.tally();
}

}  // namespace trilat
