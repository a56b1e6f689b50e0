// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "pipeline/calibration/calibrate_wand.h"
#include "pipeline/calibration_study/place_samples.h"

namespace trilat {
namespace {

constexpr std::size_t kFolds = 10;
constexpr std::size_t kFirstPlaces = 3;  // which fix the wand's frame, and are never left out

const StaticSighting* seen_by(const WandPosition& position, std::size_t sensor) {
  for (const StaticSighting& ball : position.seen)
    if (ball.sensor == sensor) return &ball;
  return nullptr;
}

// The ball in the world where all sensors but one see it; nothing where no other does.
std::optional<Eigen::Vector3d> seen_by_others(const WandPosition& position, std::size_t sensor,
                                              const std::vector<SensorPose>& poses) {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const StaticSighting& ball : position.seen) {
    if (ball.sensor == sensor) continue;
    sum_m += poses[ball.sensor].world_from_sensor * ball.centre_in_sensor_m;
    count += 1.0;
  }
  if (count == 0.0) return std::nullopt;
  return sum_m / count;
}

// Whether a ball is wholly inside the image and not beyond where depth reaches.
bool is_whole_in_view(const DepthIntrinsics& intrinsics, const Eigen::Vector3d& ball_m, double radius_m) {
  constexpr double kMin_m = 0.2, kMax_m = 8.0;
  if (!(ball_m.z() > radius_m) || ball_m.norm() < kMin_m || ball_m.norm() > kMax_m) return false;
  const std::optional<Eigen::Vector2d> pixel = project(intrinsics, ball_m);
  const double margin_px = intrinsics.fx_px * radius_m / ball_m.z();
  return pixel && pixel->x() > margin_px && pixel->x() < intrinsics.width_px - margin_px &&
         pixel->y() > margin_px && pixel->y() < intrinsics.height_px - margin_px;
}

// The positions of one fold, or all others.
WandObservations part_of(const WandObservations& views, std::size_t fold, bool inside) {
  WandObservations part = views;
  part.positions.clear();
  part.positions_of_first = 0;
  for (std::size_t p = 0; p < views.positions.size(); ++p) {
    const bool is_inside = p >= kFirstPlaces && p % kFolds == fold;
    if (is_inside != inside) continue;
    part.positions.push_back(views.positions[p]);
    part.positions_of_first += p < views.positions_of_first;
  }
  return part;
}

std::vector<WandPlace> left_out_places(const WandObservations& views, const SessionReader& session,
                                       const CalibrateWandOptions& options) {
  std::vector<std::optional<Eigen::Vector3d>> known_m(views.positions.size());
  if (options.world)
    for (const ControlPoint& known : known_positions(*options.world, views.positions))
      known_m[known.point] = known.point_in_world_m;
  std::vector<WandPlace> places;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    options.search.control.check();
    if (part_of(views, fold, true).positions.empty()) continue;
    const std::vector<SensorPose> poses =
        calibrate_views(part_of(views, fold, false), session.path().string(), options).calibration.sensors;
    for (std::size_t p = kFirstPlaces; p < views.positions.size(); ++p) {
      if (p % kFolds != fold) continue;
      for (std::size_t s = 0; s < poses.size(); ++s) {
        const std::optional<Eigen::Vector3d> ball_m =
            options.world ? known_m[p] : seen_by_others(views.positions[p], s, poses);
        if (!ball_m) continue;
        const Eigen::Vector3d in_sensor_m = poses[s].world_from_sensor.inverse() * *ball_m;
        if (!is_whole_in_view(session.header().sensors[s].intrinsics, in_sensor_m,
                              options.search.find.ball_radius_m))
          continue;
        const StaticSighting* rest = seen_by(views.positions[p], s);
        places.push_back({rest ? rest->first : views.positions[p].first,
                          rest ? rest->last : views.positions[p].last, s, p, in_sensor_m.norm(),
                          angle_of(in_sensor_m), in_sensor_m});
      }
    }
  }
  return places;
}

// The poses of one way to calibrate, less those that the campaign states.
void add_poses(const char* name, WandMethod method, const SessionReader& session,
               const WandObservations& views, const CalibrateWandOptions& options, const Calibration& stated,
               WandRecording& recording) {
  WandCalibration made;
  try {
    made = calibrate_searched(method, session, options, views);
  } catch (const InputError& error) {
    recording.poses.push_back({.method = name, .sensor = "", .problem = error.problem()});
    return;
  }
  for (const SensorPose& pose : made.calibration.sensors) {
    const auto truth = std::ranges::find(stated.sensors, pose.name, &SensorPose::name);
    if (truth == stated.sensors.end()) continue;
    const RigidTransform off = pose.world_from_sensor * truth->world_from_sensor.inverse();
    PoseDifference& row = recording.poses.emplace_back(PoseDifference{name, pose.name});
    row.position_m = (pose.world_from_sensor.translation_m - truth->world_from_sensor.translation_m).norm();
    row.rotation_rad = Eigen::AngleAxisd(off.rotation).angle();
    if (!pose.covariance) continue;
    row.position_sigma_m = pose.position_sigma_m;
    row.rotation_sigma_rad = pose.rotation_sigma_rad;
  }
}

}  // namespace

WandRecording measure_wand(const CampaignWand& wand, const std::optional<Calibration>& stated,
                           std::uint64_t frames, const RunControl& control) {
  const SessionReader session(wand.session);
  CalibrateWandOptions options;
  options.search.find.ball_radius_m = wand.ball_radius_m;
  options.search.control = {control.stop_requested, [&](double share) { control.report(0.5 * share); }};
  if (!wand.mocap.empty()) {
    options.world = WandInWorld{wand.mocap, wand.asset, wand.mocap_start_host_ns};
    options.world->track = read_wand_track(wand.mocap, wand.asset);
  }
  WandObservations views = view_wand({&session, 1}, options);
  WandRecording recording;
  recording.truth = options.world ? WandTruth::optitrack : WandTruth::sensors;
  recording.ball_radius_m = wand.ball_radius_m;
  recording.frames = frames;
  calibrate_views(views, session.path().string(), options);  // says what a recording is lacking
  if (stated && options.world && stated->world == "optitrack")
    for (const auto& [name, method] : {std::pair{"wand, refined", WandMethod::wand},
                                       std::pair{"two positions, corrected", WandMethod::two_positions},
                                       std::pair{"two positions as printed", WandMethod::printed}})
      add_poses(name, method, session, views, options, *stated, recording);
  drop_unusable_positions(views);
  if (views.positions.size() <= kFirstPlaces)
    throw InputError(
        wand.session.string(),
        fmt::format("shows the wand at rest at {} places that two sensors see; four are the least, "
                    "so that one can be left out",
                    views.positions.size()));
  measure_places(session, left_out_places(views, session, options), recording,
                 {control.stop_requested, [&](double share) { control.report(0.5 + 0.5 * share); }});
  return recording;
}

}  // namespace trilat
