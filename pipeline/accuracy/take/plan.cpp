// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/plan.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/results/summary.h"
#include "datasets/rig/calibration.h"
#include "datasets/session/body_readings.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/take/take_clocks.h"
#include "pipeline/accuracy/take/truth_track.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

// Instants of the truth that show which axis points up: so many with a joint, or more until one does, of at
// most so many.
constexpr double kProbe_s = 0.1, kFirst_s = 1.5;
constexpr double kShortSpan_s = 1.0;  // a sensor that misses more of a take is named

struct HostSpan {
  HostTime first, last;
};

HostSpan span_of(const SessionReader& session, std::size_t sensor, const SensorClockMap& map) {
  const SensorDescription& description = session.header().sensors[sensor];
  const std::uint64_t frames = session.counts(sensor).body_frames;
  const std::string place = session.path().string() + ":/sensors/" + description.name + "/body_frames";
  if (frames == 0) throw InputError(place, "holds no body frames, so there is nothing to trilaterate");
  const auto first = session.stamps(sensor, FrameStream::bodies, 0, 1);
  const auto last = session.stamps(sensor, FrameStream::bodies, frames - 1, 1);
  return {map(first[0]), map(last[0])};
}

// The instants at which any sensor of the rig was recording.
void plan_instants(PlannedTake& planned, const std::vector<std::string>& rig,
                   const std::vector<HostSpan>& spans, double rate_hz) {
  HostTime first = spans[0].first, last = spans[0].last;
  for (const HostSpan& span : spans) {
    first = std::min(first, span.first);
    last = std::max(last, span.last);
  }
  for (std::size_t s = 0; s < rig.size(); ++s) {
    const double recorded_s = (spans[s].last - spans[s].first).seconds();
    if ((last - first).seconds() > recorded_s + kShortSpan_s)
      planned.span_note +=
          fmt::format("{}{} recorded only {:.1f} s of {:.1f} s", planned.span_note.empty() ? "" : ", ",
                      rig[s], recorded_s, (last - first).seconds());
  }
  const auto latest = std::ranges::max_element(spans, {}, [](const HostSpan& span) { return span.first.ns; });
  const auto earliest =
      std::ranges::min_element(spans, {}, [](const HostSpan& span) { return span.last.ns; });
  if (latest->first > earliest->last)
    planned.span_note += fmt::format(
        "{}{} begins {:.1f} s after {} ends (are their times of clocks that have nothing in common?)",
        planned.span_note.empty() ? "" : "; ", rig[static_cast<std::size_t>(latest - spans.begin())],
        (latest->first - earliest->last).seconds(), rig[static_cast<std::size_t>(earliest - spans.begin())]);
  if (!planned.span_note.empty())
    planned.span_note += "; what cannot be answered without it counts against a method's coverage";
  planned.start = first;
  planned.instants = static_cast<std::uint64_t>(std::floor((last - first).seconds() * rate_hz)) + 1;
  constexpr std::uint64_t kMaxCount = 2'000'000;  // a take is held in memory: 18 hours at 30 Hz
  if (planned.instants > kMaxCount)
    throw InputError(planned.take.session.string(),
                     fmt::format("covers {:.0f} s, more than can be evaluated at {} Hz",
                                 (last - first).seconds(), rate_hz));
}

// The ground truth is in OptiTrack's world; only a rigid alignment forgives poses in another.
void check_world(const Calibration& calibration, const StudySpec& study, const std::string& place) {
  for (AlignmentKind kind : study.alignments)
    if (calibration.world != "optitrack" && kind != AlignmentKind::rigid)
      throw InputError(place + " /world",
                       "is \"" + calibration.world +
                           "\", but the ground truth is in OptiTrack's world; calibrate with --mocap, or "
                           "evaluate with \"alignments\": [\"rigid\"] alone");
}

// The mapping of a take without truth: nothing limits the joints.
JointMapping every_joint() {
  JointMapping mapping;
  for (int j = 0; j < kJointCount; ++j) mapping.joints.push_back({static_cast<Joint>(j), {}});
  return mapping;
}

