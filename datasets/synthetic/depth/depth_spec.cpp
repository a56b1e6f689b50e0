// SPDX-License-Identifier: MIT
#include "datasets/synthetic/depth/depth_spec.h"

#include <numbers>

#include "datasets/base/strict_json.h"

namespace trilat {
namespace {

AxialNoise read_axial(JsonObject object) {
  AxialNoise axial;
  axial.level_mm = number_within(object, "level_mm", axial.level_mm, -100.0, 100.0);
  axial.slope_mm = number_within(object, "slope_mm", axial.slope_mm, -100.0, 100.0);
  axial.square_mm = number_within(object, "square_mm", axial.square_mm, -100.0, 100.0);
  axial.angle_mm = number_within(object, "angle_mm", axial.angle_mm, -100.0, 100.0);
  object.about({{"level_mm", "constant part"},
                {"slope_mm", "for a metre of depth"},
                {"square_mm", "for a square metre"},
                {"angle_mm", "with the angle to the surface"}});
  object.finish();
  return axial;
}

// Two keys that are the ends of a range.
void read_range(JsonObject& object, const std::string& low_key, const std::string& high_key, double& low,
                double& high, double least, double largest) {
  low = number_within(object, low_key, low, least, largest);
  high = number_within(object, high_key, high, least, largest);
  if (high < low) object.refuse(high_key, "must not be less than " + low_key);
}

}  // namespace

DepthSpec read_depth_spec(JsonObject object) {
  DepthSpec depth;
  DepthNoiseSpec& n = depth.noise;
  depth.takes = object.boolean("takes", depth.takes);
  if (object.has("axial")) n.axial = read_axial(object.object("axial"));
  n.lateral_sigma_m = number_within(object, "lateral_sigma_m", n.lateral_sigma_m, 0.0, 0.1);
  n.corner_noise_factor = number_within(object, "corner_noise_factor", n.corner_noise_factor, 0.0, 100.0);
  n.offset_limit_m = number_within(object, "offset_limit_m", n.offset_limit_m, 0.0, 1.0);
  read_range(object, "wiggle_amplitude_low_m", "wiggle_amplitude_high_m", n.wiggle_amplitude_low_m,
             n.wiggle_amplitude_high_m, 0.0, 1.0);
  read_range(object, "wiggle_length_low_m", "wiggle_length_high_m", n.wiggle_length_low_m,
             n.wiggle_length_high_m, 0.1, 100.0);
  n.edge_step_m = number_within(object, "edge_step_m", n.edge_step_m, 0.001, 100.0);
  n.edge_dropped_share = share_within(object, "edge_dropped_share", n.edge_dropped_share);
  n.grazing_limit_rad =
      number_within(object, "grazing_limit_rad", n.grazing_limit_rad, 0.1, std::numbers::pi / 2.0);
  n.valid_radius = number_within(object, "valid_radius", n.valid_radius, 0.1, 2.0);
  n.nearest_m = number_within(object, "nearest_m", n.nearest_m, 0.1, 65.0);
  n.farthest_m = number_within(object, "farthest_m", n.farthest_m, 0.1, 65.0);
  if (n.farthest_m <= n.nearest_m) object.refuse("farthest_m", "must be farther than nearest_m");
  object.about({{"takes", "whether takes have depth images"},
                {"axial", "noise along the axis, one standard deviation"},
                {"lateral_sigma_m", "jitter across the ray, at the surface"},
                {"corner_noise_factor", "on axial noise in the image's corners"},
                {"offset_limit_m", "constant offset of a unit, uniform in +-"},
                {"wiggle_amplitude_low_m", "of a unit's error that is periodic in depth"},
                {"wiggle_amplitude_high_m", "the other end"},
                {"wiggle_length_low_m", "its period"},
                {"wiggle_length_high_m", "the other end"},
                {"edge_step_m", "neighbours farther apart make an edge"},
                {"edge_dropped_share", "of pixels at edges"},
                {"grazing_limit_rad", "from the surface's normal; beyond, a pixel is invalid"},
                {"valid_radius", "of the image, normalised"},
                {"nearest_m", "that is measured"},
                {"farthest_m", "that is measured"}});
  object.finish();
  return depth;
}

WandSpec read_wand_spec(JsonObject object) {
  WandSpec wand;
  wand.motion.positions = object.count("positions", wand.motion.positions);
  object.range("positions", 3, 10'000);
  if (wand.motion.positions < 3 || wand.motion.positions > 10'000)
    object.refuse("positions", "must be 3 to 10000; the first three define the calibration's frame");
  wand.motion.hold_s = number_within(object, "hold_s", wand.motion.hold_s, 0.1, 3600.0);
  wand.motion.move_s = number_within(object, "move_s", wand.motion.move_s, 0.1, 3600.0);
  wand.shape.ball_radius_m = number_within(object, "ball_radius_m", wand.shape.ball_radius_m, 0.01, 0.3);
  wand.shape.stick_radius_m =
      number_within(object, "stick_radius_m", wand.shape.stick_radius_m, 0.001, wand.shape.ball_radius_m);
  wand.shape.stick_length_m = number_within(object, "stick_length_m", wand.shape.stick_length_m, 0.1, 5.0);
  wand.person = object.boolean("person", wand.person);
  object.about({{"positions", "where the wand is held"},
                {"hold_s", "at each"},
                {"move_s", "from one to the next"},
                {"ball_radius_m", "of its ball"},
                {"stick_radius_m", "of its stick"},
                {"stick_length_m", "of its stick"},
                {"person", "somebody holds it"}});
  object.finish();
  return wand;
}

RoomSpec read_room(JsonObject object) {
  RoomSpec room;
  room.half_width_m = number_within(object, "half_width_m", room.half_width_m, 0.5, 100.0);
  room.half_depth_m = number_within(object, "half_depth_m", room.half_depth_m, 0.5, 100.0);
  room.walls = static_cast<int>(count_within(object, "walls", static_cast<std::uint64_t>(room.walls), 0, 4));
  object.about({{"half_width_m", "from the centre to the side walls"},
                {"half_depth_m", "from the centre to the other walls"},
                {"walls", "that the room has"}});
  object.finish();
  return room;
}

}  // namespace trilat
