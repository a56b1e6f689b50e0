// SPDX-License-Identifier: MIT
#include "pipeline/calibration/calibrate_views.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"
#include "datasets/base/version.h"
#include "evaluators/calibration/rig_start.h"
#include "pipeline/stream_fit/stream_change.h"

namespace trilat {
namespace {

constexpr std::size_t kMinPositions = 3;

RigProblem problem_of(const WandObservations& views, const CalibrateWandOptions& options) {
  RigProblem problem{views.evidence.size(), views.positions.size(), {}};
  const FindWandOptions& find = options.search.find;
  const BallFitOptions fit{
      .radius_m = find.ball_radius_m, .noise = find.noise, .lateral_sigma_m = find.lateral_sigma_m};
  const double uncorrected_m = options.depth_correction ? 0.0 : options.uncorrected_depth_sigma_m;
  for (std::size_t p = 0; p < views.positions.size(); ++p)
    for (const StaticSighting& ball : views.positions[p].seen)
      problem.observations.push_back(
          {ball.sensor, p, ball.centre_in_sensor_m,
           ball.covariance_m2 + uncorrected_m * uncorrected_m * Eigen::Matrix3d::Identity(),
           depth_influence(ball.centre_in_sensor_m, fit)});
  return problem;
}

std::string counts_text(const std::map<std::string, std::uint64_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  return text;
}

// Why a sensor without a single rest has none.
std::string why_nothing_seen(const SensorEvidence& search) {
  const auto count = [&](WandStatus status) {
    const auto entry = search.statuses.find(name_of(status));
    return entry == search.statuses.end() ? std::uint64_t{0} : entry->second;
  };
  const std::string counts = fmt::format(" ({} frames: {})", search.frames, counts_text(search.statuses));
  if (search.doubt) return *search.doubt + "; its ball cannot have the stated radius" + counts;
  if (search.other_radius_m)
    return fmt::format(
        "sees a ball of {:g} m radius, and none of the stated one: state --ball-radius-m {:g}, which is half "
        "the diameter{}",
        *search.other_radius_m, *search.other_radius_m, counts);
  if (count(WandStatus::several_candidates) > search.frames / 4)
    return "sees more than one ball; remove the second, or cover what reflects it" + counts;
  if (count(WandStatus::cut_by_edge) > search.frames / 4)
    return "sees the ball only at the edge of its image" + counts;
  if (count(WandStatus::out_of_range) > search.frames / 4)
    return "sees the ball only out of its range; 0.8 to 3 m is good" + counts;
  if (count(WandStatus::found) > 0)
    return "never sees the ball at rest for half a second; hold it still at every place" + counts;
  return "never sees the ball; is the radius right, and does it stand free in front of the sensor?" + counts;
}

// `saw_alone`: sensors that saw the ball, but only where no other did.
void check_placement(const RigStart& start, const WandObservations& views, const std::vector<bool>& saw_alone,
                     const std::string& place) {
  std::string placed;
  for (std::size_t s = 0; s < start.placement.size(); ++s)
    if (start.placement[s] == SensorPlacement::placed)
      placed += (placed.empty() ? "" : ", ") + views.evidence[s].name;
  const auto no_common_view = [&](const std::string& who) {
    return InputError(place, who + "has fewer than three wand positions in common with " +
                                 (placed.empty() ? "another sensor" : "any of " + placed) +
                                 "; hold the wand where two see it, still at each place");
  };
  const auto named = [&](std::size_t s) { return "sensor \"" + views.evidence[s].name + "\" "; };
  for (std::size_t s = 0; s < start.placement.size(); ++s)
    if (start.placement[s] == SensorPlacement::nothing_seen && !saw_alone[s])
      throw InputError(place, named(s) + why_nothing_seen(views.evidence[s]));
  for (std::size_t s = 0; s < start.placement.size(); ++s) {
    const std::string who = named(s);
    switch (start.placement[s]) {
      case SensorPlacement::placed:
        break;
      case SensorPlacement::nothing_seen:
      case SensorPlacement::no_common_view:
        throw no_common_view(who);
      case SensorPlacement::points_on_line:
        throw InputError(place, who + "is undetermined: the wand positions it has in common with " + placed +
                                    " lie on a line; hold the wand at different heights and to both sides");
      case SensorPlacement::disagrees:
        throw InputError(place, who + "sees the ball where no pose brings it together with " + placed +
                                    "; are the intrinsics this sensor's own, and was the rig left alone?");
    }
  }
}

// Whether the places of two streams are each other's mirror image: laid over each other they agree mirrored,
// and far less as they are.
bool is_mirror_image(const FrameSums& places) {
  constexpr double kMinPlaces = 5.0, kAgree_m = 0.03, kTimes = 3.0;
  if (places.pairs < kMinPlaces) return false;
  const auto rms_m = [&](bool mirrored) {
    return std::sqrt(fit_frame(places, FrameChange::turned, mirrored).squares_m2 / places.pairs);
  };
  return rms_m(true) < kAgree_m && rms_m(false) > std::max(2.0 * kAgree_m, kTimes * rms_m(true));
}

// Positions of the ball in the frames of two sensors, summed over the places that both saw.
FrameSums common_places(const WandObservations& views, std::size_t one, std::size_t other) {
  FrameSums sums;
  for (const WandPosition& position : views.positions) {
    const auto ball_of = [&](std::size_t sensor) {
      return std::ranges::find(position.seen, sensor, &StaticSighting::sensor);
    };
    if (const auto a = ball_of(one), b = ball_of(other); a != position.seen.end() && b != position.seen.end())
      sums.add(a->centre_in_sensor_m, b->centre_in_sensor_m);
  }
  return sums;
}

// Sensors whose depth images are flipped from left to right show the ball's places mirrored: beside the
// export of the ball, else beside most of the other sensors.
void check_mirrors(const WandObservations& views, const CalibrateWandOptions& options,
                   const std::string& place) {
  const std::size_t sensors = views.evidence.size();
  std::vector<std::size_t> mirrored;
  if (options.world) {
    std::vector<FrameSums> sums(sensors);
    for (const ControlPoint& known :
         known_positions(*options.world, std::span(views.positions).first(views.positions_of_first)))
      for (const StaticSighting& ball : views.positions[known.point].seen)
        sums[ball.sensor].add(known.point_in_world_m, ball.centre_in_sensor_m);
    for (std::size_t s = 0; s < sensors; ++s)
      if (is_mirror_image(sums[s])) mirrored.push_back(s);
    if (mirrored.size() == sensors)
      throw InputError(
          options.world->mocap.string(),
          "shows the ball's places as the mirror image of what every sensor sees: the export has "
          "left-handed axes, or all depth images are flipped from left to right");
  } else {
    std::vector<std::size_t> unlike(sensors, 0);  // other sensors
    for (std::size_t a = 0; a < sensors; ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (is_mirror_image(common_places(views, a, b))) ++unlike[a], ++unlike[b];
    for (std::size_t s = 0; s < sensors; ++s)
      if (2 * unlike[s] > sensors - 1) mirrored.push_back(s);
  }
  if (mirrored.empty()) return;
  std::vector<std::string> names;
  for (const std::size_t s : mirrored) names.push_back('"' + views.evidence[s].name + '"');
  const bool is_open = !options.world && 2 * mirrored.size() >= sensors;
  const bool is_one = is_open || mirrored.size() == 1;
  throw InputError(
      place, fmt::format("{} {} {} the ball's places mirrored: {} depth images are flipped from left to "
                         "right; turn every row of them round",
                         is_open  ? "one of the sensors"
                         : is_one ? "sensor"
                                  : "sensors",
                         fmt::join(names, " and "), is_one ? "shows" : "show", is_one ? "its" : "their"));
}

RigGauge gauge_of(const WandObservations& views, const CalibrateWandOptions& options) {
  RigGauge gauge;
  if (options.world)
    gauge.control_points =
        known_positions(*options.world, std::span(views.positions).first(views.positions_of_first));
  else
    gauge.first_points = GaugePoints{{0, 1, 2}, options.baseline_m, options.movement_sigma_m};
  return gauge;
}

void check_refined(const RigRefinement& refined, const WandObservations& views, const std::string& place) {
  if (refined.status == RigStatus::gauge_undetermined)
    throw InputError(place,
                     "does not fix the world: the first three wand positions lie on a line or were not seen "
                     "well; begin with an origin, a second place along x and a third one above");
  if (refined.status == RigStatus::sensor_undetermined)
    for (std::size_t s = 0; s < refined.sensors.size(); ++s)
      if (refined.sensors[s].used < 3)
        throw InputError(
            place,
            "sensor \"" + views.evidence[s].name +
                "\" is undetermined: fewer than three of its wand positions agree with the other sensors'");
  bool stated = true;
  for (const RefinedSensor& sensor : refined.sensors) stated = stated && sensor.covariance.allFinite();
  if (refined.status == RigStatus::converged && !stated)
    throw InputError(place, "does not determine all poses: their covariance cannot be found");
  if (refined.status != RigStatus::converged)
    throw InputError(place, "cannot be calibrated: the refinement ended with " + name_of(refined.status));
}

SensorPose pose_from(const RefinedSensor& refined, const std::string& name) {
  SensorPose pose;
  pose.name = name;
  pose.world_from_sensor = refined.world_from_sensor;
  pose.covariance = refined.covariance;
  pose.rotation_sigma_rad = std::sqrt(refined.covariance.topLeftCorner<3, 3>().trace() / 3.0);
  pose.position_sigma_m = std::sqrt(refined.covariance.bottomRightCorner<3, 3>().trace() / 3.0);
  pose.depth_offset_m = refined.depth_offset_m;
  pose.depth_offset_sigma_m = refined.depth_offset_sigma_m;
  pose.residual_rms_m = refined.rms_m;
  pose.used = refined.used;
  pose.left_out = refined.rejected;
  return pose;
}

// The sightings that were left out, each with its distance from where the others see the ball.
std::vector<RejectedSighting> rejected_of(const RigProblem& problem, const RigRefinement& refined,
                                          const WandObservations& views) {
  std::vector<RejectedSighting> rejected;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (refined.used[i]) continue;
    const PointObservation& o = problem.observations[i];
    const Eigen::Vector3d there_m = refined.sensors[o.sensor].world_from_sensor * o.point_in_sensor_m;
    const Eigen::Vector3d& point_m = refined.point_in_world_m[o.point];
    rejected.push_back({views.evidence[o.sensor].name, o.point + 1,
                        (views.positions[o.point].first - views.positions[0].first).seconds(),
                        point_m.allFinite() ? std::optional((there_m - point_m).norm()) : std::nullopt});
  }
  return rejected;
}

// One sensor that disagrees at many places has other intrinsics than stated or was moved: its pose would be
// wrong without looking so.
void check_agreement(const RigRefinement& refined, const WandObservations& views, const std::string& place) {
  constexpr double kMaxShare = 1.0 / 3.0;
  constexpr double kMaxDepth = 100.0;  // chi squared of 25 exceeds it once in 10^10
  for (std::size_t s = 0; s < refined.sensors.size(); ++s) {
    if (refined.sensors[s].depth_chi2 > kMaxDepth)
      throw InputError(
          place, fmt::format("sensor \"{}\" agrees with the others only if its depth is off by more than a "
                             "sensor's is; are the intrinsics its own, and was the rig left alone?",
                             views.evidence[s].name));
    const std::size_t all = refined.sensors[s].used + refined.sensors[s].rejected;
    if (static_cast<double>(refined.sensors[s].rejected) > kMaxShare * static_cast<double>(all))
      throw InputError(place,
                       fmt::format("sensor \"{}\" disagrees with the others at {} of the {} places where it "
                                   "sees the ball; are the intrinsics its own, and was the rig left alone?",
                                   views.evidence[s].name, refined.sensors[s].rejected, all));
  }
}

void check_stated_movement(const WandObservations& views, const CalibrateWandOptions& options) {
  const std::optional<double> seen_m = seen_movement_m(views);
  if (!seen_m || !options.baseline_m) return;
  if (std::abs(*seen_m - *options.baseline_m) > 0.05 * *seen_m + 3.0 * options.movement_sigma_m)
    throw InputError(
        "--movement-m",
        fmt::format(
            "is {:.3f}, but the sensors saw the ball move by {:.3f} m from its first place to its second",
            *options.baseline_m, *seen_m));
}

}  // namespace

void check_first_places(const WandObservations& views, const std::string& place) {
  constexpr double kMin_m = 0.3;
  const std::optional<double> seen_m = seen_movement_m(views);
  if (seen_m && *seen_m < kMin_m)
    throw InputError(place, fmt::format("has its first two wand places only {:.2f} m apart; they make the x "
                                        "axis and should be a metre apart, {} m at least",
                                        *seen_m, kMin_m));
}

WandCalibration calibrate_views(WandObservations views, const std::string& place,
                                const CalibrateWandOptions& options) {
  const std::vector<bool> saw_before = sensors_that_saw(views);
  drop_unusable_positions(views);
  check_mirrors(views, options, place);
  const RigProblem problem = problem_of(views, options);
  const RigStart start = initial_poses(problem, {});
  check_placement(start, views, saw_before, place);
  if (views.positions.size() < kMinPositions)
    throw InputError(place,
                     fmt::format("shows the wand at rest at {} places; three are the least, fifty are good",
                                 views.positions.size()));
  if (!options.world) {
    check_first_places(views, place);
    check_stated_movement(views, options);
  }
  RigRefinementOptions refinement;
  if (options.depth_correction) refinement.depth_correction = DepthCorrectionOptions{};
  const RigRefinement refined = bundle_adjust(problem, start.reference_from_sensor, start.reference,
                                              gauge_of(views, options), refinement);
  check_refined(refined, views, place);
  check_agreement(refined, views, place);
  WandCalibration result;
  Calibration& calibration = result.calibration;
  calibration.method = "wand";
  calibration.world = options.world ? "optitrack" : "wand";
  calibration.simulated = views.simulated;
  calibration.program = kProgramVersion;
  calibration.positions = views.positions.size();
  if (std::isfinite(refined.reduced_chi2)) calibration.reduced_chi2 = refined.reduced_chi2;
  for (std::size_t s = 0; s < refined.sensors.size(); ++s)
    calibration.sensors.push_back(pose_from(refined.sensors[s], views.evidence[s].name));
  calibration.rejected = rejected_of(problem, refined, views);
  result.position_in_world_m = refined.point_in_world_m;
  result.views = std::move(views);
  return result;
}

}  // namespace trilat
