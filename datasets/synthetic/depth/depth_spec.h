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
    f("takes", self.takes, opt("Whether takes have depth images, with the stamps of the frames of bodies"));
    f("axial", n.axial, opt("Noise along the axis, one standard deviation"));
    f("lateral_sigma_m", n.lateral_sigma_m, opt("Jitter across the ray, at the surface", {0.0, 0.1}));
    f("corner_noise_factor", n.corner_noise_factor,
      opt("Factor on the axial noise in the image's corners", {0.0, 100.0}));
    f("offset_limit_m", n.offset_limit_m, opt("Constant offset of a unit, uniform in +-", {0.0, 1.0}));
    f("wiggle_amplitude_low_m", n.wiggle_amplitude_low_m,
      opt("Smallest amplitude of a unit's error that is periodic in depth", {0.0, 1.0}));
    f("wiggle_amplitude_high_m", n.wiggle_amplitude_high_m,
      opt("Largest amplitude of that error", {0.0, 1.0}));
    f("wiggle_length_low_m", n.wiggle_length_low_m, opt("Shortest period of that error", {0.1, 100.0}));
    f("wiggle_length_high_m", n.wiggle_length_high_m, opt("Longest period of that error", {0.1, 100.0}));
    f("edge_step_m", n.edge_step_m,
      opt("Step in depth between neighbours that makes an edge", {0.001, 100.0}));
    f("edge_dropped_share", n.edge_dropped_share,
      opt("Share of the pixels at edges that are invalid", {0.0, 1.0}));
    f("grazing_limit_rad", n.grazing_limit_rad,
      opt("Angle from the surface's normal beyond which a pixel is invalid", {0.1, std::numbers::pi / 2.0}));
    f("valid_radius", n.valid_radius,
      opt("Normalised radius of the image within which pixels are valid", {0.1, 2.0}));
    f("nearest_m", n.nearest_m, opt("Nearest depth that is measured", {0.1, 65.0}));
    f("farthest_m", n.farthest_m, opt("Farthest depth that is measured", {0.1, 65.0}));
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
  f("ball_radius_m", shape.ball_radius_m, opt("Radius of the ball", {0.01, 0.3}));
  f("stick_radius_m", shape.stick_radius_m, opt("Radius of the stick, at most the ball's", {0.001, 0.3}));
  f("stick_length_m", shape.stick_length_m, opt("Length of the stick", {0.1, 5.0}));
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
      opt("Number of places where the wand is held: the first 0.6 to 0.7 m from the middle of the rig, 1 m "
          "high, the second as far on the other side, the third 0.6 m above the first, the others within 0.9 "
          "m of the middle, 0.4 to 1.7 m high",
          {3.0, 10'000.0}));
    f("hold_s", self.motion.hold_s, opt("Time at each place", {0.1, 3600.0}));
    f("move_s", self.motion.move_s, opt("Time from one place to the next", {0.1, 3600.0}));
    visit_wand_shape(f, self.shape);
    f("person", self.person, opt("Whether somebody holds the wand"));
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
    f("places", self.places,
      opt("Number of places of the ball, before a far wall and in the room with who holds it; below 0.8 m "
          "three times as dense as beyond",
          {0.0, 10'000.0}));
    f("hold_s", self.hold_s, opt("Time at each place", {0.05, 3600.0}));
    f("distances_m", self.distances_m, opt("Distances of the places from the sensors: from, to", {0.2, 8.0}));
    f("max_angle_deg", self.max_angle_rad,
      opt("Largest angle of the places from the lens' axis", {0.0, 40.0}, kRadPerDegree));
    visit_wand_shape(f, self.shape);
    f("walls_m", self.walls_m, opt("Distances of flat walls, a recording each", {0.5, 7.0}).items(0, 20));
    f("wall_s", self.wall_s, opt("Time at each wall", {0.1, 3600.0}));
  }
  void check(const JsonPlace& place) const {
    if (distances_m[0] >= distances_m[1]) place.at("distances_m").refuse("must have the nearer end first");
    check_wand_shape(shape, place);
  }
};

}  // namespace trilat
