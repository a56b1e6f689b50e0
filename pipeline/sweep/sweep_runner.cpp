// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_runner.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "pipeline/sweep/sweep_cell_key.h"
#include "pipeline/sweep/sweep_wave.h"

namespace trilat {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double kFirstSave_s = 0.25;

class Runner {
 public:
  Runner(const SweepPlan& plan, const SweepRunOptions& options)
      : plan_(plan),
        options_(options),
        chunks_per_cell_(chunks_per_cell(plan)),
        stripe_(stripe_of(plan, options.shard)),
        wave_(plan, options.stop_requested) {}

  SweepRun run() {
    place_cells();
    if (options_.log != nullptr) restore();
    chunks_done_ = turn_;
    while (!result_.interrupted && fill_wave()) {
      wave_.compute([&] { show_progress(); });
      add_in_order();
      if (options_.log != nullptr && is_time_to_save()) save();
    }
    if (result_.interrupted) {
      if (is_open_) result_.cells[open_.cell] = with_place(plan_, open_.totals.cell(), open_.cell);
    } else {
      close();
      reuse_until(plan_.cells());
    }
    if (options_.log != nullptr) save();
    return std::move(result_);
  }

 private:
  std::uint64_t first_turn(std::size_t cell) const { return stripe_.turns_before(cell * chunks_per_cell_); }
  std::uint64_t turns_in(std::size_t cell) const { return chunks_in_cell(plan_, stripe_, cell); }

  void place_cells() {
    earlier_.resize(plan_.cells());
    for (std::size_t c = 0; c < plan_.cells(); ++c) {
      result_.cells.push_back(with_place(plan_, {}, c));
      if (options_.earlier) earlier_[c] = options_.earlier(c);
    }
  }

  // The next cell of which the shard has a share and no record.
  void skip_others_cells() {
    while (next_cell_ < plan_.cells() && turns_in(next_cell_) == 0) ++next_cell_;
  }

  bool is_next(const SweepRecord& record) {
    skip_others_cells();
    return record.cell == next_cell_ && next_cell_ < plan_.cells() && record.shard == options_.shard &&
           record.key == key_of_cell(plan_, next_cell_);
  }

  void restore() {
    options_.log->restore([&](SweepRecord&& record) {
      if (!is_next(record) || (!record.reused && record.chunks != turns_in(record.cell))) return false;
      if (!record.reused) result_.tally.continued.push_back(record.cell);
      finish(record);
      return true;
    });
    turn_ = first_turn(next_cell_);
    std::optional<SweepRecord> open = options_.log->open_cell();
    if (!open || !is_next(*open) || earlier_[open->cell] != nullptr || open->reused ||
        open->chunks > turns_in(open->cell))
      return;
    turn_ += open->chunks;
    open_ = std::move(*open);
    is_open_ = true;
    result_.tally.continued.push_back(open_.cell);
  }

  bool fill_wave() {
    wave_.clear();
    while (!wave_.full() && turn_ < stripe_.turns()) {
      const std::uint64_t chunk = stripe_.chunk(turn_);
      const std::size_t cell = chunk / chunks_per_cell_;
      if (earlier_[cell] != nullptr) {
        chunks_done_ += first_turn(cell + 1) - turn_;
        turn_ = first_turn(cell + 1);
        continue;
      }
      wave_.add(cell, chunk % chunks_per_cell_ * kChunkTrials);
      ++turn_;
    }
    return !wave_.empty();
  }

  void show_progress() {
    const std::uint64_t done = ++chunks_done_;
    if (options_.progress)
      options_.progress(static_cast<double>(done) / static_cast<double>(stripe_.turns()));
  }

  // Chunks of one cell follow each other, so only one cell is open at a time.
  void add_in_order() {
    for (std::size_t i = 0; i < wave_.count(); ++i) {
      result_.interrupted = !wave_[i].done;
      if (result_.interrupted) return;
      open(wave_[i].cell);
      open_.totals.add(wave_[i].sums);
      ++open_.chunks;
    }
  }

  void open(std::size_t cell) {
    if (is_open_ && open_.cell == cell) return;
    close();
    reuse_until(cell);
    open_ = {cell, key_of_cell(plan_, cell), options_.shard, 0, {}, {}};
    is_open_ = true;
    result_.tally.computed.push_back(cell);
  }

  void close() {
    if (!is_open_) return;
    is_open_ = false;
    finish(open_);
    if (options_.log != nullptr) options_.log->add(open_);
  }

  // All cells before this one that are still missing are those of earlier results.
  void reuse_until(std::size_t cell) {
    for (skip_others_cells(); next_cell_ < cell; skip_others_cells()) {
      const SweepRecord record{next_cell_, key_of_cell(plan_, next_cell_), options_.shard, 0,
                               {},         *earlier_[next_cell_]};
      finish(record);
      if (options_.log != nullptr) options_.log->add(record);
    }
  }

  void finish(const SweepRecord& record) {
    const std::size_t c = record.cell;
    next_cell_ = c + 1;
    result_.cells[c] = with_place(plan_, record.reused ? record.reused->cell : record.totals.cell(), c);
    if (record.reused) result_.tally.reused[record.reused->from].push_back(c);
  }

  bool is_time_to_save() const { return Seconds(Clock::now() - saved_at_).count() >= save_after_s_; }

  void save() {
    options_.log->save(is_open_ ? &open_ : nullptr);
    saved_at_ = Clock::now();
    save_after_s_ = std::min(2.0 * save_after_s_, options_.save_every_s);
  }

  const SweepPlan& plan_;
  const SweepRunOptions& options_;
  const std::uint64_t chunks_per_cell_;
  const SweepStripe stripe_;
  SweepWave wave_;
  std::vector<const SweepRecord::Reused*> earlier_;
  SweepRun result_;
  std::uint64_t turn_ = 0;     // the next to be computed
  std::size_t next_cell_ = 0;  // the first that is neither finished nor another's
  SweepRecord open_;
  bool is_open_ = false;
  std::atomic<std::uint64_t> chunks_done_{0};
  Clock::time_point saved_at_ = Clock::now();
  double save_after_s_ = std::min(kFirstSave_s, options_.save_every_s);
};

}  // namespace

std::size_t SweepTally::reused_count() const {
  std::size_t count = 0;
  for (const auto& [folder, cells] : reused) count += cells.size();
  return count;
}

std::uint64_t chunks_per_cell(const SweepPlan& plan) {
  return (plan.spec.trials + kChunkTrials - 1) / kChunkTrials;
}

SweepStripe stripe_of(const SweepPlan& plan, const Shard& shard) {
  return {shard.whole() ? Shard{1, 1} : shard, plan.cells() * chunks_per_cell(plan)};
}

std::uint64_t chunks_in_cell(const SweepPlan& plan, const SweepStripe& stripe, std::size_t cell) {
  const std::uint64_t chunks = chunks_per_cell(plan);
  return stripe.turns_before((cell + 1) * chunks) - stripe.turns_before(cell * chunks);
}

SweepRun run_sweep(const SweepPlan& plan, const SweepRunOptions& options) {
  return Runner(plan, options).run();
}

}  // namespace trilat
