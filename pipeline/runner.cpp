// SPDX-License-Identifier: MIT
#include "pipeline/runner.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/replay.h"
#include "datasets/results/samples.h"
#include "pipeline/over_time.h"
#include "pipeline/parallel.h"
#include "pipeline/replay_take.h"
#include "pipeline/take_data.h"
#include "pipeline/take_key.h"
#include "pipeline/tracking_check.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;    // instants gathered before they are solved together
constexpr std::uint64_t kTogether = 16;  // instants that one thread solves side by side
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

// What the rig saw during a block: per instant and joint, one observation a sensor.
struct Observations {
  std::size_t sensors = 0, joints = 0;
  std::vector<JointObservation> values;
  std::span<const JointObservation> of(std::uint64_t instant, std::size_t joint) const {
    return {&values[(instant * joints + joint) * sensors], sensors};
  }
};

void gather(const Plan& plan, const PlannedTake& planned, const TakeData& data, SampleBlock& block,
            Observations& seen) {
  for (std::uint64_t i = 0; i < block.instants; ++i) {
    const std::uint64_t instant = block.first_instant + i;
    block.time_ns[i] = data.time[instant].ns;
    block.heading_rad[i] = data.heading_rad[instant];
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      observe_joint(data, instant, plan.joints[j], planned.world_from_sensor,
                    std::span(seen.values).subspan((i * seen.joints + j) * seen.sensors, seen.sensors));
      const Eigen::Vector3d& truth = data.truth(instant, j, plan.joints.size());
      for (int axis = 0; axis < 3; ++axis)
        block.truth_m[(i * plan.joints.size() + j) * 3 + static_cast<std::size_t>(axis)] = truth[axis];
    }
  }
}

void store(SampleBlock& block, std::size_t slot, const PointEstimate& estimate) {
  for (int axis = 0; axis < 3; ++axis)
    block.estimate_m[slot * 3 + static_cast<std::size_t>(axis)] = estimate.position_m[axis];
  block.status[slot] = static_cast<std::uint8_t>(estimate.status);
  block.iterations[slot] = static_cast<std::uint32_t>(std::max(0, estimate.iterations));
  block.cost_m2[slot] = estimate.cost_m2;
  block.gdop[slot] = static_cast<float>(estimate.gdop);
}

// What a method over time gave, ready to be stored.
void store(const Plan& plan, const MethodPaths& paths, SampleBlock& block) {
  for (std::uint64_t i = 0; i < block.instants; ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const PathPoint& point = paths.at(block.first_instant + i, j);
      PointEstimate estimate = failed_estimate(point.status);
      estimate.position_m = point.position_m;
      estimate.iterations = point.iterations;
      store(block, (i * plan.joints.size() + j) * plan.methods.size() + paths.method, estimate);
    }
}

// How many sensors see the joint occluded: inferred, or crossed by a limb in front.
std::uint8_t occluded_views(const JointInstant& instant) {
  const auto& crossings = instant.occlusions[static_cast<std::size_t>(OcclusionRule::corrected)];
  std::uint8_t count = 0;
  for (std::size_t s = 0; s < instant.observations.size(); ++s)
    if (instant.observations[s].seen &&
        (instant.observations[s].state == TrackingState::inferred || crossings[s] > 0))
      ++count;
  return count;
}

// Every method that takes instants by themselves on a few of them, which are few enough to stay in the cache.
void solve_instants(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                    const Observations& seen, std::uint64_t first, std::uint64_t last, SampleBlock& block) {
  std::vector<JointInstant> instants;
  instants.reserve((last - first) * plan.joints.size());
  const std::uint64_t first_row = first * plan.joints.size();
  for (std::uint64_t i = first; i < last; ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const auto observations = seen.of(i, j);
      instants.push_back({observations, planned.world_from_sensor,
                          occlusions_of(data, block.first_instant + i, plan.joints[j]),
                          ranges_of(observations, planned.world_from_sensor)});
      const std::uint64_t row = first_row + instants.size() - 1;
      block.ranges[row] = static_cast<std::uint8_t>(instants.back().ranges.count);
      block.occluded[row] = occluded_views(instants.back());
    }
  std::vector<PointEstimate> estimates(instants.size());
  for (std::size_t m = 0; m < plan.methods.size(); ++m) {
    if (is_over_time(plan.methods[m])) continue;
    evaluate(plan.methods[m], instants, estimates);
    for (std::size_t k = 0; k < estimates.size(); ++k)
      store(block, (first_row + k) * plan.methods.size() + m, estimates[k]);
  }
}

// The method that is held against Ceres: the first nonlinear one with damping lm and the step rule.
const Method* checked_method(const Plan& plan) {
  for (const Method& m : plan.methods)
    if (m.spec.kind == MethodKind::nonlinear && m.spec.nonlinear.damping == Damping::lm &&
        m.spec.nonlinear.stop == StopRule::step && m.spec.nonlinear.loss == Loss::squares)
      return &m;
  return nullptr;
}

