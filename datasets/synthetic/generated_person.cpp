// SPDX-License-Identifier: MIT
#include "datasets/synthetic/generated_person.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "datasets/base/philox.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

using Eigen::Vector3d;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

// Heights and lengths as fractions of the stature.
namespace fraction {
constexpr double kHip = 0.530, kHipHalfWidth = 0.0955, kThigh = 0.245, kShank = 0.246, kFoot = 0.10;
constexpr double kAnkle = kHip - kThigh - kShank;
constexpr double kSpineMid = 0.66, kSpineShoulder = 0.80, kShoulder = 0.818, kShoulderHalfWidth = 0.129;
constexpr double kUpperArm = 0.186, kForearm = 0.146, kHand = 0.054, kHandTip = 0.108, kThumb = 0.06;
constexpr double kNeck = 0.85, kHead = 0.93;
}  // namespace fraction

// Joint angles of one instant, in radians; [0] is left, [1] right. Flexion swings a limb forward.
struct Angles {
  double shoulder[2] = {0.0, 0.0};
  double elbow[2] = {0.2, 0.2};
  double abduction[2] = {0.12, 0.12};
  double hip[2] = {0.0, 0.0};
  double knee[2] = {0.05, 0.05};
  double adduction[2] = {0.0, 0.0};  // swings the leg across the middle
  double trunk = 0.0;                // lean forward
};

struct BodyAxes {
  Vector3d origin_m, forward, left, up;
};

BodyAxes body_axes(const Vector3d& origin_m, double heading_rad) {
  return {origin_m,
          {std::sin(heading_rad), 0.0, std::cos(heading_rad)},
          {std::cos(heading_rad), 0.0, -std::sin(heading_rad)},
          Vector3d::UnitY()};
}

// A limb hanging down, swung forward by `flexion` and outwards (along `outward`) by `abduction`.
Vector3d hanging(const BodyAxes& body, const Vector3d& outward, double flexion, double abduction) {
  const Vector3d swung = -std::cos(flexion) * body.up + std::sin(flexion) * body.forward;
  return std::cos(abduction) * swung + std::sin(abduction) * outward;
}

Joint sided(Joint left, int side) { return side == 0 ? left : mirror_of(left); }

void place_leg(SkeletonPose& pose, const BodyAxes& body, const Angles& a, int side, double stature) {
  const Vector3d outward = side == 0 ? body.left : Vector3d(-body.left);
  const Vector3d hip = body.origin_m + fraction::kHipHalfWidth * stature * outward;
  const Vector3d knee =
      hip + fraction::kThigh * stature * hanging(body, outward, a.hip[side], -a.adduction[side]);
  const Vector3d ankle = knee + fraction::kShank * stature *
                                    hanging(body, outward, a.hip[side] - a.knee[side], -a.adduction[side]);
  pose.at(sided(Joint::hip_left, side)) = hip;
  pose.at(sided(Joint::knee_left, side)) = knee;
  pose.at(sided(Joint::ankle_left, side)) = ankle;
  pose.at(sided(Joint::foot_left, side)) =
      ankle + stature * (fraction::kFoot * body.forward - 0.025 * body.up);
}

void place_arm(SkeletonPose& pose, const BodyAxes& body, const Vector3d& chest_m, const Angles& a, int side,
               double stature) {
  const Vector3d outward = side == 0 ? body.left : Vector3d(-body.left);
  const Vector3d shoulder = chest_m + stature * (fraction::kShoulderHalfWidth * outward +
                                                 (fraction::kShoulder - fraction::kSpineShoulder) * body.up);
  const Vector3d upper = hanging(body, outward, a.shoulder[side], a.abduction[side]);
  const Vector3d lower = hanging(body, outward, a.shoulder[side] + a.elbow[side], a.abduction[side]);
  const Vector3d elbow = shoulder + fraction::kUpperArm * stature * upper;
  const Vector3d wrist = elbow + fraction::kForearm * stature * lower;
  pose.at(sided(Joint::shoulder_left, side)) = shoulder;
  pose.at(sided(Joint::elbow_left, side)) = elbow;
  pose.at(sided(Joint::wrist_left, side)) = wrist;
  pose.at(sided(Joint::hand_left, side)) = wrist + fraction::kHand * stature * lower;
  pose.at(sided(Joint::hand_tip_left, side)) = wrist + fraction::kHandTip * stature * lower;
  pose.at(sided(Joint::thumb_left, side)) =
      wrist + stature * (fraction::kThumb * lower + 0.02 * body.forward);
}

