// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/session/session_reader.h"
#include "datasets/synthetic/depth/joint_visibility.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "evaluators/solvers/descent.h"
#include "pipeline/accuracy/take/take_data.h"
#include "pipeline/accuracy/take/truth_track.h"
#include "pipeline/errors/condition_errors.h"

namespace trilat {
namespace {

constexpr double kTruthGap_s = 0.1;

std::filesystem::path true_joints(const Take& take) { return take.session.parent_path() / "truth.csv"; }

// The person's true joints over time; points stand in the order of Joint.
MarkerTrack read_true_joints(const Take& take) {
  PlannedTake all;
  all.take.mocap = true_joints(take);
  std::vector<Joint> joints;
  for (int j = 0; j < kJointCount; ++j) {
    joints.push_back(static_cast<Joint>(j));
    all.mapping.joints.push_back({joints.back(), {std::string(name_of(joints.back()))}});
  }
  return truth_of(all, joints, duration_from_s(kTruthGap_s));
}

SkeletonPose pose_at(const MarkerTrack& truth, HostTime t) {
  SkeletonPose pose;
  truth.at({(t - kMotionStart).ns}, pose.joint_in_world_m);
  for (std::size_t j = 0; j < kJointCount; ++j) pose.present[j] = pose.joint_in_world_m[j].allFinite();
  return pose;
}

// Rows by joint group, in the order of the plan's joints.
template <class Row>
Row& row_of(std::vector<Row>& rows, const PlannedTake& planned, Joint joint, const std::string& rule = {}) {
  const std::string group = group_of(std::string(name_of(joint)));
  const auto same = std::ranges::find_if(rows, [&](const Row& row) {
    if constexpr (requires { row.rule; }) return row.group == group && row.rule == rule;
    return row.group == group;
  });
  if (same != rows.end()) return *same;
  Row& row = rows.emplace_back();
  row.condition = planned.take.activity;
  row.group = group;
  if constexpr (requires { row.rule; }) row.rule = rule;
  return row;
}

}  // namespace

bool knows_hidden_views(const Take& take) {
  return !take.session.empty() && std::filesystem::exists(true_joints(take));
}

OcclusionCounts hidden_views(const PlannedTake& planned, const PreparedTake& data,
                             const std::function<bool()>& stop_requested) {
  if (!knows_hidden_views(planned.take))
    throw InputError(planned.take.session.string(),
                     "has no truth.csv beside it, so the hidden joints are not known: \"occlusion\": "
                     "\"hidden\" is for simulations of generated persons");
  const MarkerTrack truth = read_true_joints(planned.take);
  const SessionReader session(planned.take.session);
  const double least_share = default_body_tracker().least_visible_share;
  OcclusionCounts counts(data.time.size(), planned.session_sensor.size());
  for (std::size_t s = 0; s < planned.session_sensor.size(); ++s) {
    JointVisibility visibility(session.header().sensors[planned.session_sensor[s]].intrinsics);
    for (std::size_t i = 0; i < data.time.size(); ++i) {
      if (i % 64 == 0 && stop_requested && stop_requested()) throw Interrupted();
      const SkeletonPose pose = pose_at(truth, data.time[i]);
      if (pose.present.none()) continue;
      visibility.set_person(pose, planned.world_from_sensor[s]);
      const std::bitset<kJointCount> hidden = visibility.hidden_joints(least_share);
      for (std::size_t j = 0; j < kJointCount; ++j) counts.at(i, s, j) = hidden[j] ? 1 : 0;
    }
  }
  return counts;
}

std::vector<RuleRow> judge_rules(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  const auto counts = [&](OcclusionRule rule) -> const OcclusionCounts& {
    return data.occlusions[static_cast<std::size_t>(rule)];
  };
  const OcclusionCounts& hidden = counts(OcclusionRule::hidden);
  std::vector<RuleRow> rows;
  if (hidden.empty()) return rows;
  for (const Joint joint : plan.joints) {
    if (std::ranges::find(planned.mapping.joints, joint, &JointMapping::Entry::joint) ==
        planned.mapping.joints.end())
      continue;  // of another activity
    const auto j = static_cast<std::size_t>(joint);
    for (std::size_t i = 0; i < data.time.size(); ++i)
      for (std::size_t s = 0; s < data.bodies.sensors(); ++s) {
        const ObservedBody& body = data.bodies.at(i, s);
        if (!body.has(joint)) continue;
        const bool is_inferred = body.state[j] == TrackingState::inferred;
        const auto count = [&](const char* rule, bool is_marked) {
          RuleRow& row = row_of(rows, planned, joint, rule);
          ++row.views;
          row.hidden += hidden.at(i, s, j);
          row.marked += is_marked;
          row.both += is_marked && hidden.at(i, s, j) > 0;
        };
        if (const OcclusionCounts& printed = counts(OcclusionRule::printed); !printed.empty()) {
          count("equation 8, printed", printed.at(i, s, j) > 0);
          count("equation 8, printed, or inferred", is_inferred || printed.at(i, s, j) > 0);
        }
        count("equation 8, corrected", counts(OcclusionRule::corrected).at(i, s, j) > 0);
        count("inferred", is_inferred);
      }
  }
  return rows;
}

std::vector<BoundRow> bounds_of(const Plan& plan, const PlannedTake& planned, const PreparedTake& data) {
  std::vector<BoundRow> rows;
  std::vector<JointObservation> seen(plan.rig.size());
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      const Eigen::Vector3d& truth_m = data.truth(i, j, plan.joints.size());
      if (!truth_m.allFinite()) continue;
      observe_joint(data, i, plan.joints[j], planned.world_from_sensor, seen);
      const RangeProblem problem = ranges_of(seen, planned.world_from_sensor);
      if (problem.count < 3) continue;
      const double gdop = estimate_at(problem, truth_m, SolveStatus::closed_form, 0).gdop;
      if (!std::isfinite(gdop)) continue;
      BoundRow& row = row_of(rows, planned, plan.joints[j]);
      ++row.n;
      row.ranges += static_cast<std::uint64_t>(problem.count);
      for (std::size_t k = 0; k < static_cast<std::size_t>(problem.count); ++k) {
        const double error_m = problem.range_m[k] - (truth_m - problem.sensor_m[k]).norm();
        row.range_error_m2 += error_m * error_m;
      }
      row.gdop += gdop;
    }
  return rows;
}

}  // namespace trilat
