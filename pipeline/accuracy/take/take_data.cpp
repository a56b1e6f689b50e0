// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/take_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/bodies/exchange_repair.h"
#include "evaluators/bodies/occlusion.h"
#include "pipeline/accuracy/take/sensor_track.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/accuracy/take/truth_track.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kTogether = 64;  // instants that one thread looks at for occlusions

// Notes on the truth's axes and oddities.
std::vector<TakeNote> notes_on_truth(const PlannedTake& planned, const SampledTruth& truth) {
  std::vector<TakeNote> notes;
  const auto note = [&](std::string text) {
    notes.push_back({planned.take.id, false, planned.take.mocap.string(), std::move(text)});
  };
  for (const std::string& text : truth.oddities) note(text);
  return notes;
}

// Puts the truth where the clock's offset says.
void apply_clock(const Plan& plan, const PlannedTake& planned, const std::function<bool()>& stop_requested,
                 PreparedTake& data) {
  data.clock.applied = true;
  data.truth_m =
      sample_truth(plan, planned, duration_from_s(data.clock.offset_s), false, stop_requested).at_instants_m;
}

void append(TakeChecks more, PersonTake& data) {
  std::ranges::move(more.rows, std::back_inserter(data.checks));
  std::ranges::move(more.notes, std::back_inserter(data.notes));
}

// The chosen person's bodies, or those that are tracked best when no person is chosen.
BodyTracks follow(const Plan& plan, const PlannedTake& planned, const RigBodies& seen,
                  const PersonChoice* person, const std::vector<HostTime>& time) {
  const Duration gap = duration_from_s(plan.study.sensor_gap_s);
  const Duration late = duration_from_s(planned.stage.frame_late_s);
  const bool is_newest = planned.stage.frames == FrameChoice::newest;
  BodyTracks bodies(time.size(), seen.size());
  for (std::size_t s = 0; s < seen.size(); ++s) {
    const std::set<std::uint64_t>* wanted = person ? &person->identities[s] : nullptr;
    for (std::size_t i = 0; i < time.size(); ++i)
      bodies.at(i, s) = is_newest ? newest_body(seen[s].frames, time[i], gap, late, wanted)
                                  : body_at(seen[s].frames, time[i], gap, wanted);
  }
  return bodies;
}

// Chooses the person and takes their bodies at the instants.
void follow_bodies(const Plan& plan, const PlannedTake& planned, const RigBodies& seen, bool has_truth,
                   PersonTake& data) {
  append({{}, notes_on_streams(plan, planned, seen)}, data);
  data.joints_misread =
      std::ranges::any_of(seen, [](const SensorBodies& s) { return s.joints.misread_text().has_value(); });
  auto person = choose_person(plan, planned, seen, data);
  // Where no sensor sees two at once, bodies that lie apart may be one person's whom the poses tear apart.
  std::optional<SensorChecks> checks;
  if (person && !person->sees_several) {
    checks = check_sensors(plan, planned, follow(plan, planned, seen, nullptr, data.time));
    if (checks->is_one_person || (checks->misplaced && !has_truth)) person.reset();
  }
  if (person && !data.joints_misread)
    data.notes.push_back({planned.take.id, false, planned.take.session.string(), person->note});
  data.bodies = follow(plan, planned, seen, person ? &*person : nullptr, data.time);
  if (!checks) checks = check_sensors(plan, planned, data.bodies);
  if (data.joints_misread) checks->notes.clear();
  data.explained_by_sensor_check = !checks->notes.empty() || data.joints_misread;
  data.rig_changed = checks->rig_changed;
  data.odd_sensors = checks->odd_sensors;
  append(std::move(*checks), data);
  bool any_seen = false;
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t s = 0; s < seen.size(); ++s)
      for (const Joint joint : plan.joints) any_seen |= data.bodies.at(i, s).has(joint);
  if (!any_seen)
    throw InputError(planned.take.session.string(),
                     "no sensor ever sees a joint that is asked for: there are no bodies, or all positions "
                     "are untracked, not finite or out of reach");
}

