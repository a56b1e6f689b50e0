// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/calibration_spec.h"

#include <nlohmann/json.hpp>

#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.study";

void read_distances(JsonObject& object, std::vector<double>& distances_m) {
  if (!object.has("distances_m")) return;
  distances_m = object.numbers("distances_m", 2);
  if (!(distances_m[0] >= 0.2 && distances_m[0] < distances_m[1] && distances_m[1] <= 8.0))
    object.refuse("distances_m", "must be [from, to] within 0.2 to 8 m, the nearer first");
}

void read_sigmas(JsonObject& object, std::vector<double>& sigmas_m) {
  if (!object.has("sensor_sigmas_m")) return;
  const std::size_t size = object.value("sensor_sigmas_m").size();
  sigmas_m = object.numbers("sensor_sigmas_m", size);
  for (double sigma : sigmas_m)
    if (!(sigma >= 0.0 && sigma <= 1.0)) object.refuse("sensor_sigmas_m", "must lie between 0 and 1 m");
}

void read_rig_part(JsonObject& object, CalibrationSpec& spec) {
  if (object.has("rig")) {
    JsonObject rig = object.object("rig");
    setting(rig, "radius_m", spec.rig.radius_m, {1.0, 4.0}, "of the circle of sensors");
    if (rig.has("heights_m")) {
      const std::size_t sensors = rig.value("heights_m").size();
      if (sensors < 2 || sensors > 8) rig.refuse("heights_m", "must hold 2 to 8 heights, one a sensor");
      spec.rig.heights_m = rig.numbers("heights_m", sensors);
    }
    rig.about({{"heights_m", "one a sensor"}});
    rig.finish();
  }
  spec.runs = count_within(object, "runs", spec.runs, 0, 10'000);
  spec.positions = count_within(object, "positions", spec.positions, 3, 1000);
  spec.position_frames = count_within(object, "position_frames", spec.position_frames, 1, 100);
  spec.bodies_s = number_within(object, "bodies_s", spec.bodies_s, 0.0, 600.0);
  spec.bodies_instants = count_within(object, "bodies_instants", spec.bodies_instants, 1, 10'000);
}

}  // namespace

CalibrationSpec parse_calibration_spec(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  CalibrationSpec spec;
  object.format(kFormat);
  object.choice("kind", {"calibration"});
  spec.name = object.text("name");
  if (spec.name.empty()) object.refuse("name", "must not be empty");
  setting(object, "seed", spec.seed, "of every random number");
  setting(object, "ball_radius_m", spec.ball_radius_m, {0.02, 0.3}, "of the wand's ball");
  setting(object, "units", spec.units, {1, 1000},
          "sensors, each with its own depth offset, wiggle and optics");
  setting(object, "samples", spec.samples, {0, 100'000}, "wand positions a unit");
  setting(object, "near_samples", spec.near_samples, {0, 100'000}, "of them nearer than 0.5 m");
  if (spec.units * (spec.samples + spec.near_samples) > 200'000)
    object.refuse("samples", "make more than 200000 samples with these units");
  setting(object, "frames", spec.frames, {1, 100}, "whose mean is a sample");
  read_distances(object, spec.distances_m);
  setting(object, "largest_angle_deg", spec.largest_angle_deg, {0.0, 40.0},
          "of samples, from the central line");
  setting(object, "distortion_units", spec.distortion_units, {0, 1000}, "that look at a flat wall");
  setting(object, "distortion_frames", spec.distortion_frames, {1, 1'000'000}, "of the wall, a unit");
  setting(object, "wall_m", spec.wall_m, {0.5, 8.0}, "distance of the wall");
  read_rig_part(object, spec);
  setting(object, "effect_joints", spec.effect_joints, {0, 10'000'000},
          "that are found with uncertain sensors");
  setting(object, "range_sigma_m", spec.range_sigma_m, {1e-4, 1.0}, "of their ranges");
  read_sigmas(object, spec.sensor_sigmas_m);
  object.about({{"name", "of the study"},
                {"distances_m", "of samples: from, to"},
                {"rig", "of the calibrated rigs"},
                {"runs", "rigs that are calibrated"},
                {"positions", "of the wand, a rig"},
                {"position_frames", "whose mean is a position"},
                {"bodies_s", "of walking, for the calibration from bodies"},
                {"bodies_instants", "at which the bodies are compared"},
                {"sensor_sigmas_m", "of the sensors' positions"}});
  object.finish();
  return spec;
}

Json resolved_json(const CalibrationSpec& s) {
  return {{"format", kFormat},
          {"version", 1},
          {"kind", "calibration"},
          {"name", s.name},
          {"seed", s.seed},
          {"ball_radius_m", s.ball_radius_m},
          {"units", s.units},
          {"samples", s.samples},
          {"near_samples", s.near_samples},
          {"frames", s.frames},
          {"distances_m", s.distances_m},
          {"largest_angle_deg", s.largest_angle_deg},
          {"distortion_units", s.distortion_units},
          {"distortion_frames", s.distortion_frames},
          {"wall_m", s.wall_m},
          {"rig", {{"radius_m", s.rig.radius_m}, {"heights_m", s.rig.heights_m}}},
          {"runs", s.runs},
          {"positions", s.positions},
          {"position_frames", s.position_frames},
          {"bodies_s", s.bodies_s},
          {"bodies_instants", s.bodies_instants},
          {"effect_joints", s.effect_joints},
          {"range_sigma_m", s.range_sigma_m},
          {"sensor_sigmas_m", s.sensor_sigmas_m}};
}

}  // namespace trilat
