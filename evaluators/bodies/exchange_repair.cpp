// SPDX-License-Identifier: MIT
#include "evaluators/bodies/exchange_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "datasets/base/error.h"
#include "datasets/rig/rigid_transform.h"
#include "evaluators/bodies/observed_body.h"
#include "evaluators/solvers/range_problem.h"

namespace trilat {
namespace {

// Evidence of one instant about left and right, as logarithms of odds, one entry a sensor; 0 where it says
// nothing.
struct ExchangeEvidence {
  std::array<bool, kMaxSensors> seen{};
  // For the labels as they are and against an exchange: toes, knees and elbows.
  std::array<double, kMaxSensors> log_odds_unswapped{};
  // Log odds that the sensor is in the same state (exchanged or not) as when it last saw the same joints.
  std::array<double, kMaxSensors> log_odds_unchanged{};
  // Log odds that two sensors are in the same state; symmetric.
  std::array<std::array<double, kMaxSensors>, kMaxSensors> log_odds_same_state{};
};

using Eigen::Vector3d;
using enum Joint;

// The left joint of each pair that is compared; thumbs and hand tips are too noisy. The trunk's come first.
constexpr std::array<Joint, 8> kLeft{shoulder_left, hip_left,  elbow_left, wrist_left,
                                     hand_left,     knee_left, ankle_left, foot_left};
constexpr std::size_t kTrunkPairs = 2;

// Sizes in metres. Errors of two sensors differ by centimetres, those of one sensor hardly change in a frame.
constexpr double kAlikeScale_m2 = 0.1 * 0.1, kAlikeMost = 1.5;
constexpr double kBeforeScale_m2 = 0.05 * 0.05, kBeforeMost = 10.0;
constexpr double kInferredWeight = 0.15;
constexpr double kMaxMemory_s = 0.5;

// How far toes, knees and hands lie before the part they belong to, and elbows behind it: typical length and
// error, in which the movement of the hands is included.
struct Shape {
  double typical_m;
  double error_m;
};
constexpr Shape kToes{0.15, 0.10}, kKnee{0.05, 0.10}, kElbow{0.06, 0.10}, kHands{0.08, 0.15};
constexpr double kShapeMost = 8.0;

double weight_of(const ObservedBody& body, Joint joint) {
  switch (body.state[static_cast<std::size_t>(joint)]) {
    case TrackingState::tracked:
      return 1.0;
    case TrackingState::inferred:
      return kInferredWeight;
    case TrackingState::not_tracked:
      break;
  }
  return 0.0;
}

double clamped(double value, double most) { return std::clamp(value, -most, most); }

Vector3d level(const Vector3d& direction) { return {direction.x(), 0.0, direction.z()}; }

// How far `middle` lies before the straight line between two others, in the sensor's frame.
Vector3d bend_m(const ObservedBody& body, Joint upper, Joint middle, Joint lower) {
  return body.at(middle) - 0.5 * (body.at(upper) + body.at(lower));
}

struct Point {
  Vector3d place_m = Vector3d::Zero();
  double weight = 0.0;
};

// Mean of the joints that are there, in the sensor's frame; weight 1 when all are tracked.
Point mean_of(const ObservedBody& body, const std::array<Joint, 4>& joints) {
  Point mean;
  for (const Joint joint : joints) {
    const double weight = weight_of(body, joint);
    mean.place_m += weight * body.at(joint);
    mean.weight += weight;
  }
  if (mean.weight > 0.0) mean.place_m /= mean.weight;
  mean.weight /= static_cast<double>(joints.size());
  return mean;
}

// The direction in which the body's shape says that it looks, in the sensor's frame: a sum of vectors whose
// product with the true forward is the logarithm of the odds of that forward against its opposite. Left and
// right legs and arms are treated alike, so that an exchange changes nothing.
Vector3d forward_of_shape(const ObservedBody& body) {
  Vector3d sum = Vector3d::Zero();
  const auto add = [&](const Shape& shape, double sign, double weight, const Vector3d& offset_m) {
    if (weight > 0.0)
      sum += sign * weight * 2.0 * shape.typical_m / (shape.error_m * shape.error_m) * offset_m;
  };
  for (const bool mirrored : {false, true}) {
    const auto side = [&](Joint joint) { return mirrored ? mirror_of(joint) : joint; };
    const auto weight = [&](Joint joint) { return weight_of(body, side(joint)); };
    add(kToes, 1.0, weight(ankle_left) * weight(foot_left),
        body.at(side(foot_left)) - body.at(side(ankle_left)));
    add(kKnee, 1.0, weight(hip_left) * weight(knee_left) * weight(ankle_left),
        bend_m(body, side(hip_left), side(knee_left), side(ankle_left)));
    add(kElbow, -1.0, weight(shoulder_left) * weight(elbow_left) * weight(wrist_left),
        bend_m(body, side(shoulder_left), side(elbow_left), side(wrist_left)));
    const Point hand =
        mean_of(body, {side(wrist_left), side(hand_left), side(hand_tip_left), side(thumb_left)});
    add(kHands, 1.0, weight(shoulder_left) * weight(elbow_left) * hand.weight,
        hand.place_m - 0.5 * (body.at(side(shoulder_left)) + body.at(side(elbow_left))));
  }
  return sum;
}

std::size_t instants_in(double time_s, const ExchangeOptions& options) {
  return static_cast<std::size_t>(std::max(1.0, std::round(time_s / options.instant_s)));
}

// Gives the evidence of the instants of a take, one after the other from the first.
class ExchangeEvidenceSource {
 public:
  // Keeps references to its arguments.
  ExchangeEvidenceSource(const BodyTracks& tracks, std::span<const RigidTransform> world_from_sensor,
                         const ExchangeOptions& options)
      : tracks_(tracks), world_from_sensor_(world_from_sensor), options_(options), last_(tracks.sensors()) {}

