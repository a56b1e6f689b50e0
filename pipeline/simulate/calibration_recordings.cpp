// SPDX-License-Identifier: MIT
#include "pipeline/simulate/calibration_recordings.h"

#include <algorithm>
#include <memory>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/text_output.h"
#include "datasets/base/units.h"
#include "datasets/mocap/mocap_writer.h"
#include "datasets/synthetic/simulated_markers.h"
#include "pipeline/calibration/wand_views.h"
#include "pipeline/simulate/simulate_take.h"
#include "pipeline/study/parallel.h"
#include "recorders/capture.h"

namespace trilat {
namespace {

constexpr std::uint64_t kWandTake = (1u << 14) - 1;  // the last that random numbers have room for

void write_wand_mocap(const SimulationSpec& spec, const WandMotion& wand, const std::filesystem::path& path,
                      const std::function<bool()>& stop_requested) {
  const std::int64_t frames = mocap_frames(spec.mocap, wand.duration_s());
  OptitrackCsvWriter writer(path, simulated_mocap_header("wand simulated", spec.mocap.rate_hz, frames,
                                                         AssetType::rigid_body, {"wand"}));
  for (std::int64_t f = 0; f < frames; ++f) {
    if (f % 256 == 0 && stop_requested && stop_requested()) throw Interrupted();
    const WandInstant instant = wand.at(static_cast<double>(f) / spec.mocap.rate_hz);
    const Eigen::Vector3d wand_m = simulate_rigid_body(instant.ball_in_world_m, spec.mocap, wand_item(spec),
                                                       static_cast<std::uint64_t>(f));
    writer.write(f, {&wand_m, 1});
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
                   const RunControl& control) {
  make_folder(folder);
  const SimulatedItem item = wand_item(spec);
  const Person person = draw_person(spec.seed, 0, spec.stature.mean_m, spec.stature.half_range_m);
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
    DepthScene seen;
    append_room(seen, spec.room, rig_centre_m);
    append_wand_instant(seen, wand.at(t), spec.wand->shape, spec.wand->person);
    return seen;
  };
  SyntheticSource source(spec.sensor, item, motion, sensors, wand.duration_s(), {spec.body_tracker},
                         watched_depth(spec, sensors.size(), wand.duration_s(), scene, control));
  RecordOptions options;
  options.stop_requested = control.stop_requested;
  record(source, folder / "session.h5", options);
  write_wand_mocap(spec, wand, folder / "mocap.csv", control.stop_requested);
  write_wand_truth(spec, wand, sensors, folder / "truth.json");
}

SyntheticDepth watched_depth(const SimulationSpec& spec, std::size_t sensors, double duration_s,
                             SceneMotion scene, const RunControl& control) {
  const double expected = std::max(1.0, duration_s * spec.sensor.rate_hz * static_cast<double>(sensors));
  const ForEach for_each = [control, expected, done = 0.0](
                               std::size_t count, const std::function<void(std::size_t)>& body) mutable {
    parallel_for_index(count, 1, [&](std::size_t i) {
      control.check();
      body(i);
    });
    done += static_cast<double>(count);
    control.report(std::min(1.0, done / expected));
  };
  return {std::move(scene), spec.depth.noise, for_each};
}

namespace {

constexpr double kBenchHeight_m = 1.2;
constexpr double kFarWall_m = 7.0;
constexpr double kPersonBehind_m = 1.2;  // behind the ball
constexpr double kMaxTilt_deg = 15.0;    // of a place's direction from the horizontal plane through the lens
// Distances below the paper's recommended range are few, so places there are so many times as dense.
constexpr double kNear_m = 0.8, kNearDensity = 3.0;

// Behind all takes and the wand.
SimulatedItem bench_item(const SimulationSpec& spec, std::uint64_t recording) {
  return {spec.seed, kWandTake - 1 - recording, 0};
}

// Distance below which a share (0 to 1) of the places lies.
double place_distance_m(const BenchSpec& bench, double share) {
  const double from_m = bench.distances_m[0], to_m = bench.distances_m[1];
  const double knee_m = std::clamp(kNear_m, from_m, to_m);
  const double near = kNearDensity * (knee_m - from_m), near_share = near / (near + to_m - knee_m);
  return share < near_share ? from_m + share / near_share * (knee_m - from_m)
                            : knee_m + (share - near_share) / (1.0 - near_share) * (to_m - knee_m);
}

struct BenchPlace {
  double distance_m = 0.0, angle_rad = 0.0;
  Eigen::Vector3d ball_in_sensor_m;
};

// Each place has its own part of the span of distances, to both sides of the axis.
std::vector<BenchPlace> bench_places(const SimulationSpec& spec) {
  const BenchSpec& bench = *spec.bench;
  std::vector<BenchPlace> places;
  for (std::uint64_t p = 0; p < bench.places; ++p) {
    const RandomStream random{spec.seed, Purpose::wand_sample, p};
    BenchPlace place;
    place.distance_m = place_distance_m(
        bench, (static_cast<double>(p) + random.uniform(0)) / static_cast<double>(bench.places));
    place.angle_rad = random.uniform(1, 0.0, bench.max_angle_rad);
    const double turn_rad = random.uniform(2, -kMaxTilt_deg, kMaxTilt_deg) * kRadPerDegree +
                            (random.uniform(3) < 0.5 ? std::numbers::pi : 0.0);
    const double sine = std::sin(place.angle_rad);
    place.ball_in_sensor_m =
        place.distance_m *
        Eigen::Vector3d(sine * std::cos(turn_rad), sine * std::sin(turn_rad), std::cos(place.angle_rad));
    places.push_back(place);
  }
  return places;
}

// Before a far wall the ball hangs alone: only there eq. 2 can work, which keeps what is nearer than half of
// the mean depth. In the room the stick comes from the right hand of somebody behind the ball.
DepthScene ball_scene(const BenchSpec& bench, const RoomSpec& room, bool in_room,
                      const Eigen::Vector3d& ball_in_world_m) {
  DepthScene scene;
  if (!in_room) {
    scene.spheres.push_back({ball_in_world_m, bench.shape.ball_radius_m});
    scene.planes.push_back({-Eigen::Vector3d::UnitZ(), -kFarWall_m});
    return scene;
  }
  SkeletonPose person = generated_motion(Person{}, Activity::standing)(0.0);
  const Eigen::Vector3d away(ball_in_world_m.x(), 0.0, ball_in_world_m.z());
  const Eigen::Vector3d stand_m = away + kPersonBehind_m * away.normalized() - person.at(Joint::spine_base);
  for (Eigen::Vector3d& joint : person.joint_in_world_m)
    joint += Eigen::Vector3d(stand_m.x(), 0.0, stand_m.z());
  append_wand(scene, ball_in_world_m, (person.at(Joint::hand_right) - ball_in_world_m).normalized(),
              bench.shape);
  append_person(scene, person);
  append_room(scene, room, {0.0, 0.0, 2.5});
  return scene;
}

void record_bench(const SimulationSpec& spec, std::uint64_t recording, double duration_s,
                  const SceneMotion& scene, const std::filesystem::path& folder, const RunControl& control) {
  make_folder(folder);
  const SimulatedItem item = bench_item(spec, recording);
  std::vector<SimulatedSensor> sensors;
  for (std::size_t s = 0; s < spec.rig.heights_m.size(); ++s) {
    SensorPose pose;
    pose.name = fmt::format("k{}", s + 1);
    pose.world_from_sensor.translation_m = {0.0, kBenchHeight_m, 0.0};
    sensors.push_back(draw_sensor(spec.sensor, item, s, pose));
  }
  const Motion no_person = [](double) { return SkeletonPose(); };
  SyntheticSource source(spec.sensor, item, no_person, sensors, duration_s, {spec.body_tracker},
                         watched_depth(spec, sensors.size(), duration_s, scene, control));
  RecordOptions options;
  options.stop_requested = control.stop_requested;
  record(source, folder / "session.h5", options);
  write_file(folder / "truth.json",
             simulated_truth(item, sensors, Duration{0}, &spec.depth.noise).dump(2) + "\n");
}

void write_places(const SimulationSpec& spec, const std::vector<BenchPlace>& places,
                  const std::filesystem::path& folder) {
  constexpr double kMargin_s = 0.005;  // of both ends of a hold, for the fitted clocks
  const double before_s = (start_of_depth(SessionReader(folder / "session.h5")) - kMotionStart).seconds();
  TextOutput csv(folder / "places.csv");
  csv.add("from_s,to_s,sensor,distance_m,angle_deg\n");
  for (std::size_t p = 0; p < places.size(); ++p)
    for (std::size_t s = 0; s < spec.rig.heights_m.size(); ++s) {
      const double from_s = static_cast<double>(p) * spec.bench->hold_s - before_s;
      csv.add("{:.4f},{:.4f},k{},{:.5f},{:.3f}\n", from_s + kMargin_s,
              from_s + spec.bench->hold_s - kMargin_s, s + 1, places[p].distance_m,
              places[p].angle_rad * kDegreesPerRad);
    }
  csv.publish();
}

CalibrationRecording ball_recording(const std::shared_ptr<const SimulationSpec>& spec, bool in_room) {
  const BenchSpec& bench = *spec->bench;
  const double duration_s = static_cast<double>(bench.places) * bench.hold_s;
  return {in_room ? "bench_room" : "bench_far_wall", duration_s,
          [=](const std::filesystem::path& folder, const RunControl& control) {
            const std::vector<BenchPlace> places = bench_places(*spec);
            const SceneMotion scene = [&](double t) {
              const double last = static_cast<double>(places.size() - 1);
              const auto p = static_cast<std::size_t>(std::clamp(t / spec->bench->hold_s, 0.0, last));
              const Eigen::Vector3d height(0.0, kBenchHeight_m, 0.0);
              return ball_scene(*spec->bench, spec->room, in_room, height + places[p].ball_in_sensor_m);
            };
            record_bench(*spec, in_room ? 1 : 0, duration_s, scene, folder, control);
            write_places(*spec, places, folder);
          },
          [=](const std::filesystem::path& folder, Campaign& campaign) {
            campaign.stated_distances.push_back(
                {folder / "session.h5", folder / "places.csv", spec->bench->shape.ball_radius_m});
          }};
}

CalibrationRecording wall_recording(const std::shared_ptr<const SimulationSpec>& spec, std::size_t number) {
  const double wall_m = spec->bench->walls_m[number];
  return {fmt::format("bench_wall_{:g}m", wall_m), spec->bench->wall_s,
          [=](const std::filesystem::path& folder, const RunControl& control) {
            DepthScene wall;
            wall.planes.push_back({-Eigen::Vector3d::UnitZ(), -wall_m});
            record_bench(
                *spec, 2 + number, spec->bench->wall_s, [&](double) { return wall; }, folder, control);
          },
          [=](const std::filesystem::path& folder, Campaign& campaign) {
            campaign.walls.push_back({folder / "session.h5", wall_m});
          }};
}

}  // namespace

std::vector<CalibrationRecording> calibration_recordings(const SimulationSpec& given,
                                                         const std::vector<SensorPose>& poses,
                                                         const Eigen::Vector3d& rig_centre_m) {
  const auto spec = std::make_shared<const SimulationSpec>(given);
  std::vector<CalibrationRecording> recordings;
  if (spec->wand)
    recordings.push_back({"wand", wand_duration_s(*spec->wand),
                          [=](const std::filesystem::path& folder, const RunControl& control) {
                            simulate_wand(*spec, poses, rig_centre_m, folder, control);
                          },
                          [=](const std::filesystem::path& folder, Campaign& campaign) {
                            campaign.wand = {folder / "session.h5", folder / "mocap.csv", "wand",
                                             wand_mocap_start(*spec).ns, spec->wand->shape.ball_radius_m};
                          }});
  if (!spec->bench) return recordings;
  if (spec->bench->places > 0)
    for (const bool in_room : {false, true}) recordings.push_back(ball_recording(spec, in_room));
  for (std::size_t w = 0; w < spec->bench->walls_m.size(); ++w) recordings.push_back(wall_recording(spec, w));
  return recordings;
}

}  // namespace trilat
