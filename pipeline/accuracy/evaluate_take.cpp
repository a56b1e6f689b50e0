// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/evaluate_take.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/brought/brought_joints.h"
#include "pipeline/accuracy/take/angle_errors.h"
#include "pipeline/accuracy/take/left_out.h"
#include "pipeline/accuracy/take/solve_block.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;  // instants gathered before they are solved together
// What an instant of a windowed method counts in the progress, where one of all others together counts 1.
constexpr std::uint64_t kWindowedWork = 5;

class TakeProgress {
 public:
  TakeProgress(const Plan& plan, std::size_t take, std::size_t tracks, const Watch& watch)
      : watch_(watch),
        total_(plan.takes[take].instants * tracks * (1 + kWindowedWork * windowed_methods(plan))) {}
  void advance(std::uint64_t work) {
    watch_.tell(static_cast<double>(done_ += work) / static_cast<double>(total_));
  }

 private:
  const Watch& watch_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
};

void append(std::vector<TakeNote>& notes, std::vector<TakeNote> more) {
  std::ranges::move(more, std::back_inserter(notes));
}

// What estimates are held against: the mocap, or each sensor in turn.
std::vector<std::string> tracks_of(const Plan& plan, const PlannedTake& planned) {
  return planned.truth == TakeTruth::left_out_sensor ? plan.rig : std::vector<std::string>{"mocap"};
}

// Solves one track of a take, block by block, into `file`.
class TrackSolver {
 public:
  TrackSolver(const Plan& plan, const PlannedTake& planned, bool cross_check, StoredTake& file,
              StageClocks& clocks, const Watch& watch, TakeProgress& progress, TakeResult& result)
      : plan_(plan),
        planned_(planned),
        cross_check_(cross_check),
        file_(file),
        clocks_(clocks),
        watch_(watch),
        progress_(progress),
        result_(result) {}

  // `brought`: paths of what the take brings.
  void solve(std::size_t track, const TakeData& data, std::vector<MethodPaths> brought) const {
    std::vector<MethodPaths> paths = paths_of(data);
    for (MethodPaths& path : brought) paths.push_back(std::move(path));
    SampleBlock block;
    std::optional<Predictions> predictions;
    AngleErrors angles(file_.head(), planned_.take.participant, planned_.level);
    if (planned_.truth == TakeTruth::left_out_sensor) predictions.emplace(plan_, planned_, track);
    for (std::uint64_t first = 0; first < planned_.instants; first += kBlock) {
      watch_.check();
      const std::uint64_t count = std::min(kBlock, planned_.instants - first);
      block.reset(first, count, plan_.joints.size(), plan_.methods.size());
      solve(data, paths, block);
      if (predictions)
        predictions->add(block);
      else
        angles.add(block);
      const Stopwatch time(clocks_.write_ns);
      file_.write(track, block);
      progress_.advance(count);
    }
    if (!predictions) {
      result_.tracking.angles = angles.sums();
      return;
    }
    std::vector<PredictionSums>& all = result_.tracking.predictions;
    for (PredictionSums& sums : predictions->sums()) all.push_back(std::move(sums));
  }

 private:
  std::vector<MethodPaths> paths_of(const TakeData& data) const {
    const Stopwatch time(clocks_.solve_ns);
    const auto advanced = [&](std::size_t instants) { progress_.advance(kWindowedWork * instants); };
    return solve_over_time(plan_, planned_, data, {advanced, [&] { return watch_.stopped(); }});
  }
  void solve(const TakeData& data, const std::vector<MethodPaths>& paths, SampleBlock& block) const {
    const Stopwatch time(clocks_.solve_ns);
    const auto checks = solve_block(plan_, planned_, data, paths, cross_check_, block);
    result_.checks.resize(checks.size());
    for (std::size_t m = 0; m < checks.size(); ++m) result_.checks[m].merge(checks[m]);
  }

  const Plan& plan_;
  const PlannedTake& planned_;
  bool cross_check_;
  StoredTake& file_;
  StageClocks& clocks_;
  const Watch& watch_;
  TakeProgress& progress_;
  TakeResult& result_;
};

RecordedTake read(const Plan& plan, const PlannedTake& planned, StageClocks& clocks, const Watch& watch) {
  const Stopwatch time(clocks.read_ns);
  return read_take(plan, planned, watch.stop_requested);
}

