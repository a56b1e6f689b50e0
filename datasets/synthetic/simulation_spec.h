// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/document.h"
#include "datasets/base/files.h"
#include "datasets/rig/calibration.h"
#include "datasets/rig/campaign.h"
#include "datasets/rig/depth_camera.h"
#include "datasets/synthetic/depth/depth_spec.h"
#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"

namespace trilat {

// Places of the virtual sensors: on a circle about `centre_m` (its y is the height they look at), at one
// height each. Different heights make the vertical observable from ranges; see docs/reference/methods.md on
// rigs of one height.
struct RigSpec {
  // In a document a list, or an object of heights at equal steps in one of their orders around the circle.
  struct Heights : std::vector<double> {
    using std::vector<double>::vector;
    void read(const Json& json, const JsonPlace& place, const About& about);
    static Json schema(const About& about);
  };
  double radius_m = 2.0;
  Heights heights_m{0.6, 2.2, 0.9, 1.9};
  double arc_rad =
      2.0 * std::numbers::pi;  // of the circle; each sensor has an equal part, and stands in its middle
  double arc_start_rad = 0.0;  // from +z towards +x: where the arc begins
  // Errors of the calibration, an axis: sensors stand elsewhere, and turned otherwise, than it says.
  double position_sigma_m = 0.0, rotation_sigma_rad = 0.0;
  std::optional<Eigen::Vector3d> centre_m = {};  // default: (0, 1, 0), or the middle of a real take's assets

  static void fields(auto& self, auto&& f) {
    f("radius_m", self.radius_m, opt("Radius of the circle on which the sensors stand", {0.3, 20.0}));
    f("heights_m", self.heights_m,
      opt("Heights above the floor, one a sensor, named k1, k2 and so on; or an object of heights at equal "
          "steps",
          {0.0, 8.0})
          .items(1, 8));
    f("arc_deg", self.arc_rad,
      opt("Part of the circle, in degrees: of n sensors, which look at the centre, the i-th stands at "
          "arc_start_deg + arc_deg (i - 1/2) / n (x = r sin, z = r cos from the centre)",
          {1.0, 360.0}, kRadPerDegree));
    f("arc_start_deg", self.arc_start_rad,
      opt("Start of the arc, from +z towards +x; a person who stands faces +z", {-360.0, 360.0},
          kRadPerDegree));
    f("position_sigma_m", self.position_sigma_m,
      opt("Error of the positions in the calibration that is written, one standard deviation an axis: the "
          "sensors stand elsewhere",
          {0.0, 1.0}));
    f("rotation_sigma_deg", self.rotation_sigma_rad,
      opt("Error of its rotations, one standard deviation an axis", {0.0, 45.0}, kRadPerDegree));
    f("centre_m", self.centre_m,
      opt("Point that the sensors look at; without it (0, 1, 0), or the middle of a recorded take's assets"));
  }
};

// The virtual sensor. Every value is a declared assumption; sources in docs/explanation/simulator.md. Nothing
// is tuned to the paper's tables.
struct SensorSpec {
  double rate_hz = 30.0;
  double nearest_m = 0.5;
  double farthest_m = 4.5;
  double dropped_share = 0.01;      // of frames
  double clock_drift_ppm = 30.0;    // uniform in +-, of sensor and of its PC
  double latency_s = 0.020;         // exposure to arrival, the constant part
  double arrival_jitter_s = 0.001;  // mean of the exponential part
  double exchange_period_s = 0.25;
  double exchange_jitter_s = 0.0003;  // mean of the exponential part of each way's delay
  bool free_running = true;           // each sensor with its own phase, clock origin and drift
  double focal_spread_px = 1.0;       // uniform in +-, between units
  double centre_spread_px = 6.0;

  static void fields(auto& self, auto&& f) {
    f("rate_hz", self.rate_hz, opt("Frames a second", {1.0, 1000.0}));
    f("nearest_m", self.nearest_m, opt("Nearest distance at which a joint is seen", {0.0, 100.0}));
    f("farthest_m", self.farthest_m, opt("Farthest distance at which a joint is seen", {0.0, 100.0, true}));
    f("dropped_share", self.dropped_share, opt("Share of frames that are lost", {0.0, 1.0}));
    f("clock_drift_ppm", self.clock_drift_ppm,
      opt("Drift of the clocks of sensor and machine, uniform in +-", {0.0, 500.0}));
    f("latency_s", self.latency_s, opt("Constant part of the time from exposure to arrival", {0.0, 1.0}));
    f("arrival_jitter_s", self.arrival_jitter_s, opt("Mean of its exponential part", {0.0, 1.0}));
    f("exchange_period_s", self.exchange_period_s,
      opt("Time between two exchanges of clock messages", {0.01, 3600.0}));
    f("exchange_jitter_s", self.exchange_jitter_s,
      opt("Mean of the exponential part of their delay", {0.0, 1.0}));
    f("free_running", self.free_running,
      opt("Whether each sensor has its own phase, clock origin and drift"));
    f("focal_spread_px", self.focal_spread_px,
      opt("Differences of the focal length between units, uniform in +-", {0.0, 50.0}));
    f("centre_spread_px", self.centre_spread_px,
      opt("Differences of the image's centre between units, uniform in +-", {0.0, 50.0}));
  }
  void check(const JsonPlace& place) const {
    if (farthest_m <= nearest_m) place.at("farthest_m").refuse("must be farther than nearest_m");
  }
};

// The virtual OptiTrack.
struct MocapSpec {
  double rate_hz = 100.0;
  double marker_noise_sigma_m = 0.0003;
  double marker_offset_m = 0.04;  // of each of a joint's four markers from the joint; their mean is the joint
  double gap_share = 0.01;        // share of 0.2 s stretches in which a marker is lost
  double clock_error_s =
      0.005;  // uniform in +-, the paper's "less than 5 ms", between the stated and true start

