// SPDX-License-Identifier: MIT
#include "evaluators/bodies/exchange_evidence.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trilat {
namespace {

using Eigen::Vector3d;
using enum Joint;

// The left joint of each pair that is compared; thumbs and hand tips are too noisy. The trunk's come first.
constexpr std::array<Joint, 8> kLeft{shoulder_left, hip_left,  elbow_left, wrist_left,
                                     hand_left,     knee_left, ankle_left, foot_left};
constexpr std::size_t kTrunkPairs = 2;
constexpr std::array<Joint, 5> kMiddle{spine_base, spine_mid, spine_shoulder, neck, head};

// Sizes in metres. Errors of two sensors differ by centimetres, those of one sensor hardly change in a frame.
constexpr double kAlikeScale_m2 = 0.1 * 0.1, kAlikeMost = 1.5;
constexpr double kBeforeScale_m2 = 0.05 * 0.05, kBeforeMost = 10.0;
constexpr double kInferredWeight = 0.15;
constexpr double kLongestMemory_s = 0.5;

// How far toes, knees and hands lie before the part they belong to, and elbows behind it: typical length and
// error, in which the movement of the hands is included.
struct Shape {
  double typical_m;
  double error_m;
};
constexpr Shape kToes{0.15, 0.10}, kKnee{0.05, 0.10}, kElbow{0.06, 0.10}, kHands{0.08, 0.15};
constexpr double kShapeMost = 8.0;

constexpr double kNoWalk_m_s = 0.2, kWalk_m_s = 0.4, kWalkWeight = 8.0, kWalkHalfWindow_s = 0.25;
// Cosine between the front by the labels and the direction to the sensor: from the first one down the labels
// begin to say "seen from behind", below the second they surely do.
constexpr double kMaybeBehind = -0.25, kSurelyBehind = -0.6, kBehindWeight = 24.0;

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

// 0 from `none` on, 1 from `full` on, whichever of the two is larger.
double ramp(double value, double none, double full) {
  return std::clamp((value - none) / (full - none), 0.0, 1.0);
}

Vector3d level(const Vector3d& direction) { return {direction.x(), 0.0, direction.z()}; }

// How far `middle` lies before the straight line between two others, in the sensor's frame.
Vector3d bend_m(const ObservedBody& body, Joint upper, Joint middle, Joint lower) {
  return body.at(middle) - 0.5 * (body.at(upper) + body.at(lower));
}

struct Point {
  Vector3d place_m = Vector3d::Zero();
  double weight = 0.0;
};

// Of those joints that are there, in the sensor's frame; weight 1 when all are tracked.
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

}  // namespace

ExchangeEvidenceSource::ExchangeEvidenceSource(const BodyTracks& tracks,
                                               std::span<const RigidTransform> world_from_sensor,
                                               const ExchangeOptions& options)
    : tracks_(tracks), world_from_sensor_(world_from_sensor), options_(options), last_(tracks.sensors()) {}

ExchangeEvidence ExchangeEvidenceSource::next() {
  ExchangeEvidence evidence;
  std::array<Sides, kMaxSensors> sides;
  const Vector3d walking = walking_direction();
  for (std::size_t a = 0; a < tracks_.sensors(); ++a) {
    const ObservedBody& body = tracks_.at(instant_, a);
    evidence.seen[a] = std::any_of(body.state.begin(), body.state.end(),
                                   [](TrackingState state) { return state != TrackingState::not_tracked; });
    if (!evidence.seen[a]) continue;
    sides[a] = sides_of(a);
    evidence.labels_right[a] = labels_right(a, sides[a], walking);
    evidence.as_before[a] = as_before(a, sides[a]);
    for (std::size_t b = 0; b < a; ++b) {
      double sum = 0.0;
      for (std::size_t p = 0; p < kPairs; ++p)
        if (const double weight = sides[a].weight[p] * sides[b].weight[p]; weight > 0.0)
          sum += clamped(
              weight / kAlikeScale_m2 * sides[a].left_from_right_m[p].dot(sides[b].left_from_right_m[p]),
              kAlikeMost);
      evidence.alike[a][b] = evidence.alike[b][a] = sum;
    }
  }
  ++instant_;
  return evidence;
}

ExchangeEvidenceSource::Sides ExchangeEvidenceSource::sides_of(std::size_t sensor) const {
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

double ExchangeEvidenceSource::as_before(std::size_t sensor, const Sides& now) {
  LastSides& last = last_[sensor];
  const std::size_t longest = instants_in(kLongestMemory_s, options_);
  double sum = 0.0;
  for (std::size_t p = 0; p < kPairs; ++p) {
    if (now.weight[p] == 0.0) continue;
    const std::size_t age = instant_ - last.instant[p];
    if (const double weight = now.weight[p] * last.sides.weight[p]; weight > 0.0 && age <= longest)
      sum += clamped(weight / kBeforeScale_m2 * now.left_from_right_m[p].dot(last.sides.left_from_right_m[p]),
                     kBeforeMost) /
             static_cast<double>(age);
    last.sides.left_from_right_m[p] = now.left_from_right_m[p];
    last.sides.weight[p] = now.weight[p];
    last.instant[p] = instant_;
  }
  return sum;
}

double ExchangeEvidenceSource::labels_right(std::size_t sensor, const Sides& now,
                                            const Vector3d& walking) const {
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
  double sum = clamped(forward.dot(level(rotation * forward_of_shape(body))), kShapeMost);
  sum += kWalkWeight * forward.dot(walking);

  const bool has_shoulders = now.weight[0] > 0.0;
  const Joint left = has_shoulders ? shoulder_left : hip_left;
  const Vector3d to_sensor = -level(rotation * (body.at(left) + body.at(mirror_of(left))));
  if (to_sensor.norm() > 0.0)
    sum += std::min(weight, 1.0) * kBehindWeight *
           ramp(-forward.dot(to_sensor.normalized()), -kMaybeBehind, -kSurelyBehind);
  return sum * options_.instant_s / options_.evidence_time_s;
}

// Level, in the world; its length rises from 0 to 1 with the speed of the spine's and the head's joints.
Vector3d ExchangeEvidenceSource::walking_direction() const {
  const std::size_t half = instants_in(kWalkHalfWindow_s, options_);
  const std::size_t first = instant_ - std::min(instant_, half);
  const std::size_t last = std::min(instant_ + half, tracks_.instants() - 1);
  if (last - first < half) return Vector3d::Zero();
  Vector3d sum_m = Vector3d::Zero();
  int count = 0;
  for (std::size_t a = 0; a < tracks_.sensors(); ++a) {
    const ObservedBody &before = tracks_.at(first, a), &after = tracks_.at(last, a);
    Vector3d moved_m = Vector3d::Zero();
    for (const Joint joint : kMiddle) {
      if (!before.has(joint) || !after.has(joint)) continue;
      moved_m += after.at(joint) - before.at(joint);
      ++count;
    }
    sum_m += world_from_sensor_[a].rotation * moved_m;
  }
  if (count == 0) return Vector3d::Zero();
  const Vector3d velocity_m_s =
      level(sum_m) / (count * static_cast<double>(last - first) * options_.instant_s);
  const double speed_m_s = velocity_m_s.norm();
  return speed_m_s > kNoWalk_m_s
             ? Vector3d(velocity_m_s / speed_m_s * ramp(speed_m_s, kNoWalk_m_s, kWalk_m_s))
             : Vector3d(Vector3d::Zero());
}

}  // namespace trilat
