// SPDX-License-Identifier: MIT
#pragma once

#include "datasets/base/strict_json.h"
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

// Objects `depth`, `wand` and `room` of simulation.json.
DepthSpec read_depth_spec(JsonObject object);
WandSpec read_wand_spec(JsonObject object);
RoomSpec read_room(JsonObject object);

}  // namespace trilat
