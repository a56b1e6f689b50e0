// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/fuse_session.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/version.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/take/solve_take.h"
#include "pipeline/accuracy/take/take_checks.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/study/hash_cache.h"

namespace trilat {
namespace {

Plan plan_of(const std::filesystem::path& session, const std::filesystem::path& calibration,
             const MethodSpec& method, double rate_hz) {
  StudySpec study;
  study.name = "fuse";
  study.rate_hz = rate_hz;
  study.truth = TruthSource::nothing;
  study.methods = {method};
  const SessionReader reader(session);
  for (const SensorDescription& sensor : reader.header().sensors) study.sensors.push_back(sensor.name);
  Take take;
  take.id = session.filename().string();
  take.session = session;
  take.calibration = calibration;
  Plan plan = make_plan(study, {.name = "fuse", .takes = {take}});
  if (!plan.takes[0].ok) throw InputError(plan.takes[0].place, plan.takes[0].problem);
  std::ranges::sort(plan.joints);  // as in every other file of bodies
  return plan;
}

void solve(const Plan& plan, const PreparedTake& data, const RunControl& control, FusedSession& fused) {
  const bool has_sigma = plan.methods[0].spec.kind == &method_kind("range_bearing");
  solve_take(plan, plan.takes[0], data, {}, false, control, [&](const SampleBlock& block) {
    const std::size_t first = block.first_instant * plan.joints.size();
    for (std::size_t k = 0; k < block.status.size(); ++k) {
      FusedPoint& point = fused.points[first + k];
      point.status = static_cast<SolveStatus>(block.status[k]);
      if (is_usable(point.status))
        point.position_m = Eigen::Map<const Eigen::Vector3f>(&block.estimate_m[3 * k]).cast<double>();
      if (has_sigma) point.sigma_m = block.sigma_m[k];
    }
  });
}

std::vector<ExchangedStretch> exchanged_stretches(const Plan& plan, const PreparedTake& data) {
  std::vector<ExchangedStretch> stretches;
  for (std::size_t s = 0; s < plan.rig.size(); ++s)
    for (std::size_t i = 0; i < data.time.size(); ++i) {
      if (!data.exchanges.at(i, s)) continue;
      const double since_s = (data.time[i] - data.time.front()).seconds();
      if (i == 0 || !data.exchanges.at(i - 1, s)) stretches.push_back({plan.rig[s], since_s, since_s});
      stretches.back().last_s = since_s;
    }
  return stretches;
}

}  // namespace

FusedSession fuse_session(const std::filesystem::path& session, const std::filesystem::path& calibration,
                          const MethodSpec& method, double rate_hz, const RunControl& control) {
  const Plan plan = plan_of(session, calibration, method, rate_hz);
  const PreparedTake data = load_take(plan, plan.takes[0], control.stop_requested);
  FusedSession fused{.rate_hz = rate_hz,
                     .start_host_ns = data.time.front().ns,
                     .joints = plan.joints,
                     .points = std::vector<FusedPoint>(data.time.size() * plan.joints.size()),
                     .sensors = method.sensors.empty() ? plan.rig : method.sensors,
                     .rays = estimate_ray_noise(plan, plan.takes[0], data),
                     .checks = data.checks,
                     .notes = data.notes,
                     .exchanged = exchanged_stretches(plan, data)};
  solve(plan, data, control, fused);
  for (const FusedPoint& point : fused.points)
    fused.answered += is_usable(point.status) ? 1.0 / static_cast<double>(fused.points.size()) : 0.0;
  return fused;
}

CorrectedCalibration correct_calibration(const std::filesystem::path& session,
                                         const std::filesystem::path& calibration,
                                         const RunControl& control) {
  WatchedFiles files;
  files.add(session);
  files.add(calibration);
  const auto method = read_as<MethodSpec>(Json{{"method", "range_bearing"}}, {"range_bearing", {}});
  const Plan plan = plan_of(session, calibration, method, 30.0);
  const PlannedTake& planned = plan.takes[0];
  const PreparedTake data = load_take(plan, planned, control.stop_requested);
  if (!data.shown.problem.empty())
    throw InputError(session.string(), "gives no estimate of the calibration: " + data.shown.problem);
  CorrectedCalibration result{read_calibration(calibration), check_poses(plan, planned, data).rows,
                              data.notes};
  Calibration& corrected = result.calibration;
  corrected.method = "corrected by bodies";
  corrected.program = kProgramVersion;
  corrected.positions = data.shown.rows;
  corrected.rejected.clear();
  corrected.reduced_chi2.reset();
  corrected.sources = {{session.filename().string(), hash_of_file(session, control.stop_requested)},
                       {calibration.filename().string(), hash_of_file(calibration, control.stop_requested)}};
  for (std::size_t s = 0; s < plan.rig.size(); ++s) {
    SensorPose& pose = *std::ranges::find(corrected.sensors, plan.rig[s], &SensorPose::name);
    const PoseCorrection& shown = data.shown.of_sensor[s];
    if (shown.views == 0) continue;  // stays as it was
    pose.world_from_sensor = data.corrected_rig[s];
    pose.covariance = shown.covariance.topLeftCorner<6, 6>();
    pose.rotation_sigma_rad = std::sqrt(pose.covariance->topLeftCorner<3, 3>().trace() / 3.0);
    pose.position_sigma_m = std::sqrt(pose.covariance->bottomRightCorner<3, 3>().trace() / 3.0);
    pose.used = shown.views;
    pose.left_out = 0;
    pose.residual_rms_m = shown.residual_rms_m;
  }
  files.check();
  return result;
}

JointTrack track_of(const FusedSession& fused) {
  JointTrack track;
  track.rate_hz = fused.rate_hz;
  track.frames = static_cast<std::int64_t>(fused.instants());
  for (const Joint joint : fused.joints) track.joints.emplace_back(name_of(joint));
  track.next = [&fused, at = std::size_t{0}](JointFrame& frame) mutable {
    frame = {};
    frame.time_s = static_cast<double>(at) / fused.rate_hz;
    const FusedPoint* points = fused.points.data() + at++ * fused.joints.size();
    for (const FusedPoint& point : std::span(points, fused.joints.size())) {
      frame.position_m.push_back(point.position_m);
      frame.sigma_m.push_back(point.sigma_m);
      frame.status.push_back(name_of(point.status));
    }
  };
  return track;
}

}  // namespace trilat
