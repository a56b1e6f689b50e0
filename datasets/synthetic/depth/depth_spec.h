// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/units.h"
#include "datasets/synthetic/depth/depth_renderer.h"
#include "datasets/synthetic/depth/room_scene.h"
#include "datasets/synthetic/wand_motion.h"

namespace trilat {

// How the virtual sensors' depth is made, and whether takes have it; a wand recording always does.
struct DepthSpec {
  DepthNoiseSpec noise;
  bool takes = false;

  static void fields(auto& self, auto&& f) {
    auto& n = self.noise;
    f("takes", self.takes, opt("whether takes have depth images"));
    f("axial", n.axial, opt("noise along the axis, one standard deviation"));
    f("lateral_sigma_m", n.lateral_sigma_m, opt("jitter across the ray, at the surface", {0.0, 0.1}));
    f("corner_noise_factor", n.corner_noise_factor,
      opt("on axial noise in the image's corners", {0.0, 100.0}));
    f("offset_limit_m", n.offset_limit_m, opt("constant offset of a unit, uniform in +-", {0.0, 1.0}));
    f("wiggle_amplitude_low_m", n.wiggle_amplitude_low_m,
      opt("of a unit's error that is periodic in depth", {0.0, 1.0}));
    f("wiggle_amplitude_high_m", n.wiggle_amplitude_high_m, opt("the other end", {0.0, 1.0}));
    f("wiggle_length_low_m", n.wiggle_length_low_m, opt("its period", {0.1, 100.0}));
    f("wiggle_length_high_m", n.wiggle_length_high_m, opt("the other end", {0.1, 100.0}));
    f("edge_step_m", n.edge_step_m, opt("neighbours farther apart make an edge", {0.001, 100.0}));
    f("edge_dropped_share", n.edge_dropped_share, opt("of pixels at edges", {0.0, 1.0}));
    f("grazing_limit_rad", n.grazing_limit_rad,
      opt("from the surface's normal; beyond, a pixel is invalid", {0.1, std::numbers::pi / 2.0}));
    f("valid_radius", n.valid_radius, opt("of the image, normalised", {0.1, 2.0}));
    f("nearest_m", n.nearest_m, opt("that is measured", {0.1, 65.0}));
    f("farthest_m", n.farthest_m, opt("that is measured", {0.1, 65.0}));
  }
  void check(const JsonPlace& place) const {
    if (noise.farthest_m <= noise.nearest_m) place.at("farthest_m").refuse("must be farther than nearest_m");
    if (noise.wiggle_amplitude_high_m < noise.wiggle_amplitude_low_m)
      place.at("wiggle_amplitude_high_m").refuse("must not be less than wiggle_amplitude_low_m");
    if (noise.wiggle_length_high_m < noise.wiggle_length_low_m)
      place.at("wiggle_length_high_m").refuse("must not be less than wiggle_length_low_m");
  }
};

void visit_wand_shape(auto& f, auto& shape) {
  f("ball_radius_m", shape.ball_radius_m, opt("of its ball", {0.01, 0.3}));
  f("stick_radius_m", shape.stick_radius_m, opt("of its stick, at most the ball's", {0.001, 0.3}));
  f("stick_length_m", shape.stick_length_m, opt("of its stick", {0.1, 5.0}));
}
inline void check_wand_shape(const WandShape& shape, const JsonPlace& place) {
  if (shape.stick_radius_m > shape.ball_radius_m)
    place.at("stick_radius_m").refuse("must not be greater than ball_radius_m");
}

// A calibration recording beside the takes.
struct WandSpec {
  WandMotionSpec motion;
  WandShape shape;
  bool person = true;  // somebody holds the stick

  static void fields(auto& self, auto&& f) {
    f("positions", self.motion.positions,
      opt("where the wand is held; the first three define the calibration's frame", {3.0, 10'000.0}));
    f("hold_s", self.motion.hold_s, opt("at each", {0.1, 3600.0}));
    f("move_s", self.motion.move_s, opt("from one to the next", {0.1, 3600.0}));
    visit_wand_shape(f, self.shape);
    f("person", self.person, opt("somebody holds it"));
  }
  void check(const JsonPlace& place) const { check_wand_shape(shape, place); }
};

// Recordings beside the takes that show how exactly depth is calibrated: all sensors stand at one point, 1.2
// m high, and look the same way at a ball that is held at one place after another, once before a far wall and
// once in the room with the person who holds it; then squarely at flat walls.
struct BenchSpec {
  std::uint64_t places = 40;
  double hold_s = 0.1;                          // at each
  std::array<double, 2> distances_m{0.3, 4.5};  // of the places: from, to
  double max_angle_rad = 35.0 * kRadPerDegree;  // from the lens' axis
  WandShape shape;
  std::vector<double> walls_m{2.0};  // distances, a recording each
  double wall_s = 3.0;               // of each

  static void fields(auto& self, auto&& f) {
    f("places", self.places, opt("of the ball", {0.0, 10'000.0}));
    f("hold_s", self.hold_s, opt("at each", {0.05, 3600.0}));
    f("distances_m", self.distances_m, opt("of the places from the sensors: from, to", {0.2, 8.0}));
    f("max_angle_deg", self.max_angle_rad,
      opt("of the places, from the lens' axis", {0.0, 40.0}, kRadPerDegree));
    visit_wand_shape(f, self.shape);
    f("walls_m", self.walls_m, opt("distances of flat walls, a recording each", {0.5, 7.0}).items(0, 20));
    f("wall_s", self.wall_s, opt("of each wall", {0.1, 3600.0}));
  }
  void check(const JsonPlace& place) const {
    if (distances_m[0] >= distances_m[1]) place.at("distances_m").refuse("must have the nearer end first");
    check_wand_shape(shape, place);
  }
};

}  // namespace trilat
