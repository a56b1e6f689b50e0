// SPDX-License-Identifier: MIT
#include "evaluators/calibration/wand_positions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/median.h"

namespace trilat {
namespace {

using Sightings = std::span<const TimedSighting>;

Eigen::Vector3d median_centre_m(Sightings sightings) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const TimedSighting& s : sightings) values.push_back(s.sighting.centre_in_sensor_m[axis]);
    median[axis] = upper_median(std::move(values));
  }
  return median;
}

// How many sightings from the first on stay near it without a gap.
std::size_t length_of_rest(Sightings sightings, const WandPositionOptions& options) {
  // The mean of the first few frames stands for the place; one frame alone is noisier.
  constexpr std::size_t kFirst = 5;
  std::size_t end = 1;
  Eigen::Vector3d place_m = sightings[0].sighting.centre_in_sensor_m;
  for (; end < sightings.size(); ++end) {
    if (sightings[end].time - sightings[end - 1].time > options.longest_gap) break;
    const Eigen::Vector3d& centre_m = sightings[end].sighting.centre_in_sensor_m;
    if ((centre_m - place_m).norm() > options.still_radius_m) break;
    if (end < kFirst) place_m += (centre_m - place_m) / static_cast<double>(end + 1);
  }
  return end;
}

Sightings without_ends(Sightings rest, Duration settling) {
  const HostTime from = rest.front().time + settling, to = rest.back().time - settling;
  std::size_t first = 0, last = rest.size();
  while (first < last && rest[first].time < from) ++first;
  while (first < last && to < rest[last - 1].time) --last;
  return rest.subspan(first, last - first);
}

Duration overlap_of(HostTime first_a, HostTime last_a, HostTime first_b, HostTime last_b) {
  return std::min(last_a, last_b) - std::max(first_a, first_b);
}

}  // namespace

StaticSighting mean_of_rest(Sightings rest, std::size_t sensor, double deviation) {
  StaticSighting ball;
  ball.sensor = sensor;
  ball.first = rest.front().time;
  ball.last = rest.back().time;
  const Eigen::Vector3d median_m = median_centre_m(rest);
  std::vector<double> distances_m;
  for (const TimedSighting& s : rest)
    distances_m.push_back((s.sighting.centre_in_sensor_m - median_m).norm());
  // The median length of a normal vector in three dimensions is 1.538 standard deviations.
  const double sigma_m = std::max(upper_median(distances_m) / 1.538, 1e-6);
  Eigen::Matrix3d stated_m2 = Eigen::Matrix3d::Zero(), scatter_m2 = Eigen::Matrix3d::Zero();
  std::vector<const TimedSighting*> used;
  for (std::size_t i = 0; i < rest.size(); ++i)
    if (distances_m[i] <= deviation * sigma_m) used.push_back(&rest[i]);
  for (const TimedSighting* s : used) {
    ball.centre_in_sensor_m += s->sighting.centre_in_sensor_m / static_cast<double>(used.size());
    stated_m2 += s->sighting.covariance_m2 / static_cast<double>(used.size());
  }
  for (const TimedSighting* s : used) {
    const Eigen::Vector3d off_m = s->sighting.centre_in_sensor_m - ball.centre_in_sensor_m;
    scatter_m2 += off_m * off_m.transpose() / static_cast<double>(std::max<std::size_t>(1, used.size() - 1));
  }
  // When frames scatter more than each says of itself, they are believed.
  const double scale = used.size() > 2 ? std::max(1.0, scatter_m2.trace() / stated_m2.trace()) : 1.0;
  ball.covariance_m2 = scale * stated_m2 / static_cast<double>(used.size());
  ball.frames_used = used.size();
  ball.frames_left_out = rest.size() - used.size();
  return ball;
}

std::vector<StaticSighting> find_static_intervals(Sightings sightings, std::size_t sensor,
                                                  const WandPositionOptions& options) {
  std::vector<StaticSighting> rests;
  for (std::size_t first = 0; first < sightings.size();) {
    const std::size_t length = length_of_rest(sightings.subspan(first), options);
    const Sightings rest = sightings.subspan(first, length);
    if (rest.back().time - rest.front().time < options.shortest_rest) {
      ++first;
      continue;
    }
    const Sightings quiet = without_ends(rest, options.settling);
    if (!quiet.empty()) rests.push_back(mean_of_rest(quiet, sensor, options.deviation));
    first += length;
  }
  return rests;
}

