// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/depth_spec.h"

#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"

namespace trilat {
namespace {

AxialNoise read_axial(JsonObject object) {
  AxialNoise axial;
  setting(object, "level_mm", axial.level_mm, {-100.0, 100.0}, "constant part");
  setting(object, "slope_mm", axial.slope_mm, {-100.0, 100.0}, "for a metre of depth");
  setting(object, "square_mm", axial.square_mm, {-100.0, 100.0}, "for a square metre");
  setting(object, "angle_mm", axial.angle_mm, {-100.0, 100.0}, "with the angle to the surface");
  object.finish();
  return axial;
}

// Two keys that are the ends of a range.
void read_range(JsonObject& object, const char* low_key, const char* high_key, double& low, double& high,
                Limits<double> limits, const char* meaning) {
  setting(object, low_key, low, limits, meaning);
  setting(object, high_key, high, limits, "the other end");
  if (high < low) object.refuse(high_key, std::string("must not be less than ") + low_key);
}

void read_shape(JsonObject& object, WandShape& shape) {
  setting(object, "ball_radius_m", shape.ball_radius_m, {0.01, 0.3}, "of its ball");
  setting(object, "stick_radius_m", shape.stick_radius_m, {0.001, shape.ball_radius_m}, "of its stick");
  setting(object, "stick_length_m", shape.stick_length_m, {0.1, 5.0}, "of its stick");
}

constexpr std::size_t kMaxWalls = 20;

}  // namespace

DepthSpec read_depth_spec(JsonObject object) {
  DepthSpec depth;
  DepthNoiseSpec& n = depth.noise;
  setting(object, "takes", depth.takes, "whether takes have depth images");
  if (object.has("axial")) n.axial = read_axial(object.object("axial"));
  setting(object, "lateral_sigma_m", n.lateral_sigma_m, {0.0, 0.1}, "jitter across the ray, at the surface");
  setting(object, "corner_noise_factor", n.corner_noise_factor, {0.0, 100.0},
          "on axial noise in the image's corners");
  setting(object, "offset_limit_m", n.offset_limit_m, {0.0, 1.0}, "constant offset of a unit, uniform in +-");
  read_range(object, "wiggle_amplitude_low_m", "wiggle_amplitude_high_m", n.wiggle_amplitude_low_m,
             n.wiggle_amplitude_high_m, {0.0, 1.0}, "of a unit's error that is periodic in depth");
  read_range(object, "wiggle_length_low_m", "wiggle_length_high_m", n.wiggle_length_low_m,
             n.wiggle_length_high_m, {0.1, 100.0}, "its period");
  setting(object, "edge_step_m", n.edge_step_m, {0.001, 100.0}, "neighbours farther apart make an edge");
  setting(object, "edge_dropped_share", n.edge_dropped_share, {0.0, 1.0}, "of pixels at edges");
  setting(object, "grazing_limit_rad", n.grazing_limit_rad, {0.1, std::numbers::pi / 2.0},
          "from the surface's normal; beyond, a pixel is invalid");
  setting(object, "valid_radius", n.valid_radius, {0.1, 2.0}, "of the image, normalised");
  setting(object, "nearest_m", n.nearest_m, {0.1, 65.0}, "that is measured");
  setting(object, "farthest_m", n.farthest_m, {0.1, 65.0}, "that is measured");
  if (n.farthest_m <= n.nearest_m) object.refuse("farthest_m", "must be farther than nearest_m");
  object.about({{"axial", "noise along the axis, one standard deviation"}});
  object.finish();
  return depth;
}

WandSpec read_wand_spec(JsonObject object) {
  WandSpec wand;
  setting(object, "positions", wand.motion.positions, "where the wand is held");
  object.range("positions", 3, 10'000);
  if (wand.motion.positions < 3 || wand.motion.positions > 10'000)
    object.refuse("positions", "must be 3 to 10000; the first three define the calibration's frame");
  setting(object, "hold_s", wand.motion.hold_s, {0.1, 3600.0}, "at each");
  setting(object, "move_s", wand.motion.move_s, {0.1, 3600.0}, "from one to the next");
  read_shape(object, wand.shape);
  setting(object, "person", wand.person, "somebody holds it");
  object.finish();
  return wand;
}

BenchSpec read_bench_spec(JsonObject object) {
  BenchSpec bench;
  setting(object, "places", bench.places, {0, 10'000}, "of the ball");
  setting(object, "hold_s", bench.hold_s, {0.05, 3600.0}, "at each");
  if (object.has("distances_m")) {
    bench.distances_m = object.numbers("distances_m", 2);
    if (!(bench.distances_m[0] >= 0.2 && bench.distances_m[0] < bench.distances_m[1] &&
          bench.distances_m[1] <= 8.0))
      object.refuse("distances_m", "must be [from, to] within 0.2 to 8 m, the nearer first");
  }
  setting(object, "max_angle_deg", bench.max_angle_rad, {0.0, 40.0}, "of the places, from the lens' axis",
          kRadPerDegree);
  read_shape(object, bench.shape);
  if (object.has("walls_m")) {
    bench.walls_m = object.numbers("walls_m", object.value("walls_m").size());
    for (const double wall_m : bench.walls_m)
      if (!(wall_m >= 0.5 && wall_m <= 7.0))
        object.refuse("walls_m", fmt::format("has {:g}; walls stand 0.5 to 7 m away", wall_m));
    if (bench.walls_m.size() > kMaxWalls)
      object.refuse("walls_m", fmt::format("must hold at most {} distances", kMaxWalls));
  }
  setting(object, "wall_s", bench.wall_s, {0.1, 3600.0}, "of each wall");
  object.about({{"distances_m", "of the places from the sensors: from, to"},
                {"walls_m", "distances of flat walls, a recording each"}});
  object.finish();
  return bench;
}

RoomSpec read_room(JsonObject object) {
  RoomSpec room;
  setting(object, "half_width_m", room.half_width_m, {0.5, 100.0}, "from the centre to the side walls");
  setting(object, "half_depth_m", room.half_depth_m, {0.5, 100.0}, "from the centre to the other walls");
  setting(object, "walls", room.walls, {0, 4}, "that the room has");
  object.finish();
  return room;
}

}  // namespace trilat
