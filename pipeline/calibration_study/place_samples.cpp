// SPDX-License-Identifier: MIT
#include "pipeline/calibration_study/place_samples.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/session/clock/session_clock.h"
#include "evaluators/calibration/wand_positions.h"
#include "evaluators/wand/find_wand.h"
#include "evaluators/wand/printed_wand.h"
#include "pipeline/study/parallel.h"

namespace trilat {
namespace {

struct WandFinder {
  const char* name;
  bool is_ours = false;
  PrintedWandOptions printed = {};
};

std::vector<WandFinder> make_finders() {
  const PrintedWandOptions printed,
      corrected{Variant::corrected, ThresholdRule::corrected, Variant::corrected, Variant::corrected};
  PrintedWandOptions eq1 = corrected, e1 = corrected, e2 = corrected, e3 = corrected, mid_range = corrected;
  eq1.invalid_pixels = Variant::printed;
  e1.binarisation = ThresholdRule::printed;
  e2.projection = Variant::printed;
  e3.centre = Variant::printed;
  mid_range.binarisation = ThresholdRule::mid_range;
  return {{"as printed", false, printed},
          {"corrected, but eq. 1 as printed", false, eq1},
          {"corrected, but E1 as printed", false, e1},
          {"corrected, but E2 as printed", false, e2},
          {"corrected, but E3 as printed", false, e3},
          {"corrected", false, corrected},
          {"corrected by the mid-range", false, mid_range},
          {"ours", true}};
}

const std::vector<WandFinder>& finders() {
  static const std::vector<WandFinder> all = make_finders();
  return all;
}

// One sensor's depth frames, by the time of their exposure on the host clock.
struct DepthFrames {
  std::vector<HostTime> times;
  DepthRays rays;

  // At most `count` of those within a hold, spread over it.
  std::vector<std::uint64_t> within(const WandPlace& place, std::uint64_t count) const {
    const auto first = std::ranges::lower_bound(times, place.first) - times.begin();
    const auto last = std::ranges::upper_bound(times, place.last) - times.begin();
    const auto all = static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(0, last - first));
    std::vector<std::uint64_t> frames;
    for (std::uint64_t k = 0; k < std::min(count, all); ++k)
      frames.push_back(static_cast<std::uint64_t>(first) + k * all / std::min(count, all));
    return frames;
  }
};

std::vector<DepthFrames> depth_frames(const SessionReader& session) {
  std::vector<DepthFrames> sensors;
  for (std::size_t s = 0; s < session.header().sensors.size(); ++s) {
    DepthFrames& frames = sensors.emplace_back();
    const std::uint64_t count = session.counts(s).depth_frames;
    if (count == 0) continue;
    const SensorClockMap host_from_sensor = fit_sensor_clock(session, s);
    for (const FrameStamp& stamp : session.stamps(s, FrameStream::depth, 0, count))
      frames.times.push_back(host_from_sensor(stamp));
    frames.rays = depth_rays(session.header().sensors[s].intrinsics);
  }
  return sensors;
}

// The mean of the frames in which the ball was found, when it was in at least half of them.
void add_outcome(const std::vector<WandSighting>& sightings, PlaceOutcome& outcome) {
  std::vector<TimedSighting> found;
  WandStatus failure = sightings.empty() ? WandStatus::not_looked : WandStatus::no_wand;
  for (const WandSighting& sighting : sightings)
    if (sighting.status == WandStatus::found)
      found.push_back({HostTime{static_cast<std::int64_t>(found.size())}, sighting});
    else
      failure = sighting.status;
  const bool answered = !found.empty() && 2 * found.size() >= sightings.size();
  outcome.status.push_back(answered ? WandStatus::found : failure);
  outcome.centre_in_sensor_m.push_back(
      answered ? mean_of_rest(found, 0, WandPositionOptions{}.deviation).centre_in_sensor_m
               : Eigen::Vector3d::Constant(kNaN));
}

PlaceOutcome find_at(const SessionReader& session, const DepthFrames& frames, const WandPlace& place,
                     double ball_radius_m, std::uint64_t count) {
  std::vector<std::uint16_t> depth_mm(kDepthPixels);
  std::vector<std::vector<WandSighting>> sightings(finders().size());
  for (const std::uint64_t frame : frames.within(place, count)) {
    session.depth_frame(place.sensor, frame, depth_mm);
    const DepthImageView image{kDepthWidth, kDepthHeight, depth_mm};
    for (std::size_t m = 0; m < sightings.size(); ++m) {
      PrintedWandOptions printed = finders()[m].printed;
      printed.ball_radius_m = ball_radius_m;
      sightings[m].push_back(finders()[m].is_ours
                                 ? find_wand(image, frames.rays, {.ball_radius_m = ball_radius_m})
                                 : find_wand_as_printed(image, frames.rays, printed));
    }
  }
  PlaceOutcome outcome;
  for (const std::vector<WandSighting>& of_method : sightings) add_outcome(of_method, outcome);
  return outcome;
}

// Where no angle is stated, a sample has the angle of the ball that our method found.
void add_samples(const WandPlace& place, const PlaceOutcome& outcome, WandRecording& recording) {
  double angle_rad = place.angle_rad.value_or(kNaN);
  if (const Eigen::Vector3d& found_m = outcome.centre_in_sensor_m.back();
      std::isnan(angle_rad) && found_m.allFinite())
    angle_rad = angle_of(found_m);
  for (std::size_t m = 0; m < outcome.status.size(); ++m) {
    const Eigen::Vector3d& found_m = outcome.centre_in_sensor_m[m];
    WandSample& sample =
        recording.samples.emplace_back(WandSample{m, place.sensor, place.place, place.distance_m, angle_rad});
    sample.distance_error_m = std::abs(found_m.norm() - place.distance_m);
    if (place.ball_in_sensor_m) sample.error_m = (found_m - *place.ball_in_sensor_m).norm();
    ++recording.statuses[m][name_of(outcome.status[m])];
  }
}

}  // namespace

const std::vector<std::string>& wand_method_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const WandFinder& finder : finders()) all.emplace_back(finder.name);
    return all;
  }();
  return names;
}

std::size_t wand_method(const std::string& name) {
  const auto& names = wand_method_names();
  const auto found = std::ranges::find(names, name);
  TRILAT_CHECK(found != names.end(), "a way to find the ball has another name");
  return static_cast<std::size_t>(found - names.begin());
}

double angle_of(const Eigen::Vector3d& point_in_sensor_m) {
  return std::atan2(point_in_sensor_m.head<2>().norm(), point_in_sensor_m.z());
}

std::vector<PlaceOutcome> measure_places(const SessionReader& session, const std::vector<WandPlace>& places,
                                         WandRecording& recording, const RunControl& control) {
  recording.simulated = session.header().simulated;
  for (const SensorDescription& sensor : session.header().sensors) recording.sensors.push_back(sensor.name);
  recording.statuses.resize(finders().size());
  const std::vector<DepthFrames> frames = depth_frames(session);
  std::vector<PlaceOutcome> outcomes(places.size());
  std::atomic<std::size_t> done{0};
  parallel_for_index(places.size(), 1, [&](std::size_t p) {
    control.check();
    outcomes[p] =
        find_at(session, frames[places[p].sensor], places[p], recording.ball_radius_m, recording.frames);
    control.report(static_cast<double>(++done) / static_cast<double>(places.size()));
  });
  for (std::size_t p = 0; p < places.size(); ++p) add_samples(places[p], outcomes[p], recording);
  return outcomes;
}

}  // namespace trilat