// Reads the truth's first seconds, in which its assets must exist. InputError where no axis is stated and the
// person stands along z in them; a take that shows nothing is taken as y.
void check_up_axis(const PlannedTake& planned, const std::vector<Joint>& joints) {
  const MarkerTrack truth =
      truth_of(planned, joints, duration_from_s(kProbe_s), MocapTime{} + duration_from_s(kFirst_s));
  if (planned.take.up_axis || !planned.level) return;
  UpAxisEstimator standing;
  std::vector<Eigen::Vector3d> points(joints.size());
  for (double t_s = 0.0; t_s <= kFirst_s; t_s += kProbe_s) {
    truth.at(MocapTime{} + duration_from_s(t_s), points);
    for (std::size_t j = 0; j < joints.size(); ++j) standing.add(joints[j], points[j]);
  }
  if (standing.axis() == UpAxis::z) throw InputError(planned.take.mocap.string(), kStandsAlongZ);
}

// By name; InputError with what to do where the session lacks it.
std::size_t sensor_of(const SessionReader& session, const std::string& name) {
  try {
    return session.sensor_index(name);
  } catch (const InputError& error) {
    throw InputError(error.place(), error.problem() + "; name those to use under \"sensors\" in the study");
  }
}

void look_into(PlannedTake& planned, const std::vector<std::string>& rig, const StudySpec& study) {
  if (planned.take.mocap.empty() && planned.truth == TakeTruth::mocap)
    throw InputError("take \"" + planned.take.id + '"',
                     "has no \"mocap\" to be judged by; with \"truth\": \"auto\" the study judges such a "
                     "take by its own sensors, with \"left_out_sensor\" every take");
  const SessionReader session(planned.take.session);
  planned.simulated = session.header().simulated;
  const bool has_truth = planned.truth == TakeTruth::mocap;
  planned.mapping = planned.take.mapping.empty() ? every_joint() : read_mapping(planned.take.mapping);
  const Calibration calibration = read_calibration(planned.take.calibration);
  if (has_truth) check_world(calibration, study, planned.take.calibration.string());
  planned.in_mocap_world = calibration.world == "optitrack";
  planned.level =
      !calibration.world.starts_with("sensor ") || calibration.world.find("floor") != std::string::npos;
  std::vector<HostSpan> spans;
  for (const std::string& name : rig) {
    const std::size_t sensor = sensor_of(session, name);
    planned.session_sensor.push_back(sensor);
    planned.poses.push_back(pose_of(calibration, name, planned.take.calibration.string()));
    planned.world_from_sensor.push_back(planned.poses.back().world_from_sensor);
    planned.host_from_sensor.push_back(clock_of(session, sensor, planned.stage.sensor_clocks));
    spans.push_back(span_of(session, sensor, planned.host_from_sensor.back()));
  }
  plan_instants(planned, rig, spans, study.rate_hz);
  std::vector<Joint> mapped;
  for (const auto& entry : planned.mapping.joints) mapped.push_back(entry.joint);
  if (has_truth) {
    planned.truth_has_z_up = planned.take.up_axis == UpAxis::z;
    check_up_axis(planned, mapped);
  }
  planned.ok = true;
}

std::vector<std::string> rig_of(const StudySpec& study, const Campaign& campaign) {
  std::vector<std::string> rig = study.sensors;
  std::string reason;
  const std::size_t takes = rig.empty() ? campaign.takes.size() : 0;
  for (std::size_t t = 0; t < takes; ++t) {
    try {
      const SessionReader session(campaign.takes[t].session);
      if (session.header().sensors.size() <= rig.size()) continue;
      rig.clear();
      for (const SensorDescription& sensor : session.header().sensors) rig.push_back(sensor.name);
    } catch (const InputError& error) {
      if (reason.empty()) reason = error.what();
    }
  }
  if (rig.empty())
    throw InputError("campaign \"" + campaign.name + '"', "has no take that can be opened: " + reason);
  if (rig.size() > kMaxSensors)
    throw InputError("study \"" + study.name + '"',
                     fmt::format("would use {} sensors, the limit is {}; name those to use under \"sensors\"",
                                 rig.size(), kMaxSensors));
  return rig;
}