// Finds the exchanges that these sensors of the rig show of each other.
void find_exchanges_among(const std::vector<std::size_t>& sensors, const Plan& plan,
                          const PlannedTake& planned, const BodyTracks& bodies, SideSwapRepair& exchanges) {
  if (sensors.empty()) return;
  BodyTracks part(bodies.instants(), sensors.size());
  std::vector<RigidTransform> poses;
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    poses.push_back(planned.world_from_sensor[sensors[k]]);
    for (std::size_t i = 0; i < bodies.instants(); ++i) part.at(i, k) = bodies.at(i, sensors[k]);
  }
  const SideSwapRepair found = find_exchanges(part, poses, {.instant_s = 1.0 / plan.study.rate_hz});
  for (std::size_t k = 0; k < sensors.size(); ++k) {
    exchanges.stretches[sensors[k]] = found.stretches[k];
    for (std::size_t i = 0; i < bodies.instants(); ++i)
      exchanges.sides_swapped[i * exchanges.sensors + sensors[k]] = found.at(i, k) ? 1 : 0;
  }
}

void repair(const Plan& plan, const PlannedTake& planned, std::optional<std::size_t> left_out,
            PreparedTake& data) {
  const std::size_t rig = plan.rig.size();
  data.exchanges = {rig, std::vector<std::uint8_t>(data.time.size() * rig, 0),
                    std::vector<std::size_t>(rig, 0)};
  if (!planned.level) {
    data.notes.push_back(
        {planned.take.id, false, planned.take.calibration.string(),
         "has a world that is not level, so exchanges of left and right are not looked for"});
    return;
  }
  if (left_out) {
    std::vector<std::size_t> others;
    for (std::size_t s = 0; s < rig; ++s)
      if (s != left_out) others.push_back(s);
    find_exchanges_among(others, plan, planned, data.bodies, data.exchanges);
    find_exchanges_among({*left_out}, plan, planned, data.bodies, data.exchanges);
  } else {
    data.exchanges =
        find_exchanges(data.bodies, planned.world_from_sensor, {.instant_s = 1.0 / plan.study.rate_hz});
  }
  if (planned.stage.repair_exchanges) undo_exchanges(data.bodies, data.exchanges);
}

// Makes what a sensor tracks the truth, and takes its bodies away.
void leave_out(const Plan& plan, const PlannedTake& planned, std::size_t sensor, PreparedTake& data) {
  data.truth_m.assign(data.time.size() * plan.joints.size(), Eigen::Vector3d::Constant(kNaN));
  for (std::size_t i = 0; i < data.time.size(); ++i) {
    ObservedBody& body = data.bodies.at(i, sensor);
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Joint joint = plan.joints[j];
      if (body.state[static_cast<std::size_t>(joint)] != TrackingState::tracked) continue;
      data.truth_m[i * plan.joints.size() + j] = planned.world_from_sensor[sensor] * body.at(joint);
    }
    body = {};
  }
}

// Findings about the stated start of the truth.
struct ClockCheck {
  bool is_late = false;  // off by more than what was searched
  std::string warning;   // the note's text; empty without one
};

// A take whose motion does not say anything about the clock keeps the stated one, with a note; so does one
// whose truth lies in another frame.
ClockCheck check_clock(const Plan& plan, const PlannedTake& planned, const std::vector<PointPath>& truth,
                       const std::function<bool()>& stop_requested, PreparedTake& data) {
  if (plan.study.clock == ClockSource::stated) return {};
  MotionClock clock = clock_by_motion(plan, planned, data, truth);
  data.clock = clock.row;
  const bool is_known = std::isfinite(data.clock.offset_s);
  ClockCheck check;
  std::string frame;
  if (!data.explained_by_sensor_check) {
    if (!is_known) check.warning = clock_fault_text(plan, planned, data);
    check.is_late = !check.warning.empty();
    if (!check.is_late && !clock.warning.empty()) frame = frame_fault_text(plan, planned, data);
    if (!check.is_late) check.warning = frame.empty() ? std::move(clock.warning) : frame;
  }
  const auto note = [&](std::string text) {
    data.notes.push_back({planned.take.id, false, planned.take.mocap.string(), std::move(text)});
  };
  if (!check.warning.empty()) note(check.warning);
  if (plan.study.clock != ClockSource::motion || !frame.empty()) return check;
  if (is_known)
    apply_clock(plan, planned, stop_requested, data);
  else
    note("keeps its stated start, since by the motion the clocks' offset is not known (" + data.clock.status +
         "): " + cause_of(data.clock.status));
  return check;
}

