// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/simulated_run.h"

#include <map>
#include <optional>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/session/session_writer.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/tracker/body_tracker.h"
#include "datasets/synthetic/wand_motion.h"
#include "evaluators/calibration/wand_positions.h"
#include "pipeline/study/parallel.h"

namespace trilat {

StudyUnit draw_study_unit(std::uint64_t seed, std::uint64_t unit) {
  const DepthNoiseSpec noise;
  const DepthIntrinsics intrinsics = draw_sensor(SensorSpec{}, {seed, 0, 0}, unit, {}).intrinsics;
  const DepthUnit depth = draw_depth_unit(noise, seed, unit);
  return {depth, depth_rays(intrinsics), DepthRenderer(intrinsics, noise, depth)};
}

namespace {

constexpr std::uint64_t kUnitsOfSamples = 1000;  // the study's units for single samples come before

DepthScene scene_at(const WandInstant& instant, double ball_radius_m) {
  DepthScene scene;
  append_room(scene, RoomSpec{}, Eigen::Vector3d::Zero());
  if (!instant.is_held) {
    scene.spheres.push_back({instant.ball_in_world_m, ball_radius_m});
    return scene;
  }
  append_person(scene, instant.person);
  append_wand(scene, instant.ball_in_world_m, instant.stick_direction, {.ball_radius_m = ball_radius_m});
  return scene;
}

// A place of the wand as all sensors see it.
struct SeenPlace {
  WandPosition position;
  std::vector<std::map<std::string, std::uint64_t>>
      statuses;  // by sensor: how the search of each frame ended
};

SeenPlace see_place(const CalibrationSpec& spec, const std::vector<StudyUnit>& units,
                    const std::vector<RigidTransform>& world_from_sensor, std::uint64_t run_seed,
                    std::size_t place, const WandMotion& motion) {
  const WandHold& hold = motion.holds()[place];
  const DepthScene scene = scene_at(motion.at(0.5 * (hold.from_s + hold.to_s)), spec.ball_radius_m);
  FindWandOptions find;
  find.ball_radius_m = spec.ball_radius_m;
  SeenPlace seen{{{duration_from_s(hold.from_s).ns}, {duration_from_s(hold.to_s).ns}, {}}, {}};
  seen.statuses.resize(units.size());
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t s = 0; s < units.size(); ++s) {
    std::vector<TimedSighting> found;
    std::optional<Eigen::Vector3d> before_m;
    for (std::uint64_t frame = 0; frame < spec.position_frames; ++frame) {
      const RandomStream key{run_seed, Purpose::depth_pixel,
                             random_item(3, s, 0, place * spec.position_frames + frame)};
      units[s].renderer.render(scene, world_from_sensor[s], key, depth_mm);
      const WandSighting sighting =
          follow_wand({kDepthWidth, kDepthHeight, depth_mm}, units[s].rays, find, before_m);
      ++seen.statuses[s][name_of(sighting.status)];
      if (sighting.status == WandStatus::found)
        found.push_back({HostTime{static_cast<std::int64_t>(frame)}, sighting});
    }
    if (2 * found.size() >= spec.position_frames)
      seen.position.seen.push_back(mean_of_rest(found, s, WandPositionOptions{}.deviation));
  }
  return seen;
}

}  // namespace

SimulatedRun simulate_run(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                          std::uint64_t run, const Watch& watch) {
  const std::uint64_t run_seed = spec.seed + 1'000'003 * (run + 1);
  const WandMotion motion({.positions = spec.positions}, run_seed, {0.0, 1.0, 0.0}, Person{});
  std::vector<StudyUnit> units;
  SimulatedRun result;
  for (std::size_t s = 0; s < world_from_sensor.size(); ++s) {
    units.push_back(draw_study_unit(run_seed, kUnitsOfSamples + s));
    result.views.evidence.push_back({.name = fmt::format("k{}", s + 1), .statuses = {}});
  }
  std::vector<SeenPlace> places(motion.holds().size());
  parallel_for_index(places.size(), 1, [&](std::size_t p) {
    watch.check();
    places[p] = see_place(spec, units, world_from_sensor, run_seed, p, motion);
  });
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (std::size_t s = 0; s < units.size(); ++s) {
      SensorEvidence& evidence = result.views.evidence[s];
      evidence.frames += spec.position_frames;
      for (const auto& [status, count] : places[p].statuses[s]) evidence.statuses[status] += count;
    }
    if (places[p].position.seen.empty()) continue;
    result.views.positions.push_back(std::move(places[p].position));
    result.position_in_world_m.push_back(motion.holds()[p].ball_in_world_m);
  }
  result.views.positions_of_first = result.views.positions.size();
  if (result.position_in_world_m.size() < 3) return result;
  const auto& places_m = result.position_in_world_m;
  result.wand_from_world = wand_from_places(places_m[0], places_m[1], places_m[2]).value_or(RigidTransform{});
  result.movement_m = (result.position_in_world_m[1] - result.position_in_world_m[0]).norm();
  return result;
}

void write_walk(const CalibrationSpec& spec, const std::vector<RigidTransform>& world_from_sensor,
                std::uint64_t run, const BodyTrackerSpec& tracker_spec,
                const std::filesystem::path& session) {
  const SensorSpec sensor_spec;
  const SimulatedItem item{spec.seed + 1'000'003 * (run + 1), 0, run};
  const Motion walk = generated_motion(draw_person(spec.seed, run, 1.70, 0.17), Activity::walking);
  std::vector<SimulatedSensor> sensors;
  SessionHeader header;
  header.simulated = true;
  for (std::size_t s = 0; s < world_from_sensor.size(); ++s) {
    SensorPose pose;
    pose.name = fmt::format("k{}", s + 1);
    pose.world_from_sensor = world_from_sensor[s];
    sensors.push_back(draw_sensor(sensor_spec, item, s, pose));
    header.sensors.push_back(description_of(sensors.back(), sensor_spec));
  }
  SessionWriter writer(session, header);
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const auto frames = static_cast<std::uint64_t>(spec.bodies_s * sensor_spec.rate_hz);
    BodyTracker tracker(tracker_spec, sensor_spec, sensors[s], item);
    for (std::uint64_t f = 0; f < frames; ++f) {
      const SkeletonPose pose = walk((exposure_of(sensors[s], sensor_spec, f) - kMotionStart).seconds());
      const TrackedFrame tracked = tracker.observe(f, pose);
      auto frame = simulate_empty_frame(sensors[s], sensor_spec, item, f);
      if (!frame) continue;
      if (tracked.body) frame->bodies.push_back(*tracked.body);
      writer.add_body_frame(s, *frame);
    }
    const auto exchanges = static_cast<std::uint64_t>(spec.bodies_s / sensor_spec.exchange_period_s);
    for (std::uint64_t e = 0; e < exchanges; ++e)
      writer.add_clock_exchange(s, simulate_exchange(sensors[s], sensor_spec, item, e));
  }
  writer.finish();
}

}  // namespace trilat