std::vector<double> since_start_s(const PlannedTake& planned, const std::vector<HostTime>& time) {
  std::vector<double> since_s;
  for (const HostTime t : time) since_s.push_back((t - planned.start).seconds());
  return since_s;
}

// Reads what the take brings and holds it against the truth at these instants, by instant and name.
std::vector<MethodPaths> paths_brought(const Plan& plan, const PlannedTake& planned,
                                       const std::vector<double>& since_s,
                                       const std::vector<Eigen::Vector3d>& truth_m,
                                       std::vector<TakeNote>& notes) {
  std::vector<MethodPaths> paths;
  if (planned.take.joints.empty()) return paths;
  std::vector<PointPath> truth(plan.names.size(), {since_s, {}});
  for (std::size_t k = 0; k < truth_m.size(); ++k)
    truth[k % plan.names.size()].position_m.push_back(truth_m[k]);
  for (BroughtTrack& brought : read_brought(plan, planned)) {
    if (!truth_m.empty()) append(notes, check_brought(plan, planned, truth.data(), brought));
    paths.push_back(paths_of(plan, brought, since_s));
  }
  return paths;
}

// What the sensors say with none left out.
TakeTracking tracking_of(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  TakeTracking tracking{data.checks, data.clock, rays_of(plan, planned, data)};
  tracking.clock.take = planned.take.id;
  return tracking;
}

// Names the sensors that cannot be the truth because they track no joint that is asked for. InputError when
// none can.
std::vector<TakeNote> notes_on_silent(const Plan& plan, const PlannedTake& planned, const TakeData& data) {
  std::vector<TakeNote> notes;
  for (std::size_t s = 0; s < plan.rig.size(); ++s) {
    bool tracks = false;
    for (std::size_t i = 0; i < data.time.size(); ++i)
      for (const Joint joint : plan.joints)
        tracks |= data.bodies.at(i, s).state[static_cast<std::size_t>(joint)] == TrackingState::tracked;
    if (!tracks)
      notes.push_back({planned.take.id, false, planned.take.session.string(),
                       "sensor \"" + plan.rig[s] +
                           "\" never tracks a joint that is asked for, so that nothing is predicted of it"});
  }
  if (notes.size() == plan.rig.size())
    throw InputError(planned.take.session.string(), "no sensor ever tracks a joint that is asked for");
  return notes;
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
  head.joints = plan.names;
  for (const Method& method : plan.methods) head.methods.push_back(method.spec.name);
  head.tracks = tracks_of(plan, planned);
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
      }
    }
  return replay;
}

}  // namespace

