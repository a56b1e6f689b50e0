// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_study.h"

#include <algorithm>
#include <atomic>
#include <map>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/results/results_file.h"
#include "datasets/results/studies/sweep_summary.h"
#include "datasets/results/studies/sweep_timings.h"
#include "pipeline/study/parallel.h"
#include "pipeline/sweep/interpretation_search.h"
#include "pipeline/sweep/sweep_block.h"
#include "pipeline/sweep/sweep_timing.h"
#include "pipeline/sweep/sweep_totals.h"

namespace trilat {
namespace {

constexpr std::uint64_t kChunksAtOnce = 64;  // whose sums are in memory

// Trials of one cell that are computed by one thread.
struct Chunk {
  std::size_t cell = 0;
  std::uint64_t first_trial = 0, end_trial = 0;
};

Chunk chunk_of(const SweepPlan& plan, const SweepItem& item, std::uint64_t number) {
  const std::uint64_t of_row = item.first_chunk + number, per_cell = chunks_per_cell(plan);
  const std::uint64_t first = of_row % per_cell * kChunkTrials;
  return {item.first_cell + of_row / per_cell, first, std::min(first + kChunkTrials, plan.spec.trials)};
}

SweepSums sums_of(const SweepPlan& plan, const Chunk& chunk, SweepBlocks& blocks, const Watch& watch) {
  const SweepCellSolver solver = solver_of(plan, place_of(plan, chunk.cell));
  std::unique_ptr<SweepBlock> block = blocks.take(solver.trials.sensors);
  SweepSums sums;
  for (std::uint64_t trial = chunk.first_trial; trial < chunk.end_trial; trial += kBlockTrials) {
    watch.check();
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(kBlockTrials, chunk.end_trial - trial));
    block->make_trials(solver, trial, count);
    block->solve_into(solver, sums);
    if (trial < plan.spec.digits_trials)
      block->add_digits(solver, static_cast<std::size_t>(plan.spec.digits_trials - trial), sums);
  }
  blocks.give_back(std::move(block));
  return sums;
}

bool is_whole(const SweepPlan& plan, const SweepTotals& totals) {
  return totals.counts.asked == plan.spec.trials;
}

// Of each cell its statistics, or its sums where the item has only some of its trials.
Json compute(const SweepPlan& plan, const SweepItem& item, SweepBlocks& blocks, const Watch& watch) {
  std::map<std::size_t, SweepTotals> totals;
  std::vector<SweepSums> sums(std::min<std::uint64_t>(kChunksAtOnce, item.chunks));
  std::atomic<std::uint64_t> done{0};
  for (std::uint64_t first = 0; first < item.chunks; first += sums.size()) {
    const std::size_t count = std::min<std::uint64_t>(sums.size(), item.chunks - first);
    parallel_for_index(count, 1, [&](std::size_t i) {
      sums[i] = sums_of(plan, chunk_of(plan, item, first + i), blocks, watch);
      watch.tell(static_cast<double>(++done) / static_cast<double>(item.chunks));
    });
    for (std::size_t i = 0; i < count; ++i) totals[chunk_of(plan, item, first + i).cell].add(sums[i]);
  }
  Json cells = Json::array();
  for (const auto& [cell, of_cell] : totals)
    cells.push_back(is_whole(plan, of_cell) ? Json{{"cell", json_of(of_cell.cell())}}
                                            : Json{{"totals", json_of(of_cell)}});
  return cells;
}

// Puts together what items hold of the same cells.
class SharedCells {
 public:
  SharedCells(const SweepPlan& plan, std::size_t count) : plan_(plan), cells_(count) {}

  void add(const SweepItem& item, const Outcome& outcome) {
    const Json json = outcome.json();
    const std::size_t first = chunk_of(plan_, item, 0).cell - item.first_cell;
    const std::size_t end = chunk_of(plan_, item, item.chunks - 1).cell - item.first_cell + 1;
    if (!json.is_array() || json.size() != end - first)
      throw InputError(outcome.place(), fmt::format("must be what the item has of {} cells", end - first));
    for (std::size_t c = first; c < end; ++c)
      add(cells_[c], JsonObject(json[c - first], outcome.place(), fmt::format("/{}", c - first)));
  }
  // `place`: of the last item, for errors.
  void append_to(std::vector<SweepCell>& cells, const std::string& place) const {
    for (const Cell& cell : cells_) {
      const SweepCell& finished = cells.emplace_back(
          with_place(plan_, cell.finished ? *cell.finished : cell.totals.cell(), cells.size()));
      if (finished.asked != plan_.spec.trials)
        throw InputError(place, "and the items before it do not add up to the trials of their cells");
    }
  }

 private:
  struct Cell {
    SweepTotals totals;
    std::optional<SweepCell> finished;
  };
  static void add(Cell& cell, JsonObject object) {
    if (object.has("cell")) {
      JsonObject finished = object.object("cell");
      cell.finished = read_sweep_cell(finished);
    } else {
      cell.totals.add(read_sweep_totals(object.object("totals")));
    }
    object.finish();
  }

