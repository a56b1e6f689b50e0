// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/take/plan.h"

#include <algorithm>
#include <atomic>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/results/summary.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/external/external_joints.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

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

void open_all(Plan& plan, const RunControl& control) {
  std::atomic<std::size_t> done{0};
  parallel_for_index(plan.takes.size(), 1, [&](std::size_t t) {
    control.check();
    PlannedTake& planned = plan.takes[t];
    try {
      if (plan.rig.empty())
        open_external_take(planned, plan.study);
      else
        open_take(planned, plan.rig, plan.study);
    } catch (const InputError& error) {
      planned.place = error.place();
      planned.problem = error.problem();
    }
    control.report(static_cast<double>(++done) / static_cast<double>(plan.takes.size()));
  });
  // Where no take can be evaluated, the first reason is an error before anything is written.
  if (std::ranges::none_of(plan.takes, &PlannedTake::ok))
    throw InputError(plan.takes.front().place, plan.takes.front().problem);
}

// Joints that the study names, or all that are there.
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

Plan make_plan(const StudySpec& study, const Campaign& campaign, const RunControl& control) {
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
  open_all(plan, control);
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

bool compares_absolute_positions(const StudySpec& study) {
  return study.alignments != std::vector{AlignmentKind::rigid};
}

std::vector<std::string> activities_of(const Plan& plan) {
  std::vector<std::string> activities;
  for (const PlannedTake& planned : plan.takes)
    if (std::ranges::find(activities, planned.take.activity) == activities.end())
      activities.push_back(planned.take.activity);
  return activities;
}

}  // namespace trilat