  static void fields(auto& self, auto&& f) {
    f("rate_hz", self.rate_hz, opt("Frames of OptiTrack a second", {1.0, 2000.0}));
    f("marker_noise_sigma_m", self.marker_noise_sigma_m,
      opt("Noise of a marker, one standard deviation an axis", {0.0, 1.0}));
    f("marker_offset_m", self.marker_offset_m,
      opt("Distance of each of a joint's four markers from the joint", {0.0, 1.0}));
    f("gap_share", self.gap_share,
      opt("Share of the stretches of 0.2 s in which a marker is lost", {0.0, 1.0}));
    f("clock_error_s", self.clock_error_s,
      opt("Difference between the stated and the true start, uniform in +-; of a recorded take it alone of "
          "these has an effect",
          {0.0, 10.0}));
  }
};

struct ActivitySpec {
  Activity activity = Activity::walking;
  double duration_s = 35.0;
  std::vector<Joint> marker_joints;  // joints that carry markers

  static void fields(ActivitySpec& self, Fields& f);
};

// A real OptiTrack take to be watched instead of a generated person.
struct RecordedSpec {
  std::filesystem::path mocap;
  std::filesystem::path mapping;
  std::string activity = "recorded";   // what studies call it: their condition
  std::optional<UpAxis> up_axis = {};  // not stated: y

  static void fields(auto& self, auto&& f) {
    f("mocap", self.mocap, need("OptiTrack's export, relative to this file"));
    f("mapping", self.mapping, need("Mapping of its assets to joints"));
    f("activity", self.activity, opt("Name of the condition in studies"));
    visit_up_axis(f, self.up_axis, "Axis of its world that points up; y where it is not stated");
  }
};

// Heights of persons, uniform about their mean.
struct Stature {
  double mean_m = 1.70, half_range_m = 0.17;

  static void fields(auto& self, auto&& f) {
    f("mean", self.mean_m, opt("Mean stature of the persons, in metres", {0.5, 2.5}));
    f("half_range", self.half_range_m, opt("Largest difference from it, uniform to both sides", {0.0, 0.5}));
  }
  void check(const JsonPlace& place) const {
    if (mean_m - half_range_m < 0.5)
      place.at("half_range").refuse("must leave everybody at least 0.5 m tall");
  }
};

// simulation.json, format 1: what `trilat simulate` makes a campaign from.
struct SimulationSpec {
  std::string name = "simulated";
  std::uint64_t seed = 1;
  std::uint64_t participants = 16;
  Stature stature;
  std::vector<ActivitySpec> activities;
  std::optional<RecordedSpec> recorded;
  RigSpec rig;
  SensorSpec sensor;
  BodyTrackerSpec body_tracker = default_body_tracker();
  MocapSpec mocap;
  RoomSpec room;
  DepthSpec depth;
  std::optional<WandSpec> wand;
  std::optional<BenchSpec> bench;

  static void fields(SimulationSpec& self, Fields& f);
  void check(const JsonPlace& place) const;
};
Json simulation_schema();

// Paths are relative to `folder`.
SimulationSpec parse_simulation(const Json& json, const std::string& place,
                                const std::filesystem::path& folder);
// "body_tracker" may name a body_tracker.json here.
SimulationSpec read_simulation(const std::filesystem::path& path);

// The poses of the rig's sensors, named k1, k2, …; they look at the centre.
std::vector<SensorPose> rig_poses(const RigSpec& rig, const Eigen::Vector3d& default_centre_m);

// The calibration with every sensor moved and turned by normal errors of these sizes an axis (rotation
// vectors in world axes); the same for the same seed.
Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed);

// Everything that a simulated campaign assumes of persons, rig, sensors, tracker and mocap, with what each
// value rests on: what a reader of its results has to know.
std::vector<SimulationAssumption> simulation_parameters(const SimulationSpec& spec);

}  // namespace trilat