SkeletonPose pose_of(const Angles& a, const Vector3d& origin_m, double heading_rad, double stature) {
  SkeletonPose pose;
  pose.heading_rad = heading_rad;
  pose.present.set();
  const BodyAxes body = body_axes(origin_m, heading_rad);
  const Vector3d spine = std::cos(a.trunk) * body.up + std::sin(a.trunk) * body.forward;
  const auto on_spine = [&](double height) -> Vector3d {
    return body.origin_m + (height - fraction::kHip) * stature * spine;
  };
  pose.at(Joint::spine_base) = on_spine(fraction::kHip + 0.02);
  pose.at(Joint::spine_mid) = on_spine(fraction::kSpineMid);
  pose.at(Joint::spine_shoulder) = on_spine(fraction::kSpineShoulder);
  pose.at(Joint::neck) = on_spine(fraction::kNeck);
  pose.at(Joint::head) = on_spine(fraction::kHead);
  for (int side : {0, 1}) {
    place_leg(pose, body, a, side, stature);
    place_arm(pose, body, pose.at(Joint::spine_shoulder), a, side, stature);
  }
  return pose;
}

// Place of a person on the floor, and the direction they face.
struct FootPose {
  Vector3d place_m;
  double heading_rad = 0.0;
};

constexpr double kStride_hz = 0.9;
constexpr double kStance = 0.62;  // of a stride a foot stands

// From 0 to 1 with no speed and no acceleration at both ends.
double eased(double x) { return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x); }

// The knee bends forward between a hip and an ankle.
Vector3d knee_between(const Vector3d& hip_m, const Vector3d& ankle_m, const Vector3d& forward,
                      double stature) {
  const double thigh_m = fraction::kThigh * stature, shank_m = fraction::kShank * stature;
  const Vector3d way_m = ankle_m - hip_m, along = way_m.normalized();
  const double to_foot_m =
      (way_m.squaredNorm() + thigh_m * thigh_m - shank_m * shank_m) / (2.0 * way_m.norm());
  const double bend_m = std::sqrt(std::max(0.0, thigh_m * thigh_m - to_foot_m * to_foot_m));
  return hip_m + to_foot_m * along + bend_m * (forward - forward.dot(along) * along).normalized();
}

// A foot stands under its hip as that is in the middle of the stance; between two stances it swings from one
// place to the next. `way`: where the body is at any stride.
void step_leg(SkeletonPose& pose, const Person& p, int side, double stride, const auto& way) {
  const double middle = side == 0 ? std::numbers::pi : 0.0;
  const auto stand_of = [&](double stance) { return way(middle + kTwoPi * stance); };
  const auto ankle_of = [&](const FootPose& stand) -> Vector3d {
    const double aside = (side == 0 ? 1.0 : -1.0) * fraction::kHipHalfWidth * p.stature_m;
    const BodyAxes body = body_axes(stand.place_m, stand.heading_rad);
    return body.origin_m + aside * body.left + fraction::kAnkle * p.stature_m * body.up;
  };
  const double stances = (stride - middle) / kTwoPi, last = std::floor(stances + 0.5 * kStance);
  const double swung = std::clamp((stances - last - 0.5 * kStance) / (1.0 - kStance), 0.0, 1.0);
  const FootPose from = stand_of(last), to = stand_of(last + 1.0);
  const Vector3d from_m = ankle_of(from), step_m = ankle_of(to) - from_m;
  const double lift_m = 0.2 * step_m.norm() * 64.0 * std::pow(swung * (1.0 - swung), 3);
  const Vector3d ankle_m = from_m + eased(swung) * step_m + lift_m * Vector3d::UnitY();
  const BodyAxes foot =
      body_axes(ankle_m, from.heading_rad + eased(swung) * (to.heading_rad - from.heading_rad));
  const Vector3d hip_m = pose.at(sided(Joint::hip_left, side));
  pose.at(sided(Joint::knee_left, side)) =
      knee_between(hip_m, ankle_m, body_axes(hip_m, pose.heading_rad).forward, p.stature_m);
  pose.at(sided(Joint::ankle_left, side)) = ankle_m;
  pose.at(sided(Joint::foot_left, side)) =
      ankle_m + p.stature_m * (fraction::kFoot * foot.forward - 0.025 * foot.up);
}

// At one moment of a stride; arms swing by `swing` of the usual.
SkeletonPose stepping(const Person& p, double stride, double swing, const auto& way) {
  Angles a;
  for (int side : {0, 1}) {
    const double s = (side == 0 ? 1.0 : -1.0) * std::sin(stride);
    a.shoulder[side] = -p.amplitude * 0.45 * swing * s;
    a.elbow[side] = 0.35 + p.amplitude * 0.15 * swing * (1.0 - s);
  }
  a.trunk = 0.05;
  const FootPose here = way(stride);
  const double height_m = fraction::kHip * p.stature_m - 0.03 + 0.015 * swing * std::cos(2.0 * stride);
  SkeletonPose pose = pose_of(a, here.place_m + height_m * Vector3d::UnitY(), here.heading_rad, p.stature_m);
  for (int side : {0, 1}) step_leg(pose, p, side, stride, way);
  return pose;
}

