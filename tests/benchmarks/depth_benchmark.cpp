// SPDX-License-Identifier: MIT
// The depth renderer beside the plain one, in one process: floor, three walls, a person and a wand, seen by
// four sensors with all the noise there is. Usage: depth_benchmark [FRAMES].
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include <fmt/format.h>

#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/simulated_sensor.h"
#include "datasets/synthetic/wand_motion.h"
#include "tests/support/plain_depth_renderer.h"

namespace trilat {
namespace {

constexpr std::size_t kSensors = 4;

struct Setting {
  WandMotion wand{{}, 1, {0.0, 1.0, 0.0}, Person{}};
  std::vector<SimulatedSensor> sensors;
  std::vector<DepthRenderer> ours;
  std::vector<PlainDepthRenderer> plain;

  Setting() {
    for (const SensorPose& pose : rig_poses({}, {0.0, 1.0, 0.0})) {
      sensors.push_back(draw_sensor({}, {1, 0, 0}, sensors.size(), pose));
      const DepthUnit unit = draw_depth_unit({}, 1, sensors.size());
      ours.emplace_back(sensors.back().intrinsics, DepthNoiseSpec{}, unit);
      plain.emplace_back(sensors.back().intrinsics, DepthNoiseSpec{}, unit);
    }
  }
  DepthScene scene(std::size_t frame) const {
    const WandInstant instant = wand.at(static_cast<double>(frame / kSensors) / 30.0);
    DepthScene scene;
    append_room(scene, {}, {0.0, 1.0, 0.0});
    append_person(scene, instant.person);
    append_wand(scene, instant.ball_in_world_m, instant.stick_direction, {});
    return scene;
  }
  const RigidTransform& pose(std::size_t frame) const {
    return sensors[frame % kSensors].pose.world_from_sensor;
  }
};

RandomStream key_of(std::size_t frame) {
  return {1, Purpose::depth_pixel, random_item(0, frame % kSensors, 0, frame / kSensors)};
}

// Milliseconds a frame, the frames being handed out to the threads.
template <class Render>
double time_of(std::size_t frames, int threads, const Render& render) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    std::vector<std::uint16_t> image(kDepthPixels);
    for (std::size_t f; (f = next.fetch_add(1)) < frames;) render(f, image);
  };
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  return taken.count() / static_cast<double>(frames);
}

void run(std::size_t frames) {
  const Setting setting;
  const auto ours = [&](std::size_t f, std::vector<std::uint16_t>& image) {
    setting.ours[f % kSensors].render(setting.scene(f), setting.pose(f), key_of(f), image);
  };
  const auto plain = [&](std::size_t f, std::vector<std::uint16_t>& image) {
    image = setting.plain[f % kSensors].render(setting.scene(f), setting.pose(f), key_of(f));
  };
  std::size_t differing = 0;
  std::vector<std::uint16_t> a(kDepthPixels), b(kDepthPixels);
  for (std::size_t f = 0; f < kSensors; ++f) {
    ours(f, a);
    plain(f, b);
    for (std::size_t i = 0; i < a.size(); ++i) differing += std::abs(int{a[i]} - int{b[i]}) > 1;
  }
  fmt::print("pixels of {} frames that differ by more than 1 mm: {} of {}\n\n", kSensors, differing,
             kSensors * kDepthPixels);
  double ours_ms[3] = {0.0, 1e300, 1e300}, plain_ms[3] = {0.0, 1e300, 1e300};
  for (int repetition = 0; repetition < 3; ++repetition)
    for (int threads : {1, 2}) {
      ours_ms[threads] = std::min(ours_ms[threads], time_of(frames, threads, ours));
      plain_ms[threads] =
          std::min(plain_ms[threads], time_of(std::max<std::size_t>(8, frames / 20), threads, plain));
    }
  fmt::print(
      "{} surfaces, lowest of 3 repetitions\n",
      setting.scene(0).capsules.size() + setting.scene(0).spheres.size() + setting.scene(0).planes.size());
  for (int threads : {1, 2})
    fmt::print(
        "{} thread{}: ours {:7.2f} ms a frame {:7.1f} frames/s   plain {:7.2f} ms {:6.1f} frames/s   {:.1f} "
        "x\n",
        threads, threads == 1 ? " " : "s", ours_ms[threads], 1e3 / ours_ms[threads], plain_ms[threads],
        1e3 / plain_ms[threads], plain_ms[threads] / ours_ms[threads]);
}

}  // namespace
}  // namespace trilat

int main(int count, char** arguments) {
  trilat::run(count > 1 ? std::strtoul(arguments[1], nullptr, 10) : 400);
}
