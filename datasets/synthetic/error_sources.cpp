// SPDX-License-Identifier: MIT
#include "datasets/synthetic/error_sources.h"

#include <array>

#include "datasets/base/error.h"
#include "datasets/base/philox.h"

namespace trilat {
namespace {

struct Named {
  ErrorSource source;
  const char* name;
  const char* description;
};

constexpr std::array<Named, 14> kSources{{
    {ErrorSource::none, "none",
     "everything exact; what interpolation between frames that are not taken at one time leaves"},
    {ErrorSource::jitter, "jitter", "the tracker's white noise"},
    {ErrorSource::wander, "wander", "what the tracker's errors change by while a joint moves"},
    {ErrorSource::jumps, "jumps", "the tracker's jumps"},
    {ErrorSource::bias, "bias", "what the tracker systematically puts elsewhere, by joint and viewpoint"},
    {ErrorSource::unit_depth, "depth", "depth that is off by what the sensor's unit is"},
    {ErrorSource::lag, "lag", "the tracker's delay"},
    {ErrorSource::hidden, "hidden", "what the tracker makes of joints that the body hides"},
    {ErrorSource::exchange, "exchange", "the back taken for the front, as far as not put right"},
    {ErrorSource::dropped, "dropped", "frames that are lost"},
    {ErrorSource::clocks, "clocks", "clocks of sensors, their computers and the mocap"},
    {ErrorSource::mocap, "mocap", "noise and gaps of the markers"},
    {ErrorSource::calibration, "calibration", "sensors that are not where the calibration says"},
    {ErrorSource::all, "all", "all of them together"},
}};

const Named& named(ErrorSource source) { return kSources.at(static_cast<std::size_t>(source)); }

void copy_tracker(const BodyTrackerSpec& from, ErrorSource source, BodyTrackerSpec& to) {
  using T = BodyTrackerSpec;
  to.ray_ratio = from.ray_ratio;  // says nothing of the size
  const auto copy = [&](ErrorSource of, auto... settings) {
    if (source == of) ((to.*settings = from.*settings), ...);
  };
  copy(ErrorSource::jitter, &T::jitter_sigma_m);
  copy(ErrorSource::wander, &T::wander_sigma_m, &T::view_wander_sigma_m, &T::own_wander_sigma_m,
       &T::wander_path_m);
  copy(ErrorSource::jumps, &T::jump_rate_per_minute, &T::jump_size_m, &T::jump_duration_s);
  copy(ErrorSource::bias, &T::bias_sigma_m, &T::view_bias_sigma_m, &T::own_bias_sigma_m);
  copy(ErrorSource::unit_depth, &T::unit_depth_share);
  copy(ErrorSource::lag, &T::lag_s);
  copy(ErrorSource::hidden, &T::least_visible_share, &T::inferred_error_sigma_m, &T::hidden_as_tracked_share);
  copy(ErrorSource::exchange, &T::back_view_angle_rad, &T::exchanged_share);
}

}  // namespace

const std::vector<ErrorSource>& error_sources() {
  static const std::vector<ErrorSource> sources = [] {
    std::vector<ErrorSource> all;
    for (const Named& entry : kSources) all.push_back(entry.source);
    return all;
  }();
  return sources;
}

std::string name_of(ErrorSource source) { return named(source).name; }
std::string description_of(ErrorSource source) { return named(source).description; }

SimulationSpec with_only(const SimulationSpec& spec, ErrorSource source) {
  SimulationSpec only = spec;
  // The calibration is the true one; who evaluates the source perturbs it.
  only.rig.position_sigma_m = only.rig.rotation_sigma_rad = 0.0;
  if (source == ErrorSource::all) return only;
  only.body_tracker = exact_body_tracker();
  copy_tracker(spec.body_tracker, source, only.body_tracker);
  if (source != ErrorSource::dropped) only.sensor.dropped_share = 0.0;
  if (source != ErrorSource::clocks) {
    only.sensor.clock_drift_ppm = 0.0;
    only.sensor.arrival_jitter_s = 0.0;
    only.sensor.exchange_jitter_s = 0.0;
    only.mocap.clock_error_s = 0.0;
  }
  if (source != ErrorSource::mocap) {
    only.mocap.marker_noise_sigma_m = 0.0;
    only.mocap.gap_share = 0.0;
  }
  return only;
}

Calibration perturbed(Calibration calibration, double sigma_m, double sigma_rad, std::uint64_t seed) {
  for (std::size_t s = 0; s < calibration.sensors.size(); ++s) {
    const RandomStream random{seed, Purpose::calibration_error, s};
    const Eigen::Vector3d turn =
        sigma_rad * Eigen::Vector3d(random.normal(0), random.normal(1), random.normal(2));
    SensorPose& pose = calibration.sensors[s];
    const double angle = turn.norm();
    if (angle > 0.0)
      pose.world_from_sensor.rotation =
          (Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * pose.world_from_sensor.rotation)
              .normalized();
    pose.world_from_sensor.translation_m +=
        sigma_m * Eigen::Vector3d(random.normal(3), random.normal(4), random.normal(5));
    pose.position_sigma_m = sigma_m;
    pose.rotation_sigma_rad = sigma_rad;
  }
  calibration.method = "simulated truth, perturbed";
  return calibration;
}

}  // namespace trilat