  ExchangeEvidence next() {
    ExchangeEvidence evidence;
    std::array<Sides, kMaxSensors> sides;
    for (std::size_t a = 0; a < tracks_.sensors(); ++a) {
      const ObservedBody& body = tracks_.at(instant_, a);
      evidence.seen[a] = std::ranges::any_of(
          body.state, [](TrackingState state) { return state != TrackingState::not_tracked; });
      if (!evidence.seen[a]) continue;
      sides[a] = sides_of(a);
      evidence.log_odds_unswapped[a] = log_odds_unswapped(a, sides[a]);
      evidence.log_odds_unchanged[a] = log_odds_unchanged(a, sides[a]);
      for (std::size_t b = 0; b < a; ++b) {
        double sum = 0.0;
        for (std::size_t p = 0; p < kPairs; ++p)
          if (const double weight = sides[a].weight[p] * sides[b].weight[p]; weight > 0.0)
            sum += clamped(
                weight / kAlikeScale_m2 * sides[a].left_from_right_m[p].dot(sides[b].left_from_right_m[p]),
                kAlikeMost);
        evidence.log_odds_same_state[a][b] = evidence.log_odds_same_state[b][a] = sum;
      }
    }
    ++instant_;
    return evidence;
  }

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

  Sides sides_of(std::size_t sensor) const {
    const ObservedBody& body = tracks_.at(instant_, sensor);
    const Eigen::Matrix3d rotation = world_from_sensor_[sensor].rotation.toRotationMatrix();
    Sides sides;
    for (std::size_t p = 0; p < kPairs; ++p) {
      sides.weight[p] = weight_of(body, kLeft[p]) * weight_of(body, mirror_of(kLeft[p]));
      if (sides.weight[p] > 0.0)
        sides.left_from_right_m[p] = rotation * (body.at(kLeft[p]) - body.at(mirror_of(kLeft[p])));
    }
    return sides;
  }

  double log_odds_unchanged(std::size_t sensor, const Sides& now) {
    LastSides& last = last_[sensor];
    const std::size_t longest = instants_in(kMaxMemory_s, options_);
    double sum = 0.0;
    for (std::size_t p = 0; p < kPairs; ++p) {
      if (now.weight[p] == 0.0) continue;
      const std::size_t age = instant_ - last.instant[p];
      if (const double weight = now.weight[p] * last.sides.weight[p]; weight > 0.0 && age <= longest)
        sum +=
            clamped(weight / kBeforeScale_m2 * now.left_from_right_m[p].dot(last.sides.left_from_right_m[p]),
                    kBeforeMost) /
            static_cast<double>(age);
      last.sides.left_from_right_m[p] = now.left_from_right_m[p];
      last.sides.weight[p] = now.weight[p];
      last.instant[p] = instant_;
    }
    return sum;
  }

