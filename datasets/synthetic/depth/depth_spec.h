// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/wand_motion.h"

namespace trilat {

// How the virtual sensors' depth is made, and whether takes have it; a wand recording always does.
struct DepthSpec {
  DepthNoiseSpec noise;
  bool takes = false;
};

// A calibration recording beside the takes.
struct WandSpec {
  WandMotionSpec motion;
  WandShape shape;
  bool person = true;  // somebody holds the stick
};

// Recordings beside the takes that show how exactly depth is calibrated: all sensors stand at one point, 1.2
// m high, and look the same way at a ball that is held at one place after another, once before a far wall and
// once in the room with the person who holds it; then squarely at flat walls.
struct BenchSpec {
  std::uint64_t places = 40;
  double hold_s = 0.1;                          // at each
  std::vector<double> distances_m{0.3, 4.5};    // of the places: from, to
  double max_angle_rad = 35.0 * kRadPerDegree;  // from the lens' axis
  WandShape shape;
  std::vector<double> walls_m{2.0};  // distances, a recording each
  double wall_s = 3.0;               // of each
};

// Objects `depth`, `wand`, `bench` and `room` of simulation.json.
DepthSpec read_depth_spec(JsonObject object);
WandSpec read_wand_spec(JsonObject object);
BenchSpec read_bench_spec(JsonObject object);
RoomSpec read_room(JsonObject object);

}  // namespace trilat
