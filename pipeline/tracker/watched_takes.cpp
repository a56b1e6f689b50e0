// SPDX-License-Identifier: MIT
#include "pipeline/tracker/watched_takes.h"

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/session_reader.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "pipeline/accuracy/take/take_data.h"

namespace trilat {
namespace {

constexpr double kRate_hz = 30.0;

StudySpec study_of(bool with_truth) {
  StudySpec study;
  study.name = "measure-tracker";
  study.rate_hz = kRate_hz;
  study.clock = ClockSource::stated;
  study.truth = with_truth ? TruthSource::mocap : TruthSource::nothing;
  study.repair_exchanges = false;
  const Json mean{{"method", "mean"}};
  JsonObject object(mean, "measure-tracker", "");
  study.methods = {read_method(object)};
  return study;
}

// What rests in the frames of one sensor that show one body.
std::array<double, kTrackerGroups> jitter_of(const SessionReader& session, std::size_t sensor,
                                             const SensorClockMap& host_from_sensor) {
  std::vector<double> time_s;
  std::vector<ObservedBody> bodies;
  constexpr std::uint64_t kBlock = 1024;
  const std::uint64_t frames = session.counts(sensor).body_frames;
  for (std::uint64_t first = 0; first < frames; first += kBlock)
    for (const BodyFrame& frame : session.body_frames(sensor, first, std::min(kBlock, frames - first))) {
      if (frame.bodies.size() != 1) continue;
      ObservedBody& body = bodies.emplace_back();
      time_s.push_back((host_from_sensor(frame.stamp) - HostTime{0}).seconds());
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const auto& at = frame.bodies[0].position_m[j];
        body.joint_in_sensor_m[j] = {at[0], at[1], at[2]};
        body.state[j] = static_cast<TrackingState>(frame.bodies[0].tracking_state[j]);
      }
    }
  return resting_jitter_m(time_s, bodies);
}

WatchedTake watched(const Plan& plan, const PlannedTake& planned, bool simulated, const Watch& watch) {
  const SessionReader session(planned.take.session);
  TakeData data = load_take(plan, planned, watch.stop_requested);
  WatchedTake take;
  take.participant = planned.take.participant;
  take.rig = planned.take.calibration.string();
  take.step_s = 1.0 / kRate_hz;
  take.world_from_sensor = planned.world_from_sensor;
  take.bodies = std::move(data.bodies);
  std::array<double, kTrackerGroups> sum{}, count{};
  for (std::size_t s = 0; s < planned.session_sensor.size(); ++s) {
    take.intrinsics.push_back(session.header().sensors[planned.session_sensor[s]].intrinsics);
    const auto jitter_m = jitter_of(session, planned.session_sensor[s], planned.host_from_sensor[s]);
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      if (std::isfinite(jitter_m[g])) {
        sum[g] += jitter_m[g];
        count[g] += 1.0;
      }
  }
  for (std::size_t g = 0; g < kTrackerGroups; ++g) take.jitter_m[g] = sum[g] / count[g];  // NaN without
  if (!has_mocap_truth(planned.take)) return take;
  take.truth_kind = simulated ? TruthKind::exact : TruthKind::markers;
  take.truth_m.assign(data.time.size() * kJointCount, Eigen::Vector3d::Constant(kNaN));
  for (std::size_t i = 0; i < data.time.size(); ++i)
    for (std::size_t j = 0; j < plan.joints.size(); ++j)
      take.truth_m[i * kJointCount + static_cast<std::size_t>(plan.joints[j])] =
          data.truth(i, j, plan.joints.size());
  return take;
}

}  // namespace

WatchedCampaign read_watched_takes(const Campaign& campaign, const Watch& watch) {
  WatchedCampaign result;
  double done = 0.0;
  for (const bool with_truth : {true, false}) {
    Campaign part = campaign;
    std::erase_if(part.takes, [&](const Take& take) { return take.mocap.empty() == with_truth; });
    if (part.takes.empty()) continue;
    const Plan plan = make_plan(study_of(with_truth), part, watch);
    for (const PlannedTake& planned : plan.takes) {
      watch.check();
      watch.tell(done++ / static_cast<double>(campaign.takes.size()));
      std::string problem = planned.ok ? "" : planned.place + ": " + planned.problem;
      if (problem.empty()) try {
          result.takes.push_back(watched(plan, planned, campaign.simulated, watch));
        } catch (const InputError& error) {
          problem = error.what();
        }
      if (!problem.empty()) result.left_out.push_back(fmt::format("{}: {}", planned.take.id, problem));
    }
  }
  if (result.takes.empty())
    throw InputError(campaign.folder.empty() ? campaign.name : campaign.folder.string(),
                     result.left_out.empty()
                         ? "has no takes"
                         : "has no take that can be used; the first: " + result.left_out.front());
  return result;
}

}  // namespace trilat
