// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "datasets/geometry/rigid_transform.h"
#include "evaluators/bodies/exchange_repair.h"
#include "evaluators/bodies/observed_body.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {

// What one instant says about left and right, as logarithms of odds, one entry a sensor; 0 where it says
// nothing.
struct ExchangeEvidence {
  std::array<bool, kMaxSensors> seen{};
  // For the labels as they are and against an exchange: toes, knees and elbows, the way of walking, and that
  // a person whose labels say "seen from behind" is.
  std::array<double, kMaxSensors> labels_right{};
  // That the sensor is in the same state (exchanged or not) as when it last saw the same joints.
  std::array<double, kMaxSensors> as_before{};
  // That two sensors are in the same state; symmetric.
  std::array<std::array<double, kMaxSensors>, kMaxSensors> alike{};
};

// Gives the evidence of the instants of a take, one after the other from the first.
class ExchangeEvidenceSource {
 public:
  // Keeps references to its arguments.
  ExchangeEvidenceSource(const BodyTracks& tracks, std::span<const RigidTransform> world_from_sensor,
                         const ExchangeOptions& options);
  ExchangeEvidence next();

 private:
  static constexpr std::size_t kPairs = 8;
  // Left minus right of every mirrored pair, in the world, with the pair's weight: 0 when an end is missing.
  struct Sides {
    std::array<Eigen::Vector3d, kPairs> left_from_right_m;
    std::array<double, kPairs> weight{};
  };
  struct LastSides {
    Sides sides;
    std::array<std::size_t, kPairs> instant{};
  };

  Sides sides_of(std::size_t sensor) const;
  double as_before(std::size_t sensor, const Sides& now);
  double labels_right(std::size_t sensor, const Sides& now, const Eigen::Vector3d& walking) const;
  Eigen::Vector3d walking_direction() const;

  const BodyTracks& tracks_;
  std::span<const RigidTransform> world_from_sensor_;
  const ExchangeOptions& options_;
  std::size_t instant_ = 0;
  std::vector<LastSides> last_;
};

}  // namespace trilat
