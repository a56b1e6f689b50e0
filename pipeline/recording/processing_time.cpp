// SPDX-License-Identifier: MIT
#include "pipeline/recording/processing_time.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"
#include "datasets/session/body_readings.h"
#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/tracker/body_tracker.h"
#include "evaluators/metrics/quantiles.h"
#include "pipeline/accuracy/methods/method.h"

namespace trilat {
namespace {

constexpr std::uint64_t kWarmUpFrames = 30;

// A frame's bodies as the sensors deliver them, one a sensor.
struct RigFrame {
  std::vector<Body> bodies;
};

struct Rig {
  SensorSpec spec;
  std::vector<SimulatedSensor> sensors;
  std::vector<BodyTracker> trackers;
  std::vector<RigidTransform> world_from_sensor;
  std::vector<std::string> names;
};

// All sensors expose at once, so that nothing is left to interpolate.
Rig make_rig(const RecordingSpec& spec) {
  Rig rig;
  rig.spec.rate_hz = spec.rate_hz;
  rig.spec.free_running = false;
  rig.spec.dropped_share = 0.0;
  const std::vector<double> heights_m = RigSpec{}.heights_m;
  RigSpec poses;
  poses.heights_m.clear();
  for (std::uint64_t s = 0; s < spec.sensors; ++s) poses.heights_m.push_back(heights_m[s % heights_m.size()]);
  for (const SensorPose& pose : rig_poses(poses, {0.0, 1.0, 0.0})) {
    rig.sensors.push_back(draw_sensor(rig.spec, {spec.seed, 0, 0}, rig.sensors.size(), pose));
    rig.trackers.emplace_back(default_body_tracker(), rig.spec, rig.sensors.back(),
                              SimulatedItem{spec.seed, 0, 0});
    rig.world_from_sensor.push_back(pose.world_from_sensor);
    rig.names.push_back(pose.name);
  }
  return rig;
}

RigFrame see(Rig& rig, const Motion& motion, std::uint64_t frame) {
  RigFrame result;
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    const SkeletonPose pose = motion((exposure_of(rig.sensors[s], rig.spec, frame) - kMotionStart).seconds());
    result.bodies.push_back(rig.trackers[s].observe(frame, pose).body.value_or(Body{}));
  }
  return result;
}

// The work that is timed.
void trilaterate(const Rig& rig, const RigFrame& frame, const Method& method,
                 std::vector<PointEstimate>& estimates) {
  std::vector<JointObservation> seen(frame.bodies.size());
  for (std::size_t j = 0; j < kJointCount; ++j) {
    for (std::size_t s = 0; s < frame.bodies.size(); ++s) {
      const Body& body = frame.bodies[s];
      seen[s] = {};
      if (reading_of(body, j) == JointReading::seen)
        seen[s] = observe(Eigen::Map<const Eigen::Vector3f>(body.position_m[j].data()).cast<double>(),
                          static_cast<TrackingState>(body.tracking_state[j]), rig.world_from_sensor[s]);
    }
    const JointInstant instant{seen, rig.world_from_sensor, {}, ranges_of(seen, rig.world_from_sensor)};
    estimates[j] = evaluate(method, instant);
  }
}

// Time of the slowest of the sensors' machines, which track side by side. Simulated.
double body_tracking_s(const RecordingSpec& spec, std::uint64_t frame) {
  double slowest_s = 0.0;
  for (std::uint64_t s = 0; s < spec.sensors; ++s) {
    const RandomStream random{spec.seed, Purpose::arrival_delay, random_item(0, s, 3, frame)};
    slowest_s =
        std::max(slowest_s, spec.body_tracking_s - spec.body_tracking_jitter_s * std::log(random.uniform(0)));
  }
  return slowest_s;
}

}  // namespace

std::vector<StageTiming> time_processing(const RecordingSpec& spec, const Watch& watch) {
  using Clock = std::chrono::steady_clock;
  if (spec.methods.empty()) return {};
  Rig rig = make_rig(spec);
  StudySpec study;
  study.methods = spec.methods;
  const std::vector<Method> methods = resolve_methods(study, rig.names);
  const Motion motion = generated_motion(draw_person(spec.seed, 0, 1.70, 0.17), Activity::walking);
  std::vector<std::vector<double>> times_s(methods.size());
  std::vector<PointEstimate> estimates(kJointCount);
  for (std::uint64_t f = 0; f < kWarmUpFrames + spec.frames; ++f) {
    watch.check();
    const RigFrame frame = see(rig, motion, f);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Clock::time_point start = Clock::now();
      trilaterate(rig, frame, methods[m], estimates);
      if (f >= kWarmUpFrames)
        times_s[m].push_back(std::chrono::duration<double>(Clock::now() - start).count());
    }
    watch.tell(static_cast<double>(f + 1) / static_cast<double>(kWarmUpFrames + spec.frames));
  }
  std::vector<StageTiming> stages;
  for (std::size_t m = 0; m < methods.size(); ++m)
    stages.push_back({"trilateration", methods[m].spec.name, spread_times(times_s[m])});
  for (std::size_t m = 0; m < methods.size(); ++m) {
    for (std::uint64_t f = 0; f < spec.frames; ++f) times_s[m][f] += body_tracking_s(spec, f);
    stages.push_back({kDepthToJoints, methods[m].spec.name, spread_times(std::move(times_s[m]))});
  }
  return stages;
}

TimeSpread spread_times(std::vector<double> times_s) {
  std::erase_if(times_s, [](double t) { return !std::isfinite(t); });
  TimeSpread spread;
  spread.n = times_s.size();
  for (double t : times_s) {
    const auto edge = std::upper_bound(kTimeEdges_s.begin() + 1, kTimeEdges_s.end(), t);
    ++spread.bins[static_cast<std::size_t>(edge - kTimeEdges_s.begin()) - 1];
  }
  if (times_s.empty()) return spread;
  const auto q = quantiles_of(times_s, {0.5, 0.95, 0.99, 0.999, 1.0});
  spread.median_s = q[0];
  spread.p95_s = q[1];
  spread.p99_s = q[2];
  spread.p999_s = q[3];
  spread.max_s = q[4];
  return spread;
}

}  // namespace trilat
