// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/fuse_session.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "datasets/base/error.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/take/take_paths.h"
#include "pipeline/accuracy/take/take_rays.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

constexpr std::size_t kTogether = 64;  // instants

Plan plan_of(const std::filesystem::path& session, const std::filesystem::path& calibration,
             const MethodSpec& method, double rate_hz) {
  StudySpec study;
  study.name = "fuse";
  study.rate_hz = rate_hz;
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

FusedPath::Point point_of(const PointEstimate& estimate) {
  FusedPath::Point point;
  point.status = static_cast<std::uint8_t>(estimate.status);
  point.is_usable = is_usable(estimate.status);
  if (point.is_usable) point.position_m = estimate.position_m.cast<float>();
  return point;
}

void solve_instants(const Plan& plan, const TakeData& data, const Watch& watch, FusedPath& path) {
  const PlannedTake& planned = plan.takes[0];
  const Method& method = plan.methods[0];
  const bool has_sigma = method.spec.kind == &method_kind("range_bearing");
  std::atomic<std::size_t> done{0};
  parallel_for_index(path.instants(), kTogether, [&](std::size_t i) {
    if (i % kTogether == 0) watch.check();
    std::vector<JointObservation> seen(plan.rig.size());
    for (std::size_t j = 0; j < plan.joints.size(); ++j) {
      observe_joint(data, i, plan.joints[j], planned.world_from_sensor, seen);
      const PointEstimate estimate =
          evaluate(method, {seen, planned.world_from_sensor, occlusions_of(data, i, plan.joints[j]),
                            ranges_of(seen, planned.world_from_sensor), sigma_at(data, i, j)});
      FusedPath::Point& point = path.points[i * plan.joints.size() + j];
      point = point_of(estimate);
      if (has_sigma) point.sigma_m = static_cast<float>(std::sqrt(estimate.covariance.trace() / 3.0));
    }
    watch.tell(static_cast<double>(++done) / static_cast<double>(path.instants()));
  });
}

void solve_paths(const Plan& plan, const TakeData& data, const Watch& watch, FusedPath& path) {
  std::atomic<std::size_t> done{0};
  const auto advanced = [&](std::size_t instants) {
    watch.tell(static_cast<double>(done += instants) / static_cast<double>(path.instants()));
  };
  const MethodPaths paths =
      solve_over_time(plan, plan.takes[0], data, {advanced, [&] { return watch.stopped(); }}).front();
  for (std::size_t k = 0; k < path.points.size(); ++k) {
    PointEstimate estimate = failed_estimate(paths.points[k].status);
    estimate.position_m = paths.points[k].position_m;
    path.points[k] = point_of(estimate);
  }
}

}  // namespace

FusedSession fuse_session(const std::filesystem::path& session, const std::filesystem::path& calibration,
                          const MethodSpec& method, double rate_hz, const Watch& watch) {
  const Plan plan = plan_of(session, calibration, method, rate_hz);
  TakeData data = load_take(plan, plan.takes[0], watch.stop_requested);
  estimate_sigmas(plan, plan.takes[0], data);
  FusedSession fused{.sensors = plan.rig, .rays = rays_of(plan, plan.takes[0], data), .notes = data.notes};
  FusedPath& path = fused.path;
  path.rate_hz = rate_hz;
  path.start_host_ns = data.time.front().ns;
  path.joints = plan.joints;
  path.points.resize(data.time.size() * plan.joints.size());
  for (int s = 0; s < kSolveStatusCount; ++s)
    path.status_names.emplace_back(name_of(static_cast<SolveStatus>(s)));
  if (is_over_time(plan.methods[0]))
    solve_paths(plan, data, watch, path);
  else
    solve_instants(plan, data, watch, path);
  for (const FusedPath::Point& point : path.points)
    fused.answered += point.is_usable ? 1.0 / static_cast<double>(path.points.size()) : 0.0;
  return fused;
}

}  // namespace trilat