  const SweepPlan& plan_;
  std::vector<Cell> cells_;
};

std::vector<SweepCell> cells_of(const SweepPlan& plan, const Outcomes& outcomes, const Watch& watch) {
  std::vector<SweepCell> cells;
  const std::vector<SweepItem> items = items_of(plan);
  for (std::size_t i = 0; i < items.size();) {
    watch.check();
    SharedCells shared(plan, items[i].cells);
    const std::size_t first_cell = items[i].first_cell;
    std::string place;
    for (; i < items.size() && items[i].first_cell == first_cell; ++i) {
      const auto outcome = outcomes.find(items[i].id);
      if (outcome == outcomes.end()) throw InputError(plan.spec.name, "has no item " + items[i].id);
      shared.add(items[i], outcome->second);
      place = outcome->second.place();
    }
    shared.append_to(cells, place);
    watch.tell(static_cast<double>(i) / static_cast<double>(items.size()));
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
  write_sweep_timings(folder, *timings);
}

}  // namespace

std::uint64_t chunks_per_cell(const SweepPlan& plan) {
  return (plan.spec.trials + kChunkTrials - 1) / kChunkTrials;
}

std::uint64_t trials_in(const SweepPlan& plan, const SweepItem& item) {
  std::uint64_t trials = item.chunks * kChunkTrials;
  const std::uint64_t per_cell = chunks_per_cell(plan), short_by = per_cell * kChunkTrials - plan.spec.trials;
  trials -= short_by * ((item.first_chunk + item.chunks) / per_cell - item.first_chunk / per_cell);
  return trials;
}

std::vector<SweepItem> items_of(const SweepPlan& plan) {
  const std::size_t ranges = plan.spec.ranges.size(), thresholds = plan.spec.thresholds.size();
  const bool by_threshold = ranges * plan.spec.trials >= kFewTrials;
  const std::size_t cells = by_threshold ? ranges : ranges * thresholds;
  const std::uint64_t chunks = cells * chunks_per_cell(plan),
                      all_chunks = plan.cells() * chunks_per_cell(plan);
  const std::uint64_t most = std::max(kItemTrials / kChunkTrials, all_chunks / kMostSweepItems + 1);
  const std::uint64_t pieces = (chunks + most - 1) / most;
  std::vector<SweepItem> items;
  for (std::size_t cell = 0; cell < plan.cells(); cell += cells)
    for (std::uint64_t k = 0; k < pieces; ++k) {
      const SweepCellPlace place = place_of(plan, cell);
      const std::uint64_t first = chunks * k / pieces, end = chunks * (k + 1) / pieces;
      items.push_back({fmt::format("trials/r{}-c{}-{}", place.reading + 1, place.threshold + 1, k + 1), cell,
                       cells, first, end - first});
    }
  return items;
}

std::string key_of_item(const SweepPlan& plan, const SweepItem& item) {
  const SweepCellPlace place = place_of(plan, item.first_cell);
  const SweepInterpretation& reading = plan.readings[place.reading].text;
  Json ranges_m = Json::array(), thresholds = Json::array();
  for (const SweepSummary::ErrorRange& range : plan.spec.ranges)
    ranges_m.push_back({range.low_m, range.high_m});
  for (std::size_t t = 0; t < item.cells / plan.spec.ranges.size(); ++t)
    thresholds.push_back(plan.spec.thresholds[place.threshold + t]);
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
                 {"thresholds", thresholds},
                 {"ranges_m", ranges_m},
                 {"chunks", {item.first_chunk, item.chunks}},
                 {"seed", plan.spec.seed},
                 {"trials", plan.spec.trials},
                 {"max_iterations", plan.spec.max_iterations},
                 {"digits_trials", plan.spec.digits_trials}});
}

// The study has its ranges rounded for people.
Json sweep_work(const SweepPlan& plan) {
  Json ranges_m = Json::array();
  for (const auto& range : plan.spec.ranges) ranges_m.push_back({range.low_m, range.high_m});
  return {{"study", resolved_json(plan.spec)}, {"ranges_m", ranges_m}};
}

SweepPlan plan_of_work(const Json& work, const std::string& place) {
  JsonObject object(work, place, "/work");
  SweepSpec spec = parse_sweep(object.value("study"), place);
  const Json& ranges_m = object.value("ranges_m");
  if (!ranges_m.is_array() || ranges_m.size() != spec.ranges.size())
    object.refuse("ranges_m", "must be one range for each of the study's");
  for (std::size_t i = 0; i < spec.ranges.size(); ++i) {
    const Json& range = ranges_m[i];
    if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number())
      object.refuse("ranges_m", "must be pairs of numbers");
    spec.ranges[i] = {range[0].get<double>(), range[1].get<double>()};
  }
  object.finish();
  return make_sweep_plan(spec, place);
}

Study sweep_study(const SweepPlan& whole) {
  const auto plan = std::make_shared<const SweepPlan>(whole);
  const auto blocks = std::make_shared<SweepBlocks>();
  Study study{.kind = name_of(StudyKind::threshold_sweep),
              .work = sweep_work(*plan),
              .reduce =
                  [plan](const Outcomes& outcomes, const std::filesystem::path& results, const Watch& watch) {
                    write_sweep_summary(results, summary_of(*plan, cells_of(*plan, outcomes, watch)));
                  },
              .manifest = [plan](const Outcomes&) { return manifest_of_sweep(*plan); }};
  for (const SweepItem& item : items_of(*plan))
    study.items.push_back({item.id, static_cast<double>(trials_in(*plan, item)),
                           [plan, blocks, item](const std::filesystem::path&, const Watch& watch) {
                             return compute(*plan, item, *blocks, watch);
                           },
                           [plan, item](const Watch&) { return key_of_item(*plan, item); }});
  if (plan->spec.time_problems > 0)
    study.time = [plan](const std::filesystem::path& folder, const std::filesystem::path&,
                        const Watch& watch) { time_into(folder, *plan, watch); };
  return study;
}

}  // namespace trilat