std::vector<WandPosition> find_wand_positions(std::vector<StaticSighting> rests,
                                              const WandPositionOptions& options) {
  std::ranges::stable_sort(
      rests, [](const StaticSighting& a, const StaticSighting& b) { return a.first < b.first; });
  std::vector<WandPosition> positions;
  for (const StaticSighting& rest : rests) {
    WandPosition* same = nullptr;
    for (WandPosition& position : positions)
      if (overlap_of(position.first, position.last, rest.first, rest.last) >= options.least_overlap)
        same = &position;
    const bool again = same && std::ranges::any_of(same->seen, [&](const StaticSighting& other) {
                         return other.sensor == rest.sensor;
                       });
    if (again) continue;  // a second rest of one sensor inside another's: the ball was hidden in between
    if (!same) same = &positions.emplace_back(WandPosition{rest.first, rest.last, {}});
    same->first = std::min(same->first, rest.first);
    same->last = std::max(same->last, rest.last);
    same->seen.push_back(rest);
  }
  return positions;
}

namespace {

constexpr double kMinMovement_m = 1e-3;

// Rows: the client's axes in the sensor's frame; the second is the one that eq. 6 compares, the third the
// turn's.
Eigen::Matrix3d client_from_sensor(const TwoPositionOptions& options) {
  Eigen::Matrix3d axes;
  if (options.trajectory_axis == TrajectoryAxis::y) {
    axes << -1, 0, 0, 0, -1, 0, 0, 0, 1;  // half a turn: no frame that is turned only may be left-handed
    return axes;
  }
  const Eigen::Vector3d up = options.up_in_sensor.normalized();
  const Eigen::Vector3d forward = (Eigen::Vector3d::UnitZ() - up.z() * up).normalized();
  const Eigen::Vector3d right = forward.cross(up);
  const bool along_x = options.trajectory_axis == TrajectoryAxis::x;
  axes.row(0) = (along_x ? -forward : right).transpose();
  axes.row(1) = (along_x ? right : forward).transpose();
  axes.row(2) = up.transpose();
  return axes;
}

// The server's frame has y along the movement and z up; the wand's has x along it and y up.
Eigen::Matrix3d wand_from_server() {
  Eigen::Matrix3d axes;
  axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  return axes;
}

}  // namespace

std::string name_of(TwoPositionStatus status) {
  constexpr std::array<const char*, 4> kNames{"not_solved", "solved", "cosine_beyond_one", "no_movement"};
  return kNames.at(static_cast<std::size_t>(status));
}

TwoPositionPose solve_two_positions(const Eigen::Vector3d& first_in_sensor_m,
                                    const Eigen::Vector3d& second_in_sensor_m, double baseline_m,
                                    const TwoPositionOptions& options) {
  TwoPositionPose result;
  const Eigen::Matrix3d client = client_from_sensor(options);
  const Eigen::Vector3d first_m = client * first_in_sensor_m;
  const Eigen::Vector3d moved_m = client * second_in_sensor_m - first_m;
  result.status = TwoPositionStatus::no_movement;
  if (!(baseline_m > kMinMovement_m) || !(moved_m.head<2>().norm() > kMinMovement_m)) return result;
  double angle_rad = 0.0;
  if (options.signed_angle) {
    angle_rad = std::atan2(moved_m.x(), moved_m.y());
  } else {
    const double cosine = moved_m.y() / baseline_m;
    result.status = TwoPositionStatus::cosine_beyond_one;
    if (!(std::abs(cosine) <= 1.0)) return result;
    angle_rad = std::acos(cosine);
  }
  const Eigen::Matrix3d server_from_sensor =
      Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() * client;
  const Eigen::Matrix3d rotation = wand_from_server() * server_from_sensor;
  result.wand_from_sensor.rotation = Eigen::Quaterniond(rotation).normalized();
  if (options.translation) result.wand_from_sensor.translation_m = -(rotation * first_in_sensor_m);
  result.status = TwoPositionStatus::solved;
  return result;
}

}  // namespace trilat