TakeCheck cross_check_instant(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                              const Observations& seen, std::uint64_t i, const Method& method,
                              std::uint64_t number) {
  TakeCheck check;
  for (std::size_t j = 0; j < plan.joints.size(); ++j) {
    const auto observations = seen.of(i, j);
    const SensorMask sensors = sensors_of(
        method, {observations, planned.world_from_sensor, occlusions_of(data, number, plan.joints[j]), {}});
    const RangeProblem ranges = ranges_of(observations, planned.world_from_sensor, sensors);
    const PointEstimate ours = solve_nonlinear(ranges, method.spec.nonlinear);
    const PointEstimate theirs = solve_ceres(ranges, method.spec.ceres);
    TakeCheck one;
    one.worst_at = fmt::format("{} instant {} {}", planned.take.id, number, name_of(plan.joints[j]));
    if (is_usable(ours.status) && is_usable(theirs.status)) {
      one.samples = 1;
      one.worst_m = (ours.position_m - theirs.position_m).norm();
    } else if (is_usable(ours.status) != is_usable(theirs.status)) {
      one.disagreements = 1;
      one.disagreed_at = one.worst_at;
    }
    check.merge(one);
  }
  return check;
}

// Places are given from the campaign's folder, so that results do not depend on where they were computed.
TakeNote within_campaign(TakeNote note, const Campaign& campaign) {
  const std::string folder = campaign.folder.empty() ? "" : (campaign.folder / "").string();
  for (std::string* text : {&note.place, &note.text})
    for (auto at = text->find(folder); !folder.empty() && at != std::string::npos; at = text->find(folder))
      text->erase(at, folder.size());
  return note;
}

// How much the progress counts a take.
std::uint64_t work_of(const Plan& plan, std::size_t take) {
  return plan.takes[take].instants * (1 + kWindowedWork * windowed_methods(plan));
}

std::filesystem::path take_folder(const RunPlace& place, const PlannedTake& planned) {
  return place.folder / "takes" / planned.take.id;
}

// Solves the take block by block into `samples`.
void solve_take(Shared& shared, const PlannedTake& planned, const TakeData& data,
                const std::vector<MethodPaths>& paths, SamplesFile& samples, TakeResult& result) {
  const Plan& plan = shared.plan;
  const Method* checked = shared.options.cross_check ? checked_method(plan) : nullptr;
  SampleBlock block;
  Observations seen{plan.rig.size(), plan.joints.size(), {}};
  for (std::uint64_t first = 0; first < planned.instants; first += kBlock) {
    if (shared.must_stop()) throw Interrupted();
    const std::uint64_t count = std::min(kBlock, planned.instants - first);
    block.reset(first, count, plan.joints.size(), plan.methods.size());
    seen.values.resize(count * seen.joints * seen.sensors);
    std::vector<TakeCheck> checks(checked ? count : 0);
    {
      const Stopwatch watch(shared.solve_ns);
      gather(plan, planned, data, block, seen);
      parallel_for_index((count + kTogether - 1) / kTogether, 1, [&](std::size_t part) {
        const std::uint64_t from = part * kTogether, to = std::min(count, from + kTogether);
        solve_instants(plan, planned, data, seen, from, to, block);
        for (std::uint64_t i = from; checked && i < to; ++i)
          checks[i] = cross_check_instant(plan, planned, data, seen, i, *checked, first + i);
      });
      for (const MethodPaths& path : paths) store(plan, path, block);
    }
    for (const TakeCheck& check : checks) result.check.merge(check);
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
  take.result.notes = {
      within_campaign({plan.takes[index].take.id, true, error.place(), error.problem()}, plan.campaign)};
  return take;
}

EvaluatedTake run_take(Shared& shared, std::size_t index) {
  const Plan& plan = shared.plan;
  const PlannedTake& planned = plan.takes[index];
  std::vector<TakeInput> inputs =
      inputs_of(planned.take, shared.place.hashes, [&] { return shared.must_stop(); });
  try {
    if (!planned.ok) throw InputError(planned.place, planned.problem);
    EvaluatedTake take;
    take.key = key_of_take(plan, index, inputs, shared.options.cross_check);
    if (const auto found = shared.place.items.find(planned.take.id, take.key)) {
      take.result = read_take_result(found->outcome, (found->folder / "items.json").string());
      take.folder = found->folder == shared.place.folder ? take_folder(shared.place, planned) : found->folder;
      shared.advance(work_of(plan, index));
      return take;
    }
    check_memory(plan, planned, shared.options.memory_bytes);
    take.folder = take_folder(shared.place, planned);
    take.result = evaluate_take(shared, index, take.folder);
    take.result.inputs = std::move(inputs);
    for (TakeNote& note : take.result.notes) note = within_campaign(note, plan.campaign);
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