std::string mapped_names(const std::vector<PlannedTake>& takes) {
  std::set<std::string_view> names;
  for (const PlannedTake& take : takes)
    for (const auto& entry : take.mapping.joints) names.insert(name_of(entry.joint));
  return fmt::format("{}", fmt::join(names, ", "));
}

// All joints that any take maps, in the order of the tables.
std::vector<Joint> joints_of(const StudySpec& study, const std::vector<PlannedTake>& takes) {
  std::set<Joint> mapped;
  for (const PlannedTake& take : takes)
    for (const auto& entry : take.mapping.joints)
      if (study.joints.empty() || std::ranges::find(study.joints, name_of(entry.joint)) != study.joints.end())
        mapped.insert(entry.joint);
  std::vector<Joint> joints;
  for (const JointGroup& group : joint_groups())
    for (Joint joint : group.joints)
      if (mapped.erase(joint) > 0) joints.push_back(joint);
  joints.insert(joints.end(), mapped.begin(), mapped.end());
  return joints;
}

}  // namespace

namespace {

void keep_conditions(const StudySpec& study, Campaign& campaign) {
  if (study.conditions.empty()) return;
  std::string known;
  for (const Take& take : campaign.takes)
    if (known.find('"' + take.activity + '"') == std::string::npos)
      known += (known.empty() ? "\"" : ", \"") + take.activity + '"';
  for (const std::string& condition : study.conditions)
    if (known.find('"' + condition + '"') == std::string::npos)
      throw InputError(
          "study \"" + study.name + "\" /conditions",
          "has \"" + condition + "\", which no take of the campaign is; its activities are " + known);
  std::erase_if(campaign.takes, [&](const Take& take) {
    return std::ranges::find(study.conditions, take.activity) == study.conditions.end();
  });
}

TakeTruth truth_of(const StudySpec& study, const Take& take) {
  if (study.truth == TruthSource::nothing) return TakeTruth::nothing;
  const bool is_left_out = study.truth == TruthSource::left_out_sensor ||
                           (study.truth == TruthSource::automatic && take.mocap.empty());
  return is_left_out ? TakeTruth::left_out_sensor : TakeTruth::mocap;
}

// Says what each take is held against. Takes that are held against sensors beside takes with mocap are a
// condition of their own.
void plan_truths(Plan& plan) {
  const auto is_left_out = [](const PlannedTake& planned) {
    return planned.truth == TakeTruth::left_out_sensor;
  };
  for (PlannedTake& planned : plan.takes) planned.truth = truth_of(plan.study, planned.take);
  if (std::ranges::none_of(plan.takes, is_left_out)) return;
  if (plan.rig.size() < 2)
    throw InputError(
        "study \"" + plan.study.name + '"',
        "has takes without \"mocap\" and one sensor: left out, it leaves nothing to predict what it sees");
  if (std::ranges::all_of(plan.takes, is_left_out)) return;
  for (PlannedTake& planned : plan.takes)
    if (is_left_out(planned)) planned.take.activity += kPredicted;
}

}  // namespace

Campaign takes_of(const StudySpec& study, Campaign campaign) {
  keep_conditions(study, campaign);
  const std::vector<Take> takes = std::exchange(campaign.takes, {});
  const bool is_one_activity =
      std::ranges::all_of(takes, [&](const Take& take) { return take.activity == takes.front().activity; });
  const std::vector<Stage> stages = stages_of(study);
  for (std::size_t s = 0; s < stages.size(); ++s)
    for (Take take : takes) {
      if (!stages[s].name.empty()) {
        take.id += fmt::format(".{}", s + 1);
        take.activity = is_one_activity ? stages[s].name : take.activity + ", " + stages[s].name;
      }
      if (!stages[s].calibration.empty()) take.calibration = stages[s].calibration;
      campaign.takes.push_back(std::move(take));
    }
  return campaign;
}

