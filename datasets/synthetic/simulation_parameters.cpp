// SPDX-License-Identifier: MIT
#include "datasets/synthetic/simulation_parameters.h"

#include <fmt/format.h>

#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr const char* kPaper = "Yang, Dong, El Saddik, arXiv 2212.14771";
constexpr const char* kAssumption = "assumption: no published figure";
constexpr const char* kCalibrations = "public calibrations of Kinect v2 units";
constexpr const char* kSensor = "Kinect for Windows SDK 2.0 documentation";

std::string text(double value) { return fmt::format("{:g}", value); }
std::string between(double half) { return fmt::format("+-{:g}", half); }

void add_persons(const SimulationSpec& s, std::vector<TrackerParameter>& list) {
  list.push_back({"participants", std::to_string(s.participants), "", kPaper});
  if (s.recorded) {
    list.push_back({"motion", "recorded take", "", s.recorded->mocap.filename().string()});
  } else {
    list.push_back({"stature", text(s.stature_mean_m) + between(s.stature_half_range_m), "m", kPaper});
    list.push_back(
        {"segments", "fractions of the stature", "", "Drillis and Contini 1966, as tabulated by Winter"});
  }
  if (s.bystanders > 0) list.push_back({"bystanders", std::to_string(s.bystanders), "", kAssumption});
}

void add_rig(const RigSpec& rig, std::vector<TrackerParameter>& list) {
  std::string heights;
  for (double height_m : rig.heights_m) heights += (heights.empty() ? "" : ", ") + text(height_m);
  list.push_back({"rig radius", text(rig.radius_m), "m", kPaper});
  list.push_back({"sensor heights", heights, "m", "assumption: the paper does not say"});
  list.push_back({"arc of the rig", text(rig.arc_rad / kRadPerDegree), "degrees", kAssumption});
  list.push_back(
      {"error of the calibration",
       text(rig.position_sigma_m) + " m, " + text(rig.rotation_sigma_rad / kRadPerDegree) + " degrees",
       "sigma an axis", kAssumption});
}

void add_sensor(const SensorSpec& s, std::vector<TrackerParameter>& list) {
  list.push_back({"frame rate", text(s.rate_hz), "Hz", kSensor});
  list.push_back({"range", text(s.nearest_m) + " to " + text(s.farthest_m), "m", kSensor});
  list.push_back({"focal length between units", between(s.focal_spread_px), "px", kCalibrations});
  list.push_back({"image centre between units", between(s.centre_spread_px), "px", kCalibrations});
  list.push_back({"frames lost", text(s.dropped_share), "of frames", kAssumption});
  list.push_back({"clock drift", between(s.free_running ? s.clock_drift_ppm : 0.0), "ppm",
                  "tolerance of common crystal oscillators"});
  list.push_back(
      {"latency", text(s.latency_s), "s", "at least 20 ms by the sensor's makers; stated in the session"});
  list.push_back({"arrival jitter", text(s.arrival_jitter_s), "s, mean of exponential", kAssumption});
  list.push_back({"clock exchanges", "every " + text(s.exchange_period_s), "s", kAssumption});
  list.push_back({"exchange jitter", text(s.exchange_jitter_s), "s, mean of exponential", kAssumption});
}

void add_mocap(const MocapSpec& m, std::vector<TrackerParameter>& list) {
  list.push_back({"mocap rate", text(m.rate_hz), "Hz", "OptiTrack V100:R2 of the paper"});
  list.push_back({"marker noise", text(m.marker_noise_sigma_m), "m, sigma an axis", kAssumption});
  list.push_back({"marker gaps", text(m.gap_share), "of 0.2 s stretches", kAssumption});
  list.push_back({"error of the stated start", between(m.clock_error_s), "s", kPaper});
}

}  // namespace

std::vector<TrackerParameter> simulation_parameters(const SimulationSpec& spec) {
  std::vector<TrackerParameter> list;
  add_persons(spec, list);
  add_rig(spec.rig, list);
  add_sensor(spec.sensor, list);
  for (TrackerParameter& parameter : tracker_parameters(spec.body_tracker))
    list.push_back(std::move(parameter));
  if (!spec.recorded) add_mocap(spec.mocap, list);
  return list;
}

}  // namespace trilat
