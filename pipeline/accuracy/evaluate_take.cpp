// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/evaluate_take.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/replay.h"
#include "pipeline/accuracy/statistics/take_statistics.h"
#include "pipeline/accuracy/take/left_out.h"
#include "pipeline/accuracy/take/solve_block.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/accuracy/take/tracking_check.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;  // instants gathered before they are solved together
// What an instant of a windowed method counts in the progress, where one of all others together counts 1.
constexpr std::uint64_t kWindowedWork = 5;

class TakeProgress {
 public:
  TakeProgress(const Plan& plan, std::size_t take, const Watch& watch)
      : watch_(watch), total_(plan.takes[take].instants * (1 + kWindowedWork * windowed_methods(plan))) {}
  void advance(std::uint64_t work) {
    watch_.tell(static_cast<double>(done_ += work) / static_cast<double>(total_));
  }

 private:
  const Watch& watch_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
};

// Solves the take block by block into `samples`.
void solve_take(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                const std::vector<MethodPaths>& paths, bool cross_check, SamplesFile& samples,
                StageClocks& clocks, const Watch& watch, TakeProgress& progress, TakeResult& result) {
  SampleBlock block;
  Predictions predictions(plan, planned);
  for (std::uint64_t first = 0; first < planned.instants; first += kBlock) {
    watch.check();
    const std::uint64_t count = std::min(kBlock, planned.instants - first);
    block.reset(first, count, plan.joints.size(), plan.methods.size());
    {
      const Stopwatch time(clocks.solve_ns);
      const auto checks = solve_block(plan, planned, data, paths, cross_check, block);
      result.checks.resize(checks.size());
      for (std::size_t m = 0; m < checks.size(); ++m) result.checks[m].merge(checks[m]);
      predictions.add(block);
    }
    {
      const Stopwatch time(clocks.write_ns);
      samples.write(0, block);
    }
    progress.advance(count);
  }
  result.tracking.predictions = predictions.sums();
}

// What the sensors say with none left out; of takes that differ in that alone the first says it for all.
TakeTracking tracking_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  if (!speaks_for_take(plan, planned)) return {};
  TakeTracking tracking = check_tracking(plan, planned, data);
  tracking.rays = rays_of(plan, planned, data);
  tracking.corrections = correction_rows(plan, planned, data);
  return tracking;
}

TakeData load(const Plan& plan, const PlannedTake& planned, StageClocks& clocks, const Watch& watch) {
  const Stopwatch time(clocks.read_ns);
  return load_take(plan, planned, watch.stop_requested);
}

std::vector<MethodPaths> paths_of(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                                  StageClocks& clocks, const Watch& watch, TakeProgress& progress) {
  const Stopwatch time(clocks.solve_ns);
  const auto advanced = [&](std::size_t instants) { progress.advance(kWindowedWork * instants); };
  return solve_over_time(plan, planned, data, {advanced, [&] { return watch.stopped(); }});
}

TakeSummary summarised(const Plan& plan, SamplesFile& samples, StageClocks& clocks) {
  const Stopwatch time(clocks.summarise_ns);
  return summarise_take(samples, statistics_layout(plan), &samples);
}

}  // namespace

EvaluatedTake evaluate_take(const Plan& plan, std::size_t take, bool cross_check,
                            const std::filesystem::path& folder, StageClocks& clocks, const Watch& watch) {
  const PlannedTake& planned = plan.takes[take];
  TakeProgress progress(plan, take, watch);
  TakeData data = load(plan, planned, clocks, watch);
  TakeResult result;
  find_corrections(plan, planned, data);
  result.tracking = tracking_of(plan, planned, data);
  for (TakeNote& note : correction_notes(planned, result.tracking.corrections))
    data.notes.push_back(std::move(note));
  leave_out(plan, planned, data);
  if (!planned.take.left_out.empty()) find_corrections(plan, planned, data);  // without the sensor
  estimate_sigmas(plan, planned, data);
  const std::vector<MethodPaths> paths = paths_of(plan, planned, data, clocks, watch, progress);
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", samples_header(plan, planned));
  solve_take(plan, planned, data, paths, cross_check, samples, clocks, watch, progress, result);
  TakeSummary summary = summarised(plan, samples, clocks);
  samples.finish();
  if (is_replayed(plan, take)) write_replay(folder, replay_of(plan, planned, data));
  result.notes = std::move(data.notes);
  result.evaluated = true;
  return {folder, std::move(result), std::move(summary)};
}

bool is_replayed(const Plan& plan, std::size_t take) {
  const auto first = std::ranges::find_if(plan.takes, [&](const PlannedTake& other) {
    return other.ok && other.take.activity == plan.takes[take].take.activity;
  });
  return first == plan.takes.begin() + static_cast<std::ptrdiff_t>(take);
}

ReplayTake replay_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  ReplayTake replay;
  replay.id = planned.take.id;
  replay.condition = planned.take.activity;
  replay.sensors = plan.rig;
  replay.world_from_sensor = planned.world_from_sensor;
  const auto most = static_cast<std::uint64_t>(kReplay_s * plan.study.rate_hz);
  replay.reset(std::min<std::uint64_t>(most, data.time.size()), plan.rig.size());
  std::size_t slot = 0;
  for (std::uint64_t i = 0; i < replay.instants; ++i)
    for (std::size_t s = 0; s < plan.rig.size(); ++s) {
      const ObservedBody& body = data.bodies.at(i, s);
      for (std::size_t j = 0; j < kJointCount; ++j, ++slot) {
        if (!body.has(j)) continue;
        const Eigen::Vector3d joint_m =
            planned.world_from_sensor[s] * body.joint_in_sensor_m[j].cast<double>();
        for (int axis = 0; axis < 3; ++axis)
          replay.joint_m[slot * 3 + static_cast<std::size_t>(axis)] = static_cast<float>(joint_m[axis]);
        replay.state[slot] = static_cast<std::uint8_t>(body.state[j]);
      }
    }
  return replay;
}

}  // namespace trilat
