// SPDX-License-Identifier: MIT
#include "pipeline/runner.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <numeric>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
#include "pipeline/over_time.h"
#include "pipeline/parallel.h"
#include "pipeline/replay_take.h"
#include "pipeline/solve_block.h"
#include "pipeline/take_data.h"
#include "pipeline/take_folder.h"
#include "pipeline/take_key.h"
#include "pipeline/tracking_check.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;  // instants gathered before they are solved together
// What an instant of a windowed method counts in the progress, where one of all others together counts 1.
constexpr std::uint64_t kWindowedWork = 30;

class Stopwatch {
 public:
  explicit Stopwatch(std::atomic<std::int64_t>& total_ns) : total_ns_(total_ns) {}
  ~Stopwatch() { total_ns_ += (std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::atomic<std::int64_t>& total_ns_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

struct Shared {
  const Plan& plan;
  const RunPlace& place;
  const RunOptions& options;
  std::uint64_t total_work = 0;
  std::atomic<std::uint64_t> done_work{0};
  std::atomic<bool> stopped{false};
  std::atomic<std::int64_t> read_ns{0}, solve_ns{0}, write_ns{0};

  bool must_stop() {
    if (options.stop_requested && options.stop_requested()) stopped = true;
    return stopped;
  }
  void advance(std::uint64_t work) {
    const std::uint64_t done = done_work += work;
    if (options.progress) options.progress(static_cast<double>(done) / static_cast<double>(total_work));
  }
};

void replace_all(std::string& text, const std::string& old, const std::string& with) {
  if (old.empty() || old == with) return;
  for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
    text.replace(at, old.size(), with);
}

// From the campaign's folder; the name alone where the file lies elsewhere.
std::string place_of(const std::filesystem::path& file, const std::filesystem::path& folder) {
  const std::filesystem::path inside = file.lexically_normal().lexically_relative(folder.lexically_normal());
  return inside.empty() || *inside.begin() == ".." ? file.filename().string() : inside.string();
}

// Results do not depend on where they were computed.
TakeNote within_campaign(TakeNote note, const Take& take, const Campaign& campaign) {
  for (std::string* text : {&note.place, &note.text})
    for (const TakeFile& file : files_of(take))
      replace_all(*text, file.path.string(), place_of(file.path, campaign.folder));
  return note;
}

// How much the progress counts a take.
std::uint64_t work_of(const Plan& plan, std::size_t take) {
  return plan.takes[take].instants * (1 + kWindowedWork * windowed_methods(plan));
}

// Solves the take block by block into `samples`.
void solve_take(Shared& shared, const PlannedTake& planned, const TakeData& data,
                const std::vector<MethodPaths>& paths, SamplesFile& samples, TakeResult& result) {
  const Plan& plan = shared.plan;
  SampleBlock block;
  for (std::uint64_t first = 0; first < planned.instants; first += kBlock) {
    if (shared.must_stop()) throw Interrupted();
    const std::uint64_t count = std::min(kBlock, planned.instants - first);
    block.reset(first, count, plan.joints.size(), plan.methods.size());
    {
      const Stopwatch watch(shared.solve_ns);
      result.check.merge(solve_block(plan, planned, data, paths, shared.options.cross_check, block));
    }
    {
      const Stopwatch watch(shared.write_ns);
      samples.write(0, block);
    }
    shared.advance(count);
  }
}

// Leaves the take's samples and replay in `folder`.
TakeResult evaluate_take(Shared& shared, std::size_t index, const std::filesystem::path& folder) {
  const Plan& plan = shared.plan;
  const PlannedTake& planned = plan.takes[index];
  const auto must_stop = [&] { return shared.must_stop(); };
  TakeResult result;
  TakeData data;
  {
    const Stopwatch watch(shared.read_ns);
    data = load_take(plan, planned, must_stop);
  }
  std::vector<MethodPaths> paths;
  {
    const Stopwatch watch(shared.solve_ns);
    const auto advanced = [&](std::size_t instants) { shared.advance(kWindowedWork * instants); };
    paths = solve_over_time(plan, planned, data, {advanced, must_stop});
  }
  std::filesystem::remove_all(folder);
  make_folder(folder);
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(plan, std::array{index}));
  solve_take(shared, planned, data, paths, samples, result);
  samples.finish();
  result.tracking = check_tracking(plan, planned, data);
  if (is_replayed(plan, index)) write_replay(folder, std::array{replay_of(plan, index, data)});
  result.notes = std::move(data.notes);
  result.evaluated = true;
  return result;
}

EvaluatedTake failed_take(const Plan& plan, std::size_t index, const InputError& error,
                          std::vector<TakeInput> inputs) {
  EvaluatedTake take;
  take.result.inputs = std::move(inputs);
  take.result.notes = {within_campaign({plan.takes[index].take.id, true, error.place(), error.problem()},
                                       plan.takes[index].take, plan.campaign)};
  return take;
}

EvaluatedTake run_take(Shared& shared, std::size_t index) {
  const Plan& plan = shared.plan;
  const PlannedTake& planned = plan.takes[index];
  std::vector<TakeInput> inputs =
      inputs_of(planned.take, shared.place.hashes, [&] { return shared.must_stop(); });
  try {
    if (!planned.ok) throw InputError(planned.place, planned.problem);
    for (const TakeInput& input : inputs)
      if (input.sha256.empty()) throw InputError(input.file, "cannot be read to its end");
    EvaluatedTake take;
    take.key = key_of_take(plan, index, inputs, shared.options.cross_check);
    const auto holds = [&](const ItemStore::Found& there) { return holds_take(plan, index, there.folder); };
    if (const auto found = shared.place.items.find(planned.take.id, take.key, holds)) {
      shared.place.inputs.at(index).check();
      // left by a run with other settings, it would pass for this take's if tidying up failed
      if (found->folder != shared.place.folder)
        std::filesystem::remove_all(own_folder(shared.place.folder, planned.take.id));
      take.result = read_take_result(found->outcome, (found->folder / "items.json").string());
      take.folder = folder_of_take(found->folder, planned.take.id);
      shared.advance(work_of(plan, index));
      return take;
    }
    check_memory(plan, planned, shared.options.memory_bytes);
    take.folder = own_folder(shared.place.folder, planned.take.id);
    take.result = evaluate_take(shared, index, take.folder);
    shared.place.inputs.at(index).check();
    take.result.inputs = std::move(inputs);
    for (TakeNote& note : take.result.notes) note = within_campaign(note, planned.take, plan.campaign);
    shared.place.items.add(planned.take.id, take.key, json_of(take.result));
    return take;
  } catch (const OutputError&) {
    throw;
  } catch (const InputError& error) {
    return failed_take(plan, index, error, std::move(inputs));
  }
}

}  // namespace

SamplesHeader samples_header(const Plan& plan, std::span<const std::size_t> takes) {
  SamplesHeader header;
  for (Joint joint : plan.joints) header.joints.emplace_back(name_of(joint));
  for (const Method& method : plan.methods) header.methods.push_back(method.spec.name);
  for (int s = 0; s < kSolveStatusCount; ++s)
    header.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  header.alignment = name_of(plan.study.alignments.front());
  for (const std::size_t t : takes) {
    const PlannedTake& take = plan.takes[t];
    header.takes.push_back({take.take.id, take.instants, take.take.activity});
  }
  return header;
}

SamplesHeader samples_header(const Plan& plan) {
  std::vector<std::size_t> all(plan.takes.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return samples_header(plan, all);
}

void check_cross_check(const Plan& plan) {
  if (!checked_method(plan))
    throw InputError(
        "study \"" + plan.study.name + '"',
        "has no nonlinear method with damping lm and stop step that could be checked against Ceres");
}

TakesRun run_takes(const Plan& plan, std::span<const std::size_t> takes, const RunPlace& place,
                   const RunOptions& options) {
  if (options.cross_check) check_cross_check(plan);
  Shared shared{plan, place, options};
  for (const std::size_t t : takes) shared.total_work += work_of(plan, t);
  TakesRun run;
  run.takes.resize(plan.takes.size());
  std::atomic<std::size_t> next{0};
  // no more takes at once than fit into the memory; threads without one help with the takes of others
  parallel_for_index(takes_at_once(plan, options.memory_bytes), 1, [&](std::size_t) {
    for (std::size_t k; !shared.must_stop() && (k = next++) < takes.size();) try {
        run.takes[takes[k]] = run_take(shared, takes[k]);
      } catch (const Interrupted&) {
        shared.stopped = true;
      } catch (...) {
        shared.stopped = true;
        throw;
      }
  });
  if (shared.stopped) throw Interrupted();
  const auto seconds = [](const std::atomic<std::int64_t>& ns) {
    return static_cast<double>(ns.load()) * 1e-9;
  };
  run.times = {seconds(shared.read_ns), seconds(shared.solve_ns), seconds(shared.write_ns), 0.0};
  return run;
}

RunOutcome outcome_of(const Plan& plan, std::span<const EvaluatedTake> takes, bool cross_check) {
  RunOutcome outcome;
  TakeCheck check;
  std::vector<TakeTracking> tracking;
  for (const EvaluatedTake& take : takes) {
    tracking.push_back(take.result.tracking);
    outcome.notes.insert(outcome.notes.end(), take.result.notes.begin(), take.result.notes.end());
    outcome.evaluated.push_back(take.result.evaluated);
    check.merge(take.result.check);
  }
  outcome.tracking = sum_tracking(plan, tracking);
  if (cross_check)
    outcome.cross_check = CrossCheck{checked_method(plan)->spec.name,
                                     check.samples,
                                     check.disagreements,
                                     check.worst_m,
                                     plan.study.cross_check_limit_m,
                                     check.disagreements > 0 ? check.disagreed_at : check.worst_at};
  return outcome;
}

}  // namespace trilat