bool leaves_sensors_out(const Plan& plan) {
  return std::ranges::all_of(
      plan.takes, [](const PlannedTake& planned) { return planned.truth == TakeTruth::left_out_sensor; });
}

std::size_t reference_of(const StudySpec& study, const std::vector<Method>& methods) {
  if (study.reference.empty()) return 0;
  std::string known;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (methods[m].spec.name == study.reference) return m;
    known += (known.empty() ? "\"" : ", \"") + methods[m].spec.name + '"';
  }
  throw InputError("study \"" + study.name + "\" /reference",
                   "is \"" + study.reference + "\", which is none of its methods: " + known);
}

namespace {

// Adds what takes bring to the methods, in the order of their names.
void add_external_methods(Plan& plan) {
  const auto first = static_cast<std::ptrdiff_t>(plan.methods.size());
  for (const Take& take : plan.campaign.takes)
    for (const ExternalJoints& joints : take.joints) {
      const auto same = std::ranges::find_if(
          plan.methods, [&](const Method& method) { return method.spec.name == joints.method; });
      if (same != plan.methods.end() && same->spec.kind != &external_kind())
        throw InputError("take \"" + take.id + '"', "brings joints of the method \"" + joints.method +
                                                        "\", which the study has, too; rename one of them");
      if (same != plan.methods.end()) continue;
      plan.methods.emplace_back().spec.kind = &external_kind();
      plan.methods.back().spec.name = joints.method;
    }
  std::ranges::sort(plan.methods.begin() + first, plan.methods.end(), {},
                    [](const Method& method) { return method.spec.name; });
}

// Whether all takes bring their joints and none has a session. InputError where only some do.
bool brings_all(const Campaign& campaign) {
  const auto brings = [](const Take& take) { return take.session.empty(); };
  const auto other = std::ranges::find_if_not(campaign.takes, brings);
  if (other == campaign.takes.end()) return !campaign.takes.empty();
  if (const auto one = std::ranges::find_if(campaign.takes, brings); one != campaign.takes.end())
    throw InputError("campaign \"" + campaign.name + '"', "has takes with a session, such as " + other->id +
                                                              ", and takes without, such as " + one->id +
                                                              "; make two campaigns of them");
  return false;
}

void look_into_all(Plan& plan, const Watch& watch) {
  std::atomic<std::size_t> done{0};
  parallel_for_index(plan.takes.size(), 1, [&](std::size_t t) {
    watch.check();
    PlannedTake& planned = plan.takes[t];
    try {
      if (plan.rig.empty())
        look_into_external(planned, plan.study);
      else
        look_into(planned, plan.rig, plan.study);
    } catch (const InputError& error) {
      planned.place = error.place();
      planned.problem = error.problem();
    }
    watch.tell(static_cast<double>(++done) / static_cast<double>(plan.takes.size()));
  });
  // Where no take can be evaluated, the first reason is an error before anything is written.
  if (std::ranges::none_of(plan.takes, &PlannedTake::ok))
    throw InputError(plan.takes.front().place, plan.takes.front().problem);
}

// Those that the study asks for; all that are there where it asks for none.
void plan_joints(Plan& plan) {
  plan.joints = joints_of(plan.study, plan.takes);
  if (plan.joints.empty())
    throw InputError("study \"" + plan.study.name + "\" /joints",
                     fmt::format("asks for {}, which no take's mapping maps; they map {}",
                                 fmt::join(plan.study.joints, ", "), mapped_names(plan.takes)));
  for (const Joint joint : plan.joints) plan.names.emplace_back(name_of(joint));
}

// In an order that the takes' does not change: it is in the key of each.
void plan_points(Plan& plan) {
  std::vector<std::string> known;
  for (const PlannedTake& planned : plan.takes)
    for (const NamedPoint& point : planned.points)
      if (std::ranges::find(known, point.name) == known.end()) known.push_back(point.name);
  std::ranges::sort(known, {}, [](const std::string& name) {
    const std::optional<Joint> joint = joint_from_name(name);
    return std::pair(joint ? static_cast<int>(*joint) : static_cast<int>(kJointCount), name);
  });
  if (std::ranges::find(known, kAverageGroup) != known.end())
    throw InputError(
        "campaign \"" + plan.campaign.name + '"',
        "has a point called \"average\", the tables' name for the mean of all points; give it another "
        "name in the files or in mapping.json");
  for (const std::string& name : known)
    if (plan.study.joints.empty() || std::ranges::find(plan.study.joints, name) != plan.study.joints.end())
      plan.names.push_back(name);
  if (plan.names.empty())
    throw InputError("study \"" + plan.study.name + "\" /joints",
                     fmt::format("asks for {}, which no take has and brings; known are {}",
                                 fmt::join(plan.study.joints, ", "), fmt::join(known, ", ")));
}

void check_conditions(const Plan& plan) {
  const std::vector<std::string> activities = activities_of(plan);
  for (const std::string& activity : activities)
    if (plan.study.occluded_apart &&
        std::ranges::find(activities, occluded_condition(activity)) != activities.end())
      throw InputError(
          "campaign \"" + plan.campaign.name + '"',
          fmt::format("has takes of the activity \"{}\", which is the name of the occluded samples of "
                      "\"{}\" under \"occluded_apart\"; rename the activity",
                      occluded_condition(activity), activity));
}

}  // namespace