FootPose on_circle(double lap, double radius_m) {
  return {{radius_m * std::cos(lap), 0.0, -radius_m * std::sin(lap)}, lap + std::numbers::pi};
}

SkeletonPose walk(const Person& p, double t) {
  constexpr double kLaps_hz = 4.0 / 35.0, kRadius_m = 0.4;
  return stepping(p, kTwoPi * kStride_hz * p.tempo * t + p.phase_rad, 1.0, [&](double stride) {
    return on_circle(kLaps_hz / kStride_hz * (stride - p.phase_rad) + p.phase_rad, kRadius_m);
  });
}

// One round, then as long at rest on both feet, facing forward.
SkeletonPose walk_and_stop(const Person& p, double t) {
  constexpr double kRound_s = 6.5, kRadius_m = 0.6;
  constexpr double kStrides = 8.0, kFirst = 0.25;  // both feet stand a quarter behind a stance's middle
  const double since = std::fmod(p.tempo * t + p.phase_rad / kTwoPi * 2.0 * kRound_s, 2.0 * kRound_s);
  const double strides = kFirst + kStrides * std::min(since, kRound_s) / kRound_s;
  return stepping(p, kTwoPi * strides, 1.0, [&](double stride) {
    const double walked = (stride / kTwoPi - 2.0 * kFirst) / (kStrides - 2.0 * kFirst);
    return on_circle(std::numbers::pi + kTwoPi * std::clamp(walked, 0.0, 1.0), kRadius_m);
  });
}

SkeletonPose swing_arms(const Person& p, double t) {
  const double swing = kTwoPi / 3.0 * p.tempo * t + p.phase_rad;
  Angles a;
  for (int side : {0, 1}) {
    const double s = side == 0 ? 1.0 : -1.0;
    a.shoulder[side] = 0.2 + p.amplitude * 0.9 * s * std::sin(swing);
    a.elbow[side] = 0.3 + p.amplitude * 0.2 * (1.0 + s * std::sin(swing));
  }
  a.trunk = 0.02 * std::sin(swing);
  return pose_of(a, {0.0, fraction::kHip * p.stature_m, 0.0}, 0.0, p.stature_m);
}

SkeletonPose cross_legs(const Person& p, double t) {
  const double step = kTwoPi / 1.75 * p.tempo * t + p.phase_rad;
  Angles a;
  for (int side : {0, 1}) {
    const double s = side == 0 ? 1.0 : -1.0;
    a.hip[side] = p.amplitude * 0.3 * s * std::sin(step);
    a.knee[side] = 0.1 + p.amplitude * 0.15 * (1.0 + s * std::cos(step));
    a.adduction[side] = p.amplitude * 0.16 * (1.0 + s * std::sin(step));
    a.shoulder[side] = -p.amplitude * 0.15 * s * std::sin(step);
  }
  return pose_of(a, {0.0, fraction::kHip * p.stature_m - 0.01, 0.15 * std::sin(0.5 * step)}, 0.0,
                 p.stature_m);
}

// To and fro and from side to side, always facing forward.
SkeletonPose step(const Person& p, double t) {
  constexpr double kWays_hz = 1.0 / 12.0;
  const auto way_of = [&](double stride) { return kWays_hz / kStride_hz * stride + p.phase_rad; };
  const double stride = kTwoPi * kStride_hz * p.tempo * t;
  return stepping(p, stride, 0.45 * std::abs(std::cos(way_of(stride))), [&](double at) -> FootPose {
    return {{0.3 * std::sin(2.0 * way_of(at)), 0.0, 0.6 * std::sin(way_of(at))}};
  });
}

}  // namespace

Person draw_person(std::uint64_t seed, std::uint64_t index, double stature_mean_m,
                   double stature_half_range_m) {
  const RandomStream random{seed, Purpose::participant, index};
  Person person;
  person.stature_m =
      random.uniform(0, stature_mean_m - stature_half_range_m, stature_mean_m + stature_half_range_m);
  person.tempo = random.uniform(1, 0.9, 1.1);
  person.amplitude = random.uniform(2, 0.9, 1.1);
  person.phase_rad = random.uniform(3, 0.0, kTwoPi);
  return person;
}

Motion generated_motion(const Person& person, Activity activity) {
  switch (activity) {
    case Activity::walking:
      return [person](double t) { return walk(person, t); };
    case Activity::arm_swing:
      return [person](double t) { return swing_arms(person, t); };
    case Activity::leg_crossing:
      return [person](double t) { return cross_legs(person, t); };
    case Activity::steps:
      return [person](double t) { return step(person, t); };
    case Activity::walk_and_stop:
      return [person](double t) { return walk_and_stop(person, t); };
    case Activity::standing:
      break;
  }
  return [person](double) {
    return pose_of({}, {0.0, fraction::kHip * person.stature_m, 0.0}, 0.0, person.stature_m);
  };
}

}  // namespace trilat
