// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_study.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "datasets/results/timings.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/study/machine.h"
#include "pipeline/study/parallel.h"
#include "pipeline/sweep/sweep_block.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/sweep/sweep_summary.h"
#include "pipeline/sweep/sweep_tables.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

double us_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

// Microseconds a solve of the first problems of a cell, one after the other, each with its start.
double scalar_us(const SweepPlan& plan, std::size_t cell) {
  const SweepCellSolver solver = solver_of(plan, place_of(plan, cell));
  SweepBlock block(solver.trials.sensors);
  std::vector<PointEstimate> estimates(kBlockTrials);
  double us = 0.0;
  for (std::uint64_t first = 0; first < plan.spec.time_problems; first += kBlockTrials) {
    const std::uint64_t left = plan.spec.time_problems - first;
    block.make_trials(solver, first, static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, left)));
    const auto problems = block.problems(solver);
    const auto start = Clock::now();
    for (std::size_t i = 0; i < problems.size(); ++i)
      estimates[i] = solve_nonlinear(problems[i], solver.options);
    us += us_since(start);
  }
  return us / static_cast<double>(plan.spec.time_problems);
}

// Times every cell on one thread by the scalar solver; of three rounds over all cells the fastest counts, so
// that a busy moment of the machine spoils none.
void time_into(const std::filesystem::path& folder, const SweepPlan& plan, const Watch& watch) {
  constexpr std::size_t kRounds = 3;
  SweepTimings timings{plan.spec.name, processor_name(), plan.spec.time_problems, {}};
  timings.solve_us.assign(plan.cells(), std::numeric_limits<double>::infinity());
  for (std::size_t round = 0; round < kRounds; ++round)
    for (std::size_t cell = 0; cell < plan.cells(); ++cell) {
      watch.check();
      timings.solve_us[cell] = std::min(timings.solve_us[cell], scalar_us(plan, cell));
      watch.tell(static_cast<double>(round * plan.cells() + cell + 1) /
                 static_cast<double>(kRounds * plan.cells()));
    }
  write_beside(folder, timings);
}

constexpr std::uint64_t kChunksAtOnce = 64;  // whose sums are in memory

// One chunk of one cell's trials.
struct Chunk {
  SweepSums sums;
  double us = 0.0;  // that solving them took
  void add(const Chunk& later) {
    sums.add(later.sums);
    us += later.us;
  }
};

Chunk solve_chunk(const SweepPlan& plan, std::size_t cell, std::uint64_t chunk, const Watch& watch) {
  const SweepCellSolver solver = solver_of(plan, place_of(plan, cell));
  SweepBlock block(solver.trials.sensors);
  const std::uint64_t end = std::min((chunk + 1) * kChunkTrials, plan.spec.trials);
  Chunk solved;
  for (std::uint64_t trial = chunk * kChunkTrials; trial < end; trial += kBlockTrials) {
    watch.check();
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, end - trial));
    const auto start = Clock::now();
    block.make_trials(solver, trial, count);
    block.solve_into(solver, solved.sums);
    solved.us += us_since(start);
  }
  return solved;
}

// The statistics of each cell; how long its trials took is left in the item's folder.
Json compute(const SweepPlan& plan, const SweepItem& item, const std::filesystem::path& into,
             const Watch& watch) {
  const std::uint64_t per_cell = (plan.spec.trials + kChunkTrials - 1) / kChunkTrials;
  const std::uint64_t chunks = item.cells * per_cell;
  std::vector<Chunk> of_cell(item.cells), solved(std::min(kChunksAtOnce, chunks));
  std::atomic<std::uint64_t> done{0};
  for (std::uint64_t first = 0; first < chunks; first += solved.size()) {
    const std::size_t count = std::min<std::uint64_t>(solved.size(), chunks - first);
    parallel_for_index(count, 1, [&](std::size_t i) {
      solved[i] = solve_chunk(plan, item.first_cell + (first + i) / per_cell, (first + i) % per_cell, watch);
      watch.tell(static_cast<double>(++done) / static_cast<double>(chunks));
    });
    watch.check();  // cancelled from outside, chunks are left out without a word
    for (std::size_t i = 0; i < count; ++i) of_cell[(first + i) / per_cell].add(solved[i]);
  }
  Json cells = Json::array();
  SweepTimings timings{plan.spec.name, processor_name(), 0, {}};
  for (const Chunk& cell : of_cell) {
    cells.push_back(json_of(cell_of(cell.sums)));
    timings.solve_us.push_back(cell.us / static_cast<double>(plan.spec.trials));
  }
  write_beside(into, timings);
  return cells;
}

// The times of all items' trials, as the runs that solved them took them.
void gather_times(const SweepPlan& plan, const Outcomes& outcomes, const std::filesystem::path& folder) {
  SweepTimings all{plan.spec.name, processor_name(), 0, {}};
  for (const SweepItem& item : items_of(plan)) {
    const auto of_item = read_beside<SweepTimings>(outcomes.at(item.id).folder);
    for (std::size_t cell = 0; cell < item.cells; ++cell)
      all.solve_us.push_back(of_item ? of_item->solve_us.at(cell) : SweepCell::kNone);
  }
  write_beside(folder, all);
}

