// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "datasets/mocap/mocap_writer.h"
#include "datasets/rig/rigid_transform.h"
#include "datasets/session/session_writer.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/depth/room_scene.h"

namespace trilat {

inline constexpr std::int64_t kStart_ns = 5'000'000'000'000;
inline constexpr std::int64_t kPlaceEvery_ns = 1'200'000'000;
inline constexpr std::int64_t kFrame_ns = 33'333'300;
inline constexpr int kFramesOfPlace = 20;

// Three places that define the wand's frame, and more to both sides and at different heights.
inline const std::vector<Eigen::Vector3d> kPlaces{{0.0, 1.0, 0.0},  {0.6, 1.0, 0.1},  {0.1, 1.5, 0.0},
                                                  {-0.5, 0.7, 0.3}, {0.4, 1.3, -0.5}, {-0.4, 1.6, -0.3},
                                                  {0.3, 0.6, 0.5},  {-0.6, 1.1, -0.5}};

inline std::vector<RigidTransform> rig_of(std::size_t sensors) {
  const double heights_m[] = {0.8, 1.7, 1.1, 2.0};
  std::vector<RigidTransform> rig;
  for (std::size_t s = 0; s < sensors; ++s) {
    const double angle = 0.5 + static_cast<double>(s) * std::numbers::pi / 2.0;
    rig.push_back(world_from_sensor_looking_at({2.0 * std::sin(angle), heights_m[s], 2.0 * std::cos(angle)},
                                               {0.0, 1.0, 0.0}));
  }
  return rig;
}

inline std::string name_of_sensor(std::size_t sensor) { return "k" + std::to_string(sensor + 1); }

inline SessionHeader header_of(std::size_t sensors, bool has_depth = true) {
  SessionHeader header;
  header.simulated = true;
  for (std::size_t s = 0; s < sensors; ++s) {
    SensorDescription sensor;
    sensor.name = name_of_sensor(s);
    sensor.serial = "serial" + std::to_string(s + 1);
    sensor.source = "simulated";
    sensor.has_depth = has_depth;
    header.sensors.push_back(sensor);
  }
  return header;
}

inline DepthScene ball_in_room(const Eigen::Vector3d& place, double radius_m = 0.075) {
  DepthScene scene;
  append_room(scene, {}, {0.0, 1.0, 0.0});
  append_wand(scene, place, Eigen::Vector3d(0.3, -0.9, 0.1).normalized(), {.ball_radius_m = radius_m});
  return scene;
}

// A body frame that has nobody in it, but the floor.
inline BodyFrame floor_seen_from(const RigidTransform& world_from_sensor, const FrameStamp& stamp) {
  const Eigen::Vector3f up =
      (world_from_sensor.rotation.conjugate() * Eigen::Vector3d::UnitY()).cast<float>();
  BodyFrame frame;
  frame.stamp = stamp;
  frame.floor_plane = {up.x(), up.y(), up.z(), static_cast<float>(world_from_sensor.translation_m.y())};
  return frame;
}

// Each scene for so many frames, as exact sensors see it that round to millimetres; a pause between them.
inline void record(const std::filesystem::path& path, const std::vector<RigidTransform>& rig,
                   const std::vector<DepthScene>& scenes, const SessionHeader& header,
                   int frames = kFramesOfPlace, bool floors = false) {
  SessionWriter writer(path, header);
  const DepthRenderer renderer({}, noise_free_depth(), {});
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  for (std::size_t s = 0; s < rig.size(); ++s)
    for (std::size_t p = 0; p < scenes.size(); ++p) {
      renderer.render(scenes[p], rig[s], {1, Purpose::depth_pixel, random_item(0, s, 0, p)}, depth_mm);
      EncodedDepthFrame frame = encode_depth_frame({}, depth_mm, ChunkCompression::blosc);
      for (int f = 0; f < frames; ++f) {
        const std::int64_t time_ns = static_cast<std::int64_t>(p) * kPlaceEvery_ns + f * kFrame_ns;
        frame.stamp = {static_cast<std::int64_t>(p) * kFramesOfPlace + f, 1000 + time_ns / 100,
                       kStart_ns + time_ns};
        writer.add_depth_frame(s, frame);
        if (floors) writer.add_body_frame(s, floor_seen_from(rig[s], frame.stamp));
      }
    }
  writer.finish();
}

inline void record_wand(const std::filesystem::path& path, const std::vector<RigidTransform>& rig) {
  std::vector<DepthScene> scenes;
  for (const Eigen::Vector3d& place : kPlaces) scenes.push_back(ball_in_room(place));
  record(path, rig, scenes, header_of(rig.size()));
}

// The ball at its places, or on its way for the whole time, at 100 Hz. The last digits are never still.
inline void write_wand_export(const std::filesystem::path& path, bool rests) {
  MocapHeader header;
  header.take_name = "wand";
  header.capture_rate_hz = header.export_rate_hz = 100.0;
  header.assets = {{AssetType::rigid_body, "Wand", "1", "", true}};
  OptitrackCsvWriter writer(path, header);
  for (int f = 0; f < 960; ++f) {
    const double time_s = 0.01 * f;
    const Eigen::Vector3d place =
        rests ? kPlaces[static_cast<std::size_t>(f / 120)] : Eigen::Vector3d(0.2 * time_s, 1.0, 0.0);
    const Eigen::Vector3d position_m = place + Eigen::Vector3d::Constant(f % 2 == 0 ? 2e-5 : -2e-5);
    writer.write(f, {&position_m, 1});
  }
  writer.finish();
}

}  // namespace trilat