// Which way the person faces, from what is left and right of the trunk in the mean over the sensors.
std::vector<float> headings_of(const BodyTracks& bodies,
                               const std::vector<RigidTransform>& world_from_sensor) {
  std::vector<float> headings(bodies.instants(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < bodies.instants(); ++i) {
    Eigen::Vector3d left = Eigen::Vector3d::Zero();
    for (const Joint joint : {Joint::shoulder_left, Joint::hip_left})
      for (std::size_t s = 0; s < bodies.sensors(); ++s) {
        const ObservedBody& body = bodies.at(i, s);
        if (body.has(joint) && body.has(mirror_of(joint)))
          left += world_from_sensor[s].rotation * (body.at(joint) - body.at(mirror_of(joint)));
      }
    if (std::hypot(left.x(), left.z()) > 0.0)
      headings[i] = static_cast<float>(std::atan2(-left.z(), left.x()));
  }
  return headings;
}

OcclusionCounts count_crossings(const BodyTracks& bodies, OcclusionVariant variant) {
  OcclusionCounts counts(bodies.instants(), bodies.sensors());
  parallel_for_index(bodies.instants(), kTogether, [&](std::size_t i) {
    for (std::size_t s = 0; s < bodies.sensors(); ++s) {
      const auto of_joint = count_occlusions(bodies.at(i, s), variant);
      for (std::size_t j = 0; j < kJointCount; ++j)
        counts.at(i, s, j) = static_cast<std::uint8_t>(std::min(of_joint[j], 255));
    }
  });
  return counts;
}

void find_occlusions(const Plan& plan, const PlannedTake& planned,
                     const std::function<bool()>& stop_requested, PreparedTake& data) {
  const auto slot = [&](OcclusionRule rule) -> OcclusionCounts& {
    return data.occlusions[static_cast<std::size_t>(rule)];
  };
  if (std::ranges::any_of(plan.methods,
                          [](const Method& m) { return m.spec.occlusion == OcclusionRule::printed; }))
    slot(OcclusionRule::printed) = count_crossings(data.bodies, OcclusionVariant::printed);
  slot(OcclusionRule::corrected) = count_crossings(data.bodies, OcclusionVariant::corrected);
  if (std::ranges::any_of(plan.methods, [](const Method& m) { return asks_for_hidden(m.spec); }))
    slot(OcclusionRule::hidden) = hidden_views(planned, data, stop_requested);
}

}  // namespace

RecordedTake read_take(const Plan& plan, const PlannedTake& planned,
                       const std::function<bool()>& stop_requested) {
  const SessionReader session(planned.take.session);
  RecordedTake recorded;
  recorded.is_closed = session.complete();
  if (planned.truth == TakeTruth::mocap)  // before the bodies: markers need room until they are sampled
    recorded.truth = sample_truth(plan, planned, {}, plan.study.clock != ClockSource::stated, stop_requested);
  for (std::size_t s = 0; s < plan.rig.size(); ++s)
    recorded.bodies.push_back(
        read_sensor_bodies(session, planned.session_sensor[s], planned.host_from_sensor[s], stop_requested));
  return recorded;
}

PersonTake select_person(const Plan& plan, const PlannedTake& planned, RecordedTake& recorded) {
  PersonTake data;
  data.time.reserve(planned.instants);
  for (std::uint64_t i = 0; i < planned.instants; ++i) data.time.push_back(planned.start + plan.instant(i));
  const auto note = [&](std::string text) {
    data.notes.push_back({planned.take.id, false, planned.take.session.string(), std::move(text)});
  };
  if (!planned.span_note.empty()) note(planned.span_note);
  if (!recorded.is_closed) note("was not closed by its recorder");
  if (planned.take.activity.ends_with(kPredicted))
    note(
        "has no motion capture: each sensor is predicted from the others, and the differences stand under "
        "\"" +
        planned.take.activity + '"');
  if (recorded.truth) {
    data.truth_m = std::move(recorded.truth->at_instants_m);
    append({{}, notes_on_truth(planned, *recorded.truth)}, data);
  }
  const RigBodies bodies = std::exchange(recorded.bodies, {});
  follow_bodies(plan, planned, bodies, recorded.truth.has_value(), data);
  return data;
}

