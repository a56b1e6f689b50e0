// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "datasets/base/document.h"
#include "datasets/base/units.h"
#include "datasets/results/results_file.h"

namespace trilat {

// Source of the true distance of the ball.
enum class WandTruth : std::uint8_t {
  stated,     // places.csv
  optitrack,  // OptiTrack's export, in the pose that the other places give the sensor
  sensors     // the other sensors, in the poses that the other places give
};
template <>
inline constexpr std::array words<WandTruth>{"stated", "optitrack", "sensors"};

// The ball as one method found it in one sensor's frames at one place.
struct WandSample {
  std::size_t method = 0;  // of wand_method_names()
  std::size_t sensor = 0, place = 0;
  double distance_m = 0.0;         // true, from the sensor to the ball's centre
  double angle_rad = kNaN;         // true, from the lens' axis; NaN: not known
  double distance_error_m = kNaN;  // absolute; NaN: no answer
  double error_m = kNaN;           // in three dimensions; NaN: no answer, or only the distance is known

  static constexpr bool kIsList = true;
  static void fields(auto& self, auto&& f) {
    f("method", self.method, "sensor", self.sensor, "place", self.place, "distance_m", self.distance_m,
      "angle_rad", self.angle_rad, "distance_error_m", self.distance_error_m, "error_m", self.error_m);
  }
};

// A sensor's pose by one way to calibrate, beside the one that the campaign states.
struct PoseDifference {
  std::string method, sensor;
  double position_m = kNaN, rotation_rad = kNaN;
  double position_sigma_m = kNaN, rotation_sigma_rad = kNaN;  // stated, an axis
  std::string problem = {};  // reason why the method gives no pose; empty with one

  static void fields(auto& self, auto&& f) {
    f("method", self.method, "sensor", self.sensor, "position_m", self.position_m, "rotation_rad",
      self.rotation_rad, "position_sigma_m", self.position_sigma_m, "rotation_sigma_rad",
      self.rotation_sigma_rad, "problem", self.problem);
  }
};

// One recording of a ball that was held at places whose distance is known.
struct WandRecording {
  std::string name;
  WandTruth truth = WandTruth::stated;
  bool simulated = false;
  double ball_radius_m = 0.0;
  std::uint64_t frames = 0;  // whose mean is a sample, at most
  std::vector<std::string> sensors;
  std::vector<WandSample> samples;
  std::vector<std::map<std::string, std::uint64_t>> statuses;  // by method: how the samples ended
  std::vector<PoseDifference> poses;
  std::vector<std::string> notes;

  static void fields(auto& self, auto&& f) {
    f("name", self.name, "truth", self.truth, "simulated", self.simulated, "ball_radius_m",
      self.ball_radius_m, "frames", self.frames, "sensors", self.sensors, "samples", self.samples, "statuses",
      self.statuses, "poses", self.poses, "notes", self.notes);
  }
};

// A flat wall as one sensor saw it. Columns are those of the image's middle row.
struct WallRow {
  std::string recording, sensor;
  double stated_m = kNaN;    // distance of the wall, where it is stated
  double distance_m = kNaN;  // of the fitted plane, along the lens' axis
  double tilt_rad = kNaN;    // between the plane's normal and the lens' axis
  std::uint64_t frames = 0;
  double noise_m = kNaN;           // standard deviation of a pixel's depth over time; median over the wall
  std::vector<double> residual_m;  // mean absolute difference of a column's depth from the plane
  std::vector<double> printed_error_m;  // sideways, of eq. 4 as printed (E2)

  static void fields(auto& self, auto&& f) {
    f("recording", self.recording, "sensor", self.sensor, "stated_m", self.stated_m, "distance_m",
      self.distance_m, "tilt_rad", self.tilt_rad, "frames", self.frames, "noise_m", self.noise_m,
      "residual_m", self.residual_m, "printed_error_m", self.printed_error_m);
  }
};

// One recording of a flat wall.
struct WallRecording {
  bool simulated = false;
  std::vector<WallRow> rows;
  static void fields(auto& self, auto&& f) { f("simulated", self.simulated, "rows", self.rows); }
};

// Outcomes of all recordings of a study.
struct CalibrationRecordings {
  std::vector<WandRecording> wands;
  std::vector<WallRow> walls;
};

// summary.json of a study of kind "calibration". Its numbers are, by recording (the condition),
// - "ball_distance" and "ball_position" (in three dimensions), by method and kZones or a bin of distance or
// angle
//   (the group): mean with its interval over sensors, sd, median, p95 and max of the absolute errors; what is
//   "answered" there, and by which status;
// - "pose" and "rotation", by method and sensor: the difference from the campaign's calibration, and the
//   stated sigma of an axis;
// - "wall", "tilt", "residual" and "sideways" (eq. 4), by sensor: see calibration_numbers().
struct CalibrationSummary {
  static constexpr StudyKind kKind = StudyKind::calibration;
  std::string study, campaign;
  std::string paper = name_of(PaperStudy::none);
  bool simulated = false;               // any recording
  std::vector<std::string> recordings;  // that were evaluated
  std::string stated_distances;         // the first of them whose distances are stated; empty without one
  std::vector<std::string> failed;      // those that could not be, each with the reason
  std::uint64_t rows = 0;
  Numbers numbers = {};

  static void fields(auto& self, auto&& f) {
    f("study", self.study, "campaign", self.campaign, "paper", self.paper, "simulated", self.simulated,
      "recordings", self.recordings, "stated_distances", self.stated_distances, "failed", self.failed, "rows",
      self.rows);
  }
};

}  // namespace trilat