namespace {

// A take without a session: nothing is solved.
EvaluatedTake evaluate_brought(const Plan& plan, const PlannedTake& planned, const ErrorSettings& errors,
                               const std::filesystem::path& folder, StageClocks& clocks, const Watch& watch) {
  EvaluatedTake evaluated;
  std::vector<double> since_s;
  for (std::uint64_t i = 0; i < planned.instants; ++i) since_s.push_back(plan.instant(i).seconds());
  std::vector<Eigen::Vector3d> truth_m(planned.instants * plan.names.size());
  std::vector<MethodPaths> paths;
  std::vector<TakeNote>& notes = evaluated.result.notes;
  {
    const Stopwatch time(clocks.read_ns);
    const MarkerTrack truth = truth_of_points(plan, planned);
    for (std::uint64_t i = 0; i < planned.instants; ++i)
      truth.at(MocapTime{} + plan.instant(i),
               std::span(truth_m).subspan(i * plan.names.size(), plan.names.size()));
    for (std::string& text : oddities_of(truth))
      notes.push_back({planned.take.id, false, planned.take.mocap.string(), std::move(text)});
    for (std::string& text : points_left_out(planned.take, plan.names))
      notes.push_back({planned.take.id, false, planned.take.mapping.string(), std::move(text)});
    if (planned.truth_has_z_up)
      notes.push_back(
          {planned.take.id, false, planned.take.mocap.string(),
           "has its z axis up: all files of the take are turned so that y is up, and x, y, z of the "
           "tables are the files' x, z, -y"});
    if (!planned.level)
      notes.push_back({planned.take.id, false, planned.take.mocap.string(),
                       "neither states nor shows which axis is up: its own axes are used"});
    paths = paths_brought(plan, planned, since_s, truth_m, notes);
  }
  StoredTake file = StoredTake::create(folder / StoredTake::kName, head_of(plan, planned));
  AngleErrors angles(file.head(), planned.take.participant, planned.level);
  if (angles.lacks_up())
    notes.push_back({planned.take.id, false, planned.take.mocap.string(),
                     "trunk inclination is left out, which needs the axis that points up; say which it is"});
  SampleBlock block;
  for (std::uint64_t first = 0; first < planned.instants; first += kBlock) {
    watch.check();
    const std::uint64_t count = std::min(kBlock, planned.instants - first);
    block.reset(first, count, plan.names.size(), plan.methods.size());
    for (std::uint64_t i = 0; i < count; ++i) {
      block.time_ns[i] = (planned.start + plan.instant(first + i)).ns;
      for (std::size_t j = 0; j < plan.names.size(); ++j)
        Eigen::Map<Eigen::Vector3d>(&block.truth_m[(i * plan.names.size() + j) * 3]) =
            truth_m[(first + i) * plan.names.size() + j];
    }
    std::ranges::fill(block.status, static_cast<std::uint8_t>(SolveStatus::no_observation));
    for (const MethodPaths& path : paths) store_path(plan, path, block);
    angles.add(block);
    const Stopwatch time(clocks.write_ns);
    file.write(0, block);
    watch.tell(static_cast<double>(first + count) / static_cast<double>(planned.instants));
  }
  evaluated.errors = write_errors(file, errors, clocks);
  file.finish();
  evaluated.result.tracking.angles = angles.sums();
  evaluated.result.evaluated = true;
  return evaluated;
}

}  // namespace

EvaluatedTake evaluate_take(const Plan& plan, std::size_t take, const ErrorSettings& errors, bool cross_check,
                            const std::filesystem::path& folder, StageClocks& clocks, const Watch& watch) {
  const PlannedTake& planned = plan.takes[take];
  if (plan.rig.empty()) return evaluate_brought(plan, planned, errors, folder, clocks, watch);
  const bool leaves_out = planned.truth == TakeTruth::left_out_sensor;
  EvaluatedTake evaluated;
  TakeResult& result = evaluated.result;
  RecordedTake recorded = read(plan, planned, clocks, watch);
  TakeData followed = follow_person(plan, planned, recorded, watch.stop_requested);
  const TakeData all = see_take(plan, planned, leaves_out ? followed : std::move(followed),
                                recorded.truth.get(), std::nullopt, watch.stop_requested);
  result.tracking = tracking_of(plan, planned, all);
  result.notes = all.notes;
  if (leaves_out) append(result.notes, notes_on_silent(plan, planned, all));
  StoredTake file = StoredTake::create(folder / StoredTake::kName, head_of(plan, planned));
  TakeProgress progress(plan, take, file.head().tracks.size(), watch);
  const std::vector<MethodPaths> brought =
      paths_brought(plan, planned, since_start_s(planned, all.time),
                    leaves_out ? std::vector<Eigen::Vector3d>{} : all.truth_m, result.notes);
  const TrackSolver solver(plan, planned, cross_check, file, clocks, watch, progress, result);
  for (std::size_t track = 0; track < file.head().tracks.size(); ++track)
    if (leaves_out)
      solver.solve(track, see_take(plan, planned, followed, nullptr, track, watch.stop_requested), brought);
    else
      solver.solve(track, all, brought);
  evaluated.errors = write_errors(file, errors, clocks);
  if (is_replayed(plan, take)) file.write_replay(replay_of(plan, planned, all));
  file.finish();
  result.evaluated = true;
  return evaluated;
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
  for (std::size_t track = 0; track < there.head().tracks.size(); ++track)
    for (std::uint64_t first = 0; first < there.head().instants; first += kBlock) {
      there.read(track, first, std::min(kBlock, there.head().instants - first), SampleColumns::all, block);
      copy.write(track, block);
    }
  errors = errors_of(there, settings);
  copy.write_errors(errors);
  if (const std::optional<Replay> replay = there.read_replay()) copy.write_replay(*replay);
  copy.finish();
  store.put(aside.path() / "item", {item->id, item->key, item->outcome, {}});
  return errors;
}

}  // namespace trilat