  double log_odds_unswapped(std::size_t sensor, const Sides& now) const {
    Vector3d left_m = Vector3d::Zero();
    double weight = 0.0;
    for (std::size_t p = 0; p < kTrunkPairs; ++p) {
      if (now.weight[p] == 0.0) continue;
      left_m += now.weight[p] * now.left_from_right_m[p];
      weight += now.weight[p];
    }
    const Vector3d forward_m = level(left_m.cross(Vector3d::UnitY()));
    constexpr double kNarrowest_m = 0.08;
    if (weight == 0.0 || forward_m.norm() < kNarrowest_m * weight) return 0.0;
    const Vector3d forward = forward_m.normalized();

    const ObservedBody& body = tracks_.at(instant_, sensor);
    const Eigen::Quaterniond& rotation = world_from_sensor_[sensor].rotation;
    const double sum = clamped(forward.dot(level(rotation * forward_of_shape(body))), kShapeMost);
    return sum * options_.instant_s / options_.evidence_time_s;
  }

  const BodyTracks& tracks_;
  std::span<const RigidTransform> world_from_sensor_;
  const ExchangeOptions& options_;
  std::size_t instant_ = 0;
  std::vector<LastSides> last_;
};

// A state is a set of exchanged sensors, one bit a sensor.
constexpr std::size_t kMaxStates = std::size_t{1} << kMaxSensors;
using RobustLoss = std::array<double, kMaxStates>;
using Origins = std::array<std::uint8_t, kMaxStates>;

// Cost of each state by the evidence of one instant, up to a constant.
void costs_of(const ExchangeEvidence& evidence, std::size_t sensors, double prior_log_odds,
              RobustLoss& costs) {
  costs[0] = 0.0;
  for (std::size_t b = 0; b < sensors; ++b) {
    const std::size_t bit = std::size_t{1} << b;
    const double alone = evidence.seen[b] ? evidence.log_odds_unswapped[b] + prior_log_odds : 0.0;
    for (std::size_t state = 0; state < bit; ++state) {
      double cost = costs[state] + alone;
      for (std::size_t c = 0; c < sensors; ++c)
        cost += (state >> c & 1u) ? -evidence.log_odds_same_state[b][c] : evidence.log_odds_same_state[b][c];
      costs[state | bit] = cost;
    }
  }
}

// The least cost of coming to each state when every sensor may begin or end to exchange, and where from.
void step(const ExchangeEvidence& evidence, std::size_t sensors, double switching_cost, RobustLoss& total,
          Origins& origin) {
  const std::size_t states = std::size_t{1} << sensors;
  for (std::size_t state = 0; state < states; ++state) origin[state] = static_cast<std::uint8_t>(state);
  for (std::size_t b = 0; b < sensors; ++b) {
    if (!evidence.seen[b]) continue;  // what happens meanwhile is weighed when the sensor sees again
    const double stay = std::max(-evidence.log_odds_unchanged[b], 0.0);
    const double change = std::max(evidence.log_odds_unchanged[b], 0.0) + switching_cost;
    const std::size_t bit = std::size_t{1} << b;
    for (std::size_t low = 0; low < states; ++low) {
      if (low & bit) continue;
      const std::size_t high = low | bit;
      const double at_low = total[low], at_high = total[high];
      const std::uint8_t from_low = origin[low], from_high = origin[high];
      const bool to_low = at_high + change < at_low + stay, to_high = at_low + change < at_high + stay;
      total[low] = to_low ? at_high + change : at_low + stay;
      total[high] = to_high ? at_low + change : at_high + stay;
      if (to_low) origin[low] = from_high;
      if (to_high) origin[high] = from_low;
    }
  }
}

bool has_any(const ObservedBody& body) {
  return std::ranges::any_of(body.state,
                             [](TrackingState state) { return state != TrackingState::not_tracked; });
}

// Log odds of this sequence against its opposite, in which each sensor is exchanged where it is not here:
// sensors that agree with each other and with themselves do so in both.
double total_log_odds(const SideSwapRepair& repair, std::span<const double> log_odds_unswapped) {
  double certainty = 0.0;
  for (std::size_t i = 0; i < log_odds_unswapped.size(); ++i)
    certainty += repair.sides_swapped[i] ? -log_odds_unswapped[i] : log_odds_unswapped[i];
  return certainty;
}

void count_stretches(const BodyTracks& tracks, SideSwapRepair& repair) {
  repair.stretches.assign(repair.sensors, 0);
  for (std::size_t a = 0; a < repair.sensors; ++a) {
    bool before = false;
    for (std::size_t i = 0; i < tracks.instants(); ++i) {
      if (!has_any(tracks.at(i, a))) continue;
      repair.stretches[a] += repair.at(i, a) && !before;
      before = repair.at(i, a);
    }
  }
}

}  // namespace

SideSwapRepair find_exchanges(const BodyTracks& tracks, std::span<const RigidTransform> world_from_sensor,
                              const ExchangeOptions& options) {
  const std::size_t sensors = tracks.sensors(), instants = tracks.instants();
  TRILAT_CHECK(world_from_sensor.size() == sensors && sensors <= kMaxSensors,
               "every sensor has one pose and the rig is within the capacity");
  SideSwapRepair repair{sensors, std::vector<std::uint8_t>(instants * sensors, 0), {}};
  const std::size_t states = std::size_t{1} << sensors;
  const double prior_log_odds = sensors == 1 ? options.prior_log_odds_alone : options.prior_log_odds;
  ExchangeEvidenceSource source(tracks, world_from_sensor, options);
  std::vector<std::uint8_t> origins(instants * states);
  std::vector<double> log_odds_unswapped;  // instants x sensors
  RobustLoss total{}, costs;
  Origins origin;
  for (std::size_t i = 0; i < instants; ++i) {
    const ExchangeEvidence evidence = source.next();
    step(evidence, sensors, i == 0 ? 0.0 : options.switching_cost, total, origin);
    std::copy_n(origin.begin(), states, origins.begin() + static_cast<std::ptrdiff_t>(i * states));
    log_odds_unswapped.insert(log_odds_unswapped.end(), evidence.log_odds_unswapped.begin(),
                              evidence.log_odds_unswapped.begin() + static_cast<std::ptrdiff_t>(sensors));
    costs_of(evidence, sensors, prior_log_odds, costs);
    for (std::size_t state = 0; state < states; ++state) total[state] += costs[state];
  }
  const auto end = total.begin() + static_cast<std::ptrdiff_t>(states);
  auto state = static_cast<std::size_t>(std::min_element(total.begin(), end) - total.begin());
  for (std::size_t i = instants; i-- > 0; state = origins[i * states + state])
    for (std::size_t a = 0; a < sensors; ++a)
      repair.sides_swapped[i * sensors + a] = (state >> a & 1u) && has_any(tracks.at(i, a));
  if (total_log_odds(repair, log_odds_unswapped) < options.min_log_odds)
    std::ranges::fill(repair.sides_swapped, std::uint8_t{0});
  count_stretches(tracks, repair);
  return repair;
}

void undo_exchanges(BodyTracks& tracks, const SideSwapRepair& repair) {
  TRILAT_CHECK(repair.sensors == tracks.sensors() &&
                   repair.sides_swapped.size() == tracks.instants() * tracks.sensors(),
               "the repair belongs to these tracks");
  for (std::size_t i = 0; i < tracks.instants(); ++i) {
    for (std::size_t a = 0; a < tracks.sensors(); ++a) {
      if (!repair.at(i, a)) continue;
      ObservedBody& body = tracks.at(i, a);
      for (std::size_t j = 0; j < kJointCount; ++j) {
        const auto mirror = static_cast<std::size_t>(mirror_of(static_cast<Joint>(j)));
        if (mirror <= j) continue;
        std::swap(body.joint_in_sensor_m[j], body.joint_in_sensor_m[mirror]);
        std::swap(body.state[j], body.state[mirror]);
      }
    }
  }
}

}  // namespace trilat
