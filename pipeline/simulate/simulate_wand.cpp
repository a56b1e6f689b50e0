// SPDX-License-Identifier: MIT
#include "pipeline/simulate/simulate_wand.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/mocap/optitrack_csv_writer.h"
#include "datasets/synthetic/simulated_markers.h"
#include "pipeline/simulate/simulate_take.h"
#include "pipeline/study/parallel.h"
#include "recorders/recorder.h"

namespace trilat {
namespace {

constexpr std::uint64_t kWandTake = (1u << 14) - 1;  // the last that random numbers have room for

void write_wand_mocap(const SimulationSpec& spec, const WandMotion& wand, const std::filesystem::path& path,
                      const std::function<bool()>& stop_requested) {
  const std::int64_t frames = mocap_frames(spec.mocap, wand.duration_s());
  OptitrackCsvWriter writer(path, simulated_mocap_header("wand simulated", spec.mocap.rate_hz, frames,
                                                         AssetType::rigid_body, {"wand"}));
  MocapFrame frame;
  frame.poses.resize(1);
  for (std::int64_t f = 0; f < frames; ++f) {
    if (f % 256 == 0 && stop_requested && stop_requested()) throw Interrupted();
    const WandInstant instant = wand.at(static_cast<double>(f) / spec.mocap.rate_hz);
    frame.index = f;
    frame.poses[0].position_m = simulate_rigid_body(instant.ball_in_world_m, spec.mocap, wand_item(spec),
                                                    static_cast<std::uint64_t>(f));
    writer.write(frame);
  }
  writer.finish();
}

void write_wand_truth(const SimulationSpec& spec, const WandMotion& wand,
                      const std::vector<SimulatedSensor>& sensors, const std::filesystem::path& path) {
  const SimulatedItem item = wand_item(spec);
  Json truth = simulated_truth(item, sensors, mocap_clock_error(spec.mocap, item), &spec.depth.noise);
  truth["ball_radius_m"] = spec.wand->shape.ball_radius_m;
  Json positions = Json::array();
  for (const WandHold& hold : wand.holds())
    positions.push_back(
        {{"position_m", {hold.ball_in_world_m.x(), hold.ball_in_world_m.y(), hold.ball_in_world_m.z()}},
         {"from_host_ns", (kMotionStart + duration_from_s(hold.from_s)).ns},
         {"to_host_ns", (kMotionStart + duration_from_s(hold.to_s)).ns}});
  truth["positions"] = positions;
  write_file(path, truth.dump(2) + "\n");
}

}  // namespace

double wand_duration_s(const WandSpec& wand) {
  return static_cast<double>(wand.motion.positions) * (wand.motion.hold_s + wand.motion.move_s) -
         wand.motion.move_s;
}

SimulatedItem wand_item(const SimulationSpec& spec) { return {spec.seed, kWandTake, 0}; }

HostTime wand_mocap_start(const SimulationSpec& spec) {
  return kMotionStart + mocap_clock_error(spec.mocap, wand_item(spec));
}

void simulate_wand(const SimulationSpec& spec, const std::vector<SensorPose>& poses,
                   const Eigen::Vector3d& rig_centre_m, const std::filesystem::path& folder,
                   const Watch& watch) {
  make_folder(folder);
  const SimulatedItem item = wand_item(spec);
  const Person person = draw_person(spec.seed, 0, spec.stature_mean_m, spec.stature_half_range_m);
  const WandMotion wand(spec.wand->motion, spec.seed, rig_centre_m, person);
  std::vector<SimulatedSensor> sensors;
  for (const SensorPose& pose : poses)
    sensors.push_back(draw_sensor(spec.sensor, item, sensors.size(), pose));
  const auto shows_person = [&](const WandInstant& instant) { return spec.wand->person && instant.is_held; };
  const Motion motion = [&](double t) {
    const WandInstant instant = wand.at(t);
    return shows_person(instant) ? instant.person : SkeletonPose();
  };
  const SceneMotion scene = [&](double t) {
    const WandInstant instant = wand.at(t);
    DepthScene seen;
    append_room(seen, spec.room, rig_centre_m);
    if (shows_person(instant)) append_person(seen, instant.person);
    if (instant.is_held)
      append_wand(seen, instant.ball_in_world_m, instant.stick_direction, spec.wand->shape);
    else
      seen.spheres.push_back({instant.ball_in_world_m, spec.wand->shape.ball_radius_m});
    return seen;
  };
  SyntheticSource source(spec.sensor, item, motion, sensors, wand.duration_s(), {spec.body_tracker},
                         watched_depth(spec, sensors.size(), wand.duration_s(), scene, watch));
  RecordOptions options;
  options.stop_requested = watch.stop_requested;
  record(source, folder / "session.h5", options);
  write_wand_mocap(spec, wand, folder / "mocap.csv", watch.stop_requested);
  write_wand_truth(spec, wand, sensors, folder / "truth.json");
}

SyntheticDepth watched_depth(const SimulationSpec& spec, std::size_t sensors, double duration_s,
                             SceneMotion scene, const Watch& watch) {
  const double expected = std::max(1.0, duration_s * spec.sensor.rate_hz * static_cast<double>(sensors));
  const ForEach for_each = [watch, expected, done = 0.0](
                               std::size_t count, const std::function<void(std::size_t)>& body) mutable {
    parallel_for_index(count, 1, [&](std::size_t i) {
      watch.check();
      body(i);
    });
    done += static_cast<double>(count);
    watch.tell(std::min(1.0, done / expected));
  };
  return {std::move(scene), spec.depth.noise, for_each};
}

}  // namespace trilat
