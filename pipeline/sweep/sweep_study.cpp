// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_study.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <optional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "datasets/results/results_file.h"
#include "datasets/results/timings.h"
#include "pipeline/claims/paper_claims.h"
#include "pipeline/study/machine.h"
#include "pipeline/study/parallel.h"
#include "pipeline/sweep/interpretation_search.h"
#include "pipeline/sweep/sweep_block.h"
#include "pipeline/sweep/sweep_plan.h"
#include "pipeline/sweep/sweep_summary.h"
#include "pipeline/sweep/sweep_tables.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kWarmUpProblems = 64;

double ns_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

// Nanoseconds a solve, of all problems of a cell.
struct Round {
  double scalar_ns = 0.0, batched_ns = 0.0;
};

class Stopwatch {
 public:
  Stopwatch(const SweepPlan& plan, const std::function<bool()>& stop_requested)
      : plan_(plan), stop_requested_(stop_requested) {}

  bool stopped() const { return stop_requested_ && stop_requested_(); }

  Round time(std::size_t cell, std::uint64_t problems) {
    const SweepCellSolver solver = solver_of(plan_, place_of(plan_, cell));
    SweepBlock block(solver.trials.sensors);
    Round round;
    for (std::uint64_t first = 0; first < problems && !stopped(); first += kBlockTrials) {
      block.make_trials(solver, first,
                        static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, problems - first)));
      const auto all = block.problems(solver);
      estimates_.resize(all.size());
      round.scalar_ns += scalar_ns(all, solver.options);
      const auto start = Clock::now();
      solve_nonlinear(all, solver.options, estimates_);
      round.batched_ns += ns_since(start);
    }
    round.scalar_ns /= static_cast<double>(problems);
    round.batched_ns /= static_cast<double>(problems);
    return round;
  }

 private:
  double scalar_ns(std::span<const RangeProblem> problems, const NonlinearOptions& options) {
    const auto start = Clock::now();
    for (std::size_t i = 0; i < problems.size(); ++i) estimates_[i] = solve_nonlinear(problems[i], options);
    return ns_since(start);
  }

  const SweepPlan& plan_;
  const std::function<bool()>& stop_requested_;
  std::vector<PointEstimate> estimates_;
};

SweepCellTiming timing_of(const SweepCellPlace& place, const std::vector<Round>& rounds) {
  std::vector<double> scalar_ns, batched_ns;
  for (const Round& round : rounds) {
    scalar_ns.push_back(round.scalar_ns);
    batched_ns.push_back(round.batched_ns);
  }
  return {place.reading,
          place.threshold,
          place.range,
          median(scalar_ns),
          *std::ranges::min_element(scalar_ns),
          median(batched_ns),
          *std::ranges::min_element(batched_ns)};
}

// Times the first time_problems trials of every cell on one thread: one at a time, and many side by side,
// each with its start. The cells take turns for time_repeats rounds, so that a busy moment of the machine
// hurts them alike. Nothing when interrupted.
std::optional<SweepTimings> time_sweep(const SweepPlan& plan, const std::function<bool()>& stop_requested,
                                       const std::function<void(double)>& progress) {
  const std::uint64_t problems = plan.spec.time_problems;
  if (progress) progress(0.0);
  Stopwatch stopwatch(plan, stop_requested);
  std::vector<std::vector<Round>> rounds(plan.cells());
  for (std::size_t cell = 0; cell < plan.cells(); ++cell)
    stopwatch.time(cell, std::min<std::uint64_t>(kWarmUpProblems, problems));
  for (std::uint64_t repeat = 0; repeat < plan.spec.time_repeats; ++repeat) {
    for (std::size_t cell = 0; cell < plan.cells(); ++cell) {
      rounds[cell].push_back(stopwatch.time(cell, problems));
      if (stopwatch.stopped()) return std::nullopt;
    }
    if (progress) progress(static_cast<double>(repeat + 1) / static_cast<double>(plan.spec.time_repeats));
  }
  SweepTimings timings{plan.spec.name, processor_name(), problems, plan.spec.time_repeats, {}};
  for (std::size_t cell = 0; cell < plan.cells(); ++cell)
    timings.cells.push_back(timing_of(place_of(plan, cell), rounds[cell]));
  return timings;
}

