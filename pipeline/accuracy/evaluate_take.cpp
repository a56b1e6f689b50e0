// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/evaluate_take.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/stored_take.h"
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

// Solves the take block by block into `file`.
void solve_take(const Plan& plan, const PlannedTake& planned, const TakeData& data,
                const std::vector<MethodPaths>& paths, bool cross_check, StoredTake& file,
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
      file.write(block);
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

ErrorTable write_errors(StoredTake& file, const ErrorSettings& settings, StageClocks& clocks) {
  ErrorTable errors;
  {
    const Stopwatch time(clocks.summarise_ns);
    errors = errors_of(file, settings);
  }
  const Stopwatch time(clocks.write_ns);
  file.write_errors(errors);
  return errors;
}

TakeHead head_of(const Plan& plan, const PlannedTake& planned) {
  TakeHead head;
  head.id = planned.take.id;
  head.condition = planned.take.activity;
  head.instants = planned.instants;
  for (const Joint joint : plan.joints) head.joints.emplace_back(name_of(joint));
  for (const Method& method : plan.methods) head.methods.push_back(method.spec.name);
  for (int s = 0; s < kSolveStatusCount; ++s)
    head.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  return head;
}

// The first part of a take as every sensor sees it, in the world.
Replay replay_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  Replay replay;
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

}  // namespace

EvaluatedTake evaluate_take(const Plan& plan, std::size_t take, const ErrorSettings& errors, bool cross_check,
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
  StoredTake file = StoredTake::create(folder / StoredTake::kName, head_of(plan, planned));
  solve_take(plan, planned, data, paths, cross_check, file, clocks, watch, progress, result);
  ErrorTable table = write_errors(file, errors, clocks);
  if (is_replayed(plan, take)) file.write_replay(replay_of(plan, planned, data));
  file.finish();
  result.notes = std::move(data.notes);
  result.evaluated = true;
  return {std::move(result), std::move(table)};
}

bool is_replayed(const Plan& plan, std::size_t take) {
  const auto first = std::ranges::find_if(plan.takes, [&](const PlannedTake& other) {
    return other.ok && other.take.activity == plan.takes[take].take.activity;
  });
  return first == plan.takes.begin() + static_cast<std::ptrdiff_t>(take);
}

ErrorTable stored_errors(const ItemStore& store, const std::string& key, const ErrorSettings& settings) {
  const StoredTake there = StoredTake::open(store.folder(key) / StoredTake::kName);
  ErrorTable errors = there.read_errors();
  if (errors.settings_sha256 == settings.sha256()) return errors;
  std::optional<StoredItem> item = store.find(key);
  if (!item) throw InputError(store.folder(key).string(), "was removed while it was read");
  const ItemStore::Aside aside(store);
  make_folder(aside.path() / "item");
  StoredTake copy = StoredTake::create(aside.path() / "item" / StoredTake::kName, there.head());
  SampleBlock block;
  for (std::uint64_t first = 0; first < there.head().instants; first += kBlock) {
    there.read(first, std::min(kBlock, there.head().instants - first), SampleColumns::all, block);
    copy.write(block);
  }
  errors = errors_of(there, settings);
  copy.write_errors(errors);
  if (const std::optional<Replay> replay = there.read_replay()) copy.write_replay(*replay);
  copy.finish();
  store.put(aside.path() / "item", {item->id, item->key, item->outcome, {}});
  return errors;
}

}  // namespace trilat
