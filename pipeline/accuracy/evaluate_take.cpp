// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/evaluate_take.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/results/stored_take.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

constexpr std::uint64_t kBlock = 256;  // instants that are copied together

void append(std::vector<TakeNote>& notes, std::vector<TakeNote> more) {
  std::ranges::move(more, std::back_inserter(notes));
}

// The truths that estimates are held against: the mocap, or each sensor in turn.
std::vector<std::string> tracks_of(const Plan& plan, const PlannedTake& planned) {
  return planned.truth == TakeTruth::left_out_sensor ? plan.rig : std::vector<std::string>{"mocap"};
}

// Reads what the take brings and holds it against the truth, by instant and name.
std::vector<MethodTrajectories> paths_external(const Plan& plan, const PlannedTake& planned,
                                               const PreparedTake& data, std::vector<TakeNote>& notes) {
  std::vector<MethodTrajectories> paths;
  if (planned.take.joints.empty()) return paths;
  std::vector<double> since_s;
  for (const HostTime t : data.time) since_s.push_back((t - planned.start).seconds());
  std::vector<PointPath> truth(plan.names.size(), {since_s, {}});
  for (std::size_t k = 0; k < data.truth_m.size(); ++k)
    truth[k % plan.names.size()].position_m.push_back(data.truth_m[k]);
  for (ExternalTrack& external : read_external(plan, planned)) {
    if (planned.truth == TakeTruth::mocap)
      append(notes, check_external(plan, planned, truth.data(), external));
    paths.push_back(paths_of(plan, external, since_s));
  }
  return paths;
}

// The checks and disagreements of a take with all its sensors.
TakeTracking tracking_of(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  TakeTracking tracking{data.checks, data.clock, estimate_ray_noise(plan, planned, data)};
  tracking.clock.take = planned.take.id;
  tracking.rules = judge_rules(plan, planned, data);
  if (planned.truth == TakeTruth::mocap) tracking.bounds = bounds_of(plan, planned, data);
  return tracking;
}

// Names the sensors that cannot be the truth because they track no joint that is asked for. InputError when
// none can.
std::vector<TakeNote> notes_on_silent(const Plan& plan, const PlannedTake& planned,
                                      const PreparedTake& data) {
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

TakeHead head_of(const Plan& plan, const PlannedTake& planned) {
  TakeHead head;
  head.id = planned.take.id;
  head.condition = planned.take.activity;
  head.instants = planned.instants;
  head.joints = plan.names;
  for (const Method& method : plan.methods) head.methods.push_back(method.spec.name);
  head.tracks = tracks_of(plan, planned);
  head.is_upright = planned.level;
  if (planned.truth == TakeTruth::left_out_sensor)
    for (const RigidTransform& sensor : planned.world_from_sensor)
      head.track_position_m.push_back(
          {sensor.translation_m.x(), sensor.translation_m.y(), sensor.translation_m.z()});
  for (int s = 0; s < kSolveStatusCount; ++s)
    head.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  return head;
}

// A take as methods see it, and the joints that it brings.
struct ViewedTake {
  PreparedTake all;     // by all sensors; without sensors the instants and their truth alone
  PersonTake followed;  // of a take whose sensors are left out in turn
  std::vector<MethodTrajectories> external;
};

ViewedTake view_session_take(const Plan& plan, const PlannedTake& planned, const RunControl& control,
                             TakeResult& result) {
  const bool leaves_out = planned.truth == TakeTruth::left_out_sensor;
  RecordedTake recorded = read_take(plan, planned, control.stop_requested);
  ViewedTake seen;
  PersonTake followed = select_person(plan, planned, recorded);
  if (leaves_out) seen.followed = followed;
  seen.all =
      view_take(plan, planned, std::move(followed), recorded.truth, std::nullopt, control.stop_requested);
  result.tracking = tracking_of(plan, planned, seen.all);
  result.notes = seen.all.notes;
  if (leaves_out) append(result.notes, notes_on_silent(plan, planned, seen.all));
  seen.external = paths_external(plan, planned, seen.all, result.notes);
  return seen;
}

// A take without a session: its truth, and what it brings.
ViewedTake view_joint_take(const Plan& plan, const PlannedTake& planned, TakeResult& result) {
  ViewedTake seen;
  PreparedTake& data = seen.all;
  data.heading_rad.assign(planned.instants, std::numeric_limits<float>::quiet_NaN());
  data.truth_m.resize(planned.instants * plan.names.size());
  const MarkerTrack truth = truth_of_points(plan, planned);
  for (std::uint64_t i = 0; i < planned.instants; ++i) {
    data.time.push_back(planned.start + plan.instant(i));
    truth.at(MocapTime{} + plan.instant(i),
             std::span(data.truth_m).subspan(i * plan.names.size(), plan.names.size()));
  }
  const auto note = [&](const std::filesystem::path& place, std::string text) {
    result.notes.push_back({planned.take.id, false, place.string(), std::move(text)});
  };
  const std::filesystem::path& mocap = planned.take.mocap;
  for (std::string& text : suspicious_names(truth)) note(mocap, std::move(text));
  for (std::string& text : unmatched_points(planned.take, plan.names))
    note(planned.take.mapping, std::move(text));
  if (planned.truth_has_z_up)
    note(mocap,
         "has its z axis up, as stated: x, y, z of the tables are the x, z, -y of all files of the take");
  seen.external = paths_external(plan, planned, data, result.notes);
  return seen;
}

}  // namespace

TakeResult evaluate_take(const Plan& plan, std::size_t take, const ErrorSettings& errors, bool cross_check,
                         const std::filesystem::path& folder, const RunControl& control) {
  const PlannedTake& planned = plan.takes[take];
  TakeResult result;
  const ViewedTake seen = plan.rig.empty() ? view_joint_take(plan, planned, result)
                                           : view_session_take(plan, planned, control, result);
  StoredTake file = StoredTake::create(folder / StoredTake::kName, head_of(plan, planned));
  result.checks.resize(cross_check ? checked_methods(plan).size() : 0);
  const auto solve = [&](std::size_t track, const PreparedTake& prepared) {
    const double share = 1.0 / static_cast<double>(file.head().tracks.size());
    const RunControl part{control.stop_requested,
                          share_of(control.progress, share * static_cast<double>(track), share)};
    const std::vector<TakeCheck> checks =
        solve_take(plan, planned, prepared, seen.external, cross_check, part,
                   [&](const SampleBlock& block) { file.write(track, block); });
    for (std::size_t m = 0; m < checks.size(); ++m) result.checks[m].merge(checks[m]);
  };
  if (planned.truth == TakeTruth::left_out_sensor)
    for (std::size_t s = 0; s < plan.rig.size(); ++s)
      solve(s, view_take(plan, planned, seen.followed, std::nullopt, s, control.stop_requested));
  else
    solve(0, seen.all);
  file.write_errors(errors_of(file, errors));
  file.finish();
  result.evaluated = true;
  return result;
}

TakeErrors stored_errors(const ItemStore& store, const std::string& key, const ErrorSettings& settings) {
  const StoredTake there = StoredTake::open(store.folder(key) / StoredTake::kName);
  TakeErrors errors = there.read_errors();
  if (errors.settings_sha256 == settings.sha256()) return errors;
  std::optional<StoredItem> item = store.find(key);
  if (!item) throw InputError(store.folder(key).string(), "was removed while it was read");
  const ItemStore::StagingFolder aside(store);
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
  copy.finish();
  store.put(aside.path() / "item", {item->id, item->key, item->outcome, {}});
  return errors;
}

}  // namespace trilat