Plan make_plan(const StudySpec& study, const Campaign& campaign, const Watch& watch) {
  Plan plan;
  plan.study = study;
  plan.campaign = takes_of(study, campaign);
  if (!brings_all(plan.campaign)) {
    plan.rig = rig_of(study, plan.campaign);
    plan.methods = resolve_methods(study, plan.rig);
  }
  if (plan.rig.empty() &&
      std::ranges::find(study.alignments, AlignmentKind::joint_offset) != study.alignments.end())
    throw InputError("study \"" + study.name + "\" /alignments",
                     "has joint_offset, which needs a session: its bodies show where the person faces");
  if (plan.rig.empty() && !study.methods.empty())
    throw InputError("study \"" + study.name + "\" /methods",
                     "need takes with a session, and the campaign has joints alone: leave the key out");
  add_external_methods(plan);
  if (plan.methods.empty())
    throw InputError("study \"" + study.name + "\" /methods", "must hold at least one method");
  plan.reference = reference_of(study, plan.methods);
  const std::vector<Stage> stages = stages_of(study);
  for (const Take& take : plan.campaign.takes) {
    const std::size_t stage = plan.takes.size() * stages.size() / plan.campaign.takes.size();
    plan.takes.emplace_back().take = take;
    plan.takes.back().stage = stages[stage];
  }
  check_conditions(plan);
  plan_truths(plan);
  look_into_all(plan, watch);
  if (plan.rig.empty())
    plan_points(plan);
  else
    plan_joints(plan);
  plan.simulated = campaign.simulated;
  for (const PlannedTake& take : plan.takes) plan.simulated |= take.simulated;
  return plan;
}

std::size_t first_external(const Plan& plan) {
  const auto first = std::ranges::find_if(
      plan.methods, [](const Method& method) { return method.spec.kind == &external_kind(); });
  return static_cast<std::size_t>(first - plan.methods.begin());
}

bool judges_places(const StudySpec& study) { return study.alignments != std::vector{AlignmentKind::rigid}; }

std::vector<std::string> activities_of(const Plan& plan) {
  std::vector<std::string> activities;
  for (const PlannedTake& planned : plan.takes)
    if (std::ranges::find(activities, planned.take.activity) == activities.end())
      activities.push_back(planned.take.activity);
  return activities;
}

}  // namespace trilat
