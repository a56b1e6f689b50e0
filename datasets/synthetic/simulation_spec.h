// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "datasets/calibration/calibration.h"
#include "datasets/geometry/depth_camera.h"
#include "datasets/synthetic/depth/depth_spec.h"
#include "datasets/synthetic/generated_person.h"
#include "datasets/synthetic/tracker/body_tracker_spec.h"
#include "datasets/take/campaign.h"

namespace trilat {

// Where the virtual sensors stand: on a circle about `centre_m` (its y is the height they look at), at one
// height each. Different heights make the vertical observable from ranges; see docs/reference/methods.md on
// rigs of one height.
struct RigSpec {
  double radius_m = 2.0;
  std::vector<double> heights_m{0.6, 2.2, 0.9, 1.9};
  double arc_rad =
      2.0 * std::numbers::pi;  // of the circle; each sensor has an equal part, and stands in its middle
  double arc_start_rad = 0.0;  // from +z towards +x: where the arc begins
  // Errors of the calibration, an axis: sensors stand elsewhere, and turned otherwise, than it says.
  double position_sigma_m = 0.0, rotation_sigma_rad = 0.0;
  std::optional<Eigen::Vector3d> centre_m = {};  // default: (0, 1, 0), or the middle of a real take's assets
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
};

// The virtual OptiTrack.
struct MocapSpec {
  double rate_hz = 100.0;
  double marker_noise_sigma_m = 0.0003;
  double marker_offset_m = 0.04;  // of each of a joint's four markers from the joint; their mean is the joint
  double gap_share = 0.01;        // share of 0.2 s stretches in which a marker is lost
  double clock_error_s =
      0.005;  // uniform in +-, the paper's "less than 5 ms", between the stated and true start
};

struct ActivitySpec {
  Activity activity = Activity::walking;
  double duration_s = 35.0;
  std::vector<Joint> marker_joints;  // joints that carry markers
};

// A real OptiTrack take to be watched instead of a generated person.
struct RecordedSpec {
  std::filesystem::path mocap;
  std::filesystem::path mapping;
  std::string activity = "recorded";   // what studies call it: their condition
  std::optional<UpAxis> up_axis = {};  // not stated: y
};

// simulation.json, format 1: what `trilat simulate` makes a campaign from.
struct SimulationSpec {
  std::string name = "simulated";
  std::uint64_t seed = 1;
  std::uint64_t participants = 16;
  double stature_mean_m = 1.70;
  double stature_half_range_m = 0.17;
  std::vector<ActivitySpec> activities;
  std::optional<RecordedSpec> recorded;
  RigSpec rig;
  SensorSpec sensor;
  BodyTrackerSpec body_tracker = default_body_tracker();
  std::filesystem::path body_tracker_file = {};  // where that was read from; empty: from simulation.json
  MocapSpec mocap;
  RoomSpec room;
  DepthSpec depth;
  std::optional<WandSpec> wand;
  std::optional<BenchSpec> bench;
};

// Paths are relative to `folder`.
SimulationSpec parse_simulation(const Json& json, const std::string& place,
                                const std::filesystem::path& folder);
// "body_tracker" may name a body_tracker.json here.
SimulationSpec read_simulation(const std::filesystem::path& path);

// The poses of the rig's sensors, named k1, k2, …; they look at the centre.
std::vector<SensorPose> rig_poses(const RigSpec& rig, const Eigen::Vector3d& default_centre_m);

// Everything that a simulated campaign assumes of persons, rig, sensors, tracker and mocap, with what each
// value rests on: what a reader of its results has to know.
std::vector<DeclaredParameter> simulation_parameters(const SimulationSpec& spec);

}  // namespace trilat