constexpr std::uint64_t kChunksAtOnce = 64;  // whose sums are in memory

// Sums of one chunk of one cell's trials.
SweepSums sums_of(const SweepPlan& plan, std::size_t cell, std::uint64_t chunk, const Watch& watch) {
  const SweepCellSolver solver = solver_of(plan, place_of(plan, cell));
  SweepBlock block(solver.trials.sensors);
  const std::uint64_t end = std::min((chunk + 1) * kChunkTrials, plan.spec.trials);
  SweepSums sums;
  for (std::uint64_t trial = chunk * kChunkTrials; trial < end; trial += kBlockTrials) {
    watch.check();
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, end - trial));
    block.make_trials(solver, trial, count);
    block.solve_into(solver, sums);
    if (trial < plan.spec.digits_trials)
      block.add_digits(solver, static_cast<std::size_t>(plan.spec.digits_trials - trial), sums);
  }
  return sums;
}

// The statistics of each cell.
Json compute(const SweepPlan& plan, const SweepItem& item, const Watch& watch) {
  const std::uint64_t per_cell = (plan.spec.trials + kChunkTrials - 1) / kChunkTrials;
  const std::uint64_t chunks = item.cells * per_cell;
  std::vector<SweepSums> of_cell(item.cells), sums(std::min(kChunksAtOnce, chunks));
  std::atomic<std::uint64_t> done{0};
  for (std::uint64_t first = 0; first < chunks; first += sums.size()) {
    const std::size_t count = std::min<std::uint64_t>(sums.size(), chunks - first);
    parallel_for_index(count, 1, [&](std::size_t i) {
      sums[i] = sums_of(plan, item.first_cell + (first + i) / per_cell, (first + i) % per_cell, watch);
      watch.tell(static_cast<double>(++done) / static_cast<double>(chunks));
    });
    watch.check();  // cancelled from outside, chunks are left out without a word
    for (std::size_t i = 0; i < count; ++i) of_cell[(first + i) / per_cell].add(sums[i]);
  }
  Json cells = Json::array();
  for (const SweepSums& cell : of_cell) cells.push_back(json_of(cell_of(cell)));
  return cells;
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
  if (plan.spec.search) s.search = search_interpretations(s, printed_table1());
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

void time_into(const std::filesystem::path& folder, const SweepPlan& plan, const Watch& watch) {
  const std::optional<SweepTimings> timings = time_sweep(plan, watch.stop_requested, watch.progress);
  if (!timings) throw Interrupted();
  write_beside(folder, *timings);
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
                 {"max_iterations", plan.spec.max_iterations},
                 {"digits_trials", plan.spec.digits_trials}});
}

Study sweep_study(const SweepPlan& whole) {
  const auto plan = std::make_shared<const SweepPlan>(whole);
  Study study{.kind = name_of(StudyKind::threshold_sweep),
              .settings = resolved_json(plan->spec),
              .reduce =
                  [plan](const Outcomes& outcomes, const std::filesystem::path& results, const Watch&) {
                    SweepSummary summary = summary_of(*plan, cells_of(*plan, outcomes));
                    summary.claims = claims_of(summary);
                    const auto timings = read_beside<SweepTimings>(results);
                    store_tables(results, sweep_tables(summary, timings));
                    write_beside(results, StoredFigures{sweep_figures(summary, timings)});
                    write_results(results, summary);
                  },
              .manifest = [plan] { return manifest_of_sweep(*plan); }};
  for (const SweepItem& item : items_of(*plan))
    study.items.push_back({item.id, static_cast<double>(trials_in(*plan, item)),
                           [plan, item](const std::filesystem::path&, const Watch& watch) {
                             return compute(*plan, item, watch);
                           },
                           [plan, item](const Watch&) { return key_of_item(*plan, item); }});
  if (plan->spec.time_problems > 0)
    study.time = [plan](const std::filesystem::path& folder, const Watch& watch) {
      time_into(folder, *plan, watch);
    };
  return study;
}

}  // namespace trilat
