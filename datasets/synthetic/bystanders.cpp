// SPDX-License-Identifier: MIT
#include "datasets/synthetic/bystanders.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "datasets/base/philox.h"
#include "datasets/synthetic/generated_person.h"

namespace trilat {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::uint64_t kFirstPerson = 1'000'000;  // behind all participants

// A motion about the origin, turned about it and moved along the floor.
Motion placed(Motion motion, double turn_rad, const Eigen::Vector3d& offset_m) {
  return [=](double time_s) {
    SkeletonPose pose = motion(time_s);
    const Eigen::AngleAxisd turn(turn_rad, Eigen::Vector3d::UnitY());
    for (Eigen::Vector3d& joint : pose.joint_in_world_m) joint = turn * joint + offset_m;
    pose.heading_rad += turn_rad;
    return pose;
  };
}

}  // namespace

std::vector<Motion> bystander_motions(std::uint64_t seed, std::uint64_t take, std::uint64_t count,
                                      const Eigen::Vector3d& centre_in_world_m, double stature_mean_m,
                                      double stature_half_range_m) {
  std::vector<Motion> motions;
  double direction_rad = 0.0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const RandomStream random{seed, Purpose::bystander, random_item(take, i, 0, 0)};
    const bool walks = random.uniform(0) < 0.5;
    const double away_m = random.uniform(1, walks ? 1.3 : 0.9, 1.5);
    direction_rad =
        i == 0 ? random.uniform(2, 0.0, kTurn) : direction_rad + random.uniform(2, 0.3, 0.7) * kTurn;
    const Person person =
        draw_person(seed, kFirstPerson + take * kMostBystanders + i, stature_mean_m, stature_half_range_m);
    motions.push_back(placed(generated_motion(person, walks ? Activity::walking : Activity::standing),
                             random.uniform(3, 0.0, kTurn),
                             {centre_in_world_m.x() + away_m * std::sin(direction_rad), 0.0,
                              centre_in_world_m.z() + away_m * std::cos(direction_rad)}));
  }
  return motions;
}

}  // namespace trilat