PreparedTake view_take(const Plan& plan, const PlannedTake& planned, PersonTake followed,
                       const std::optional<SampledTruth>& truth, std::optional<std::size_t> left_out,
                       const std::function<bool()>& stop_requested) {
  PreparedTake data{std::move(followed)};
  repair(plan, planned, left_out, data);
  if (truth) {
    const ClockCheck clock = check_clock(plan, planned, truth->dense, stop_requested, data);
    if (!data.rig_changed && !data.joints_misread && !clock.is_late) {
      TakeChecks checks = check_truth(plan, planned, data);
      if (checks.names_cause && !std::isfinite(data.clock.offset_s))  // which is why no start fits
        std::erase_if(data.notes, [&](const TakeNote& note) { return note.text == clock.warning; });
      append(std::move(checks), data);
    }
  }
  data.heading_rad = headings_of(data.bodies, planned.world_from_sensor);
  if (left_out) leave_out(plan, planned, *left_out, data);
  if (data.truth_m.empty())
    data.truth_m.assign(data.time.size() * plan.joints.size(), Eigen::Vector3d::Constant(kNaN));
  find_occlusions(plan, planned, stop_requested, data);
  if (!left_out || estimates_calibration(plan)) find_corrections(planned, data);
  if (!left_out) {
    append({check_sides(plan, planned, data), {}}, data);
    append(check_poses(plan, planned, data), data);
  }
  estimate_sigmas(plan, planned, data);
  return data;
}

PreparedTake load_take(const Plan& plan, const PlannedTake& planned,
                       const std::function<bool()>& stop_requested) {
  RecordedTake recorded = read_take(plan, planned, stop_requested);
  PersonTake followed = select_person(plan, planned, recorded);
  return view_take(plan, planned, std::move(followed), recorded.truth, std::nullopt, stop_requested);
}

void observe_joint(const PreparedTake& data, std::size_t instant, Joint joint,
                   const std::vector<RigidTransform>& world_from_sensor,
                   std::span<JointObservation> observations) {
  for (std::size_t s = 0; s < observations.size(); ++s) {
    const ObservedBody& body = data.bodies.at(instant, s);
    observations[s] =
        observe(body.at(joint), body.state[static_cast<std::size_t>(joint)], world_from_sensor[s]);
  }
}

const std::vector<RigidTransform>& rig_of(const PlannedTake& planned, const PreparedTake& data,
                                          bool is_corrected) {
  return is_corrected ? data.corrected_rig : planned.world_from_sensor;
}

void observe_joint(const PreparedTake& data, const PlannedTake& planned, bool is_corrected,
                   std::size_t instant, Joint joint, std::span<JointObservation> observations) {
  observe_joint(data, instant, joint, planned.world_from_sensor, observations);
  for (std::size_t s = 0; is_corrected && s < observations.size(); ++s)
    observations[s] = corrected_view(observations[s], planned.world_from_sensor[s], data.shown.of_sensor[s]);
}

RaySigma sigma_at(const PreparedTake& data, bool is_corrected, std::size_t instant, std::size_t joint) {
  const std::vector<RaySigma>& sigma = data.sigma[is_corrected];
  if (sigma.empty()) return {kNaN, kNaN};
  return sigma[2 * joint + (instant < data.time.size() / 2 ? 0 : 1)];
}

JointOcclusions occlusions_of(const PreparedTake& data, std::size_t instant, Joint joint) {
  JointOcclusions result{};
  for (std::size_t rule = 0; rule < kOcclusionRules; ++rule)
    for (std::size_t s = 0; !data.occlusions[rule].empty() && s < data.bodies.sensors(); ++s)
      result[rule][s] = data.occlusions[rule].at(instant, s, static_cast<std::size_t>(joint));
  return result;
}

}  // namespace trilat