std::vector<SweepCell> cells_of(const SweepPlan& plan, const Outcomes& outcomes) {
  std::vector<SweepCell> cells;
  for (const SweepItem& item : items_of(plan)) {
    const auto found = outcomes.find(item.id);
    if (found == outcomes.end()) throw InputError(plan.spec.name, "has no item " + item.id);
    const Json json = found->second.json;
    const std::string place = found->second.place();
    if (!json.is_array() || json.size() != item.cells)
      throw InputError(place, fmt::format("must be a list of {} cells", item.cells));
    for (std::size_t c = 0; c < item.cells; ++c) {
      const JsonObject object(json[c], place, fmt::format("/{}", c));
      const SweepCell& cell = cells.emplace_back(with_place(plan, read_as<SweepCell>(object), cells.size()));
      if (cell.asked != plan.spec.trials)
        object.refuse("asked", fmt::format("must be {}, the trials of the study", plan.spec.trials));
    }
  }
  return cells;
}

SweepSummary summary_of(const SweepPlan& plan, std::vector<SweepCell> cells) {
  SweepSummary s;
  s.study = plan.spec.name;
  s.seed = plan.spec.seed;
  s.trials = plan.spec.trials;
  s.max_iterations = plan.spec.max_iterations;
  s.skipped = plan.skipped;
  s.thresholds = plan.spec.thresholds;
  s.ranges = plan.spec.ranges;
  for (const SweepReading& reading : plan.readings) s.interpretations.push_back(reading.text);
  s.cells = std::move(cells);
  return s;
}

Json manifest_of_sweep(const SweepPlan& plan) {
  return manifest_of(resolved_json(plan.spec), {{"simulated", true},
                                                {"interpretations", plan.readings.size()},
                                                {"skipped", plan.skipped},
                                                {"cells", plan.cells()},
                                                {"trials", plan.cells() * plan.spec.trials},
                                                {"inputs", Json::array()}});
}

}  // namespace

std::uint64_t trials_in(const SweepPlan& plan, const SweepItem& item) {
  return item.cells * plan.spec.trials;
}

std::vector<SweepItem> items_of(const SweepPlan& plan) {
  const std::size_t ranges = plan.spec.ranges.size();
  const std::size_t together =
      ranges * plan.spec.trials >= kFewTrials ? ranges : ranges * plan.spec.thresholds.size();
  const std::size_t most =
      static_cast<std::size_t>(std::max<std::uint64_t>(1, kItemTrials / plan.spec.trials));
  std::vector<SweepItem> items;
  for (std::size_t begin = 0; begin < plan.cells(); begin += together)
    for (std::size_t cell = begin; cell < begin + together; cell += most) {
      const SweepCellPlace place = place_of(plan, cell);
      items.push_back(
          {fmt::format("trials/r{}-c{}-{}", place.reading + 1, place.threshold + 1, place.range + 1), cell,
           std::min(most, begin + together - cell)});
    }
  return items;
}

std::string key_of_item(const SweepPlan& plan, const SweepItem& item) {
  const SweepCellPlace place = place_of(plan, item.first_cell);
  const SweepInterpretation& reading = plan.readings[place.reading].text;
  Json cells = Json::array();
  for (std::size_t cell = item.first_cell; cell < item.first_cell + item.cells; ++cell) {
    const SweepCellPlace of_cell = place_of(plan, cell);
    const SweepSummary::ErrorRange& range = plan.spec.ranges[of_cell.range];
    cells.push_back({plan.spec.thresholds[of_cell.threshold], range.low_m, range.high_m});
  }
  return key_of({{"kind", "trials of a threshold sweep"},
                 {"sensors_m", reading.sensors_m},
                 {"joint", reading.joint},
                 {"error_model", reading.error_model},
                 {"threshold_unit", reading.threshold_unit},
                 {"gradient", reading.gradient},
                 {"curvature", reading.curvature},
                 {"stop", reading.stop},
                 {"damping", reading.damping},
                 {"start", reading.start},
                 {"cells", cells},
                 {"seed", plan.spec.seed},
                 {"trials", plan.spec.trials},
                 {"max_iterations", plan.spec.max_iterations}});
}

Study sweep_study(const SweepPlan& whole) {
  const auto plan = std::make_shared<const SweepPlan>(whole);
  Study study{.kind = name_of(StudyKind::threshold_sweep),
              .settings = resolved_json(plan->spec),
              .reduce =
                  [plan](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                    SweepSummary summary = summary_of(*plan, cells_of(*plan, outcomes));
                    summary.claims = claims_of(summary);
                    if (plan->spec.time_problems == 0) gather_times(*plan, outcomes, results);
                    const SweepTimings timings = read_beside<SweepTimings>(results).value();
                    store_tables(results, sweep_tables(summary, timings));
                    write_beside(results, StoredFigures{sweep_figures(summary, timings)});
                    write_results(results, summary);
                  },
              .manifest = [plan] { return manifest_of_sweep(*plan); }};
  for (const SweepItem& item : items_of(*plan))
    study.items.push_back({item.id, static_cast<double>(trials_in(*plan, item)),
                           [plan, item](const std::filesystem::path& into, const Watch& watch) {
                             return compute(*plan, item, into, watch);
                           },
                           [plan, item](const Watch&) { return key_of_item(*plan, item); }});
  if (plan->spec.time_problems > 0)
    study.time = [plan](const std::filesystem::path& folder, const Watch& watch) {
      time_into(folder, *plan, watch);
    };
  return study;
}

}  // namespace trilat
