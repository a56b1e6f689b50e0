// SPDX-License-Identifier: MIT
// Streams of joints that differ from their truth in a known way.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "datasets/base/philox.h"
#include "datasets/synthetic/generated_person.h"
#include "pipeline/stream_fit/stream_fit.h"

namespace trilat::testing_support {

inline const std::vector<std::string>& changed_activities() {
  static const std::vector<std::string> names{"walking", "arm_swing", "leg_crossing", "standing", "squat"};
  return names;
}

enum class Change {
  none,
  unit,
  scale,
  small_scale,
  point_unit,
  later_unit,
  axis_unit,
  start,
  far_start,
  rate,
  drift,
  all_sides,
  legs,
  knees,
  neighbours,
  shift,
  turn,
  mirror,
  axes,
  root,
  level_root,
  body_frame,
  axis_scale,
  one_name_off,
  flat,
  other_person
};
// Name of each change, and the causes that it is.
struct ChangeKind {
  const char* name;
  unsigned causes;
};
inline constexpr std::array kChangeKinds{ChangeKind{"none", 0},
                                         ChangeKind{"unit", kSizeCause},
                                         ChangeKind{"scale", kSizeCause},
                                         ChangeKind{"small scale", 0},
                                         ChangeKind{"unit of a point", kPointSizeCause},
                                         ChangeKind{"unit from a time on", kLaterSizeCause},
                                         ChangeKind{"unit of an axis", kAxisSizeCause},
                                         ChangeKind{"start", kStartCause},
                                         ChangeKind{"start without overlap", kStartCause},
                                         ChangeKind{"rate", kRateCause},
                                         ChangeKind{"drift", kRateCause},
                                         ChangeKind{"all sides", kSidesCause},
                                         ChangeKind{"legs", kSidesCause},
                                         ChangeKind{"knees", kSidesCause},
                                         ChangeKind{"elbow and wrist", kSidesCause},
                                         ChangeKind{"shift", kShiftCause},
                                         ChangeKind{"turn", kTurnCause},
                                         ChangeKind{"mirror", kMirrorCause},
                                         ChangeKind{"axes", kTurnCause},
                                         ChangeKind{"relative to a point", kRootCause},
                                         ChangeKind{"relative to a point, but for heights", kRootCause},
                                         ChangeKind{"in the body's axes", kRootCause},
                                         ChangeKind{"scale of an axis", kAxisSizeCause},
                                         ChangeKind{"names one place off", kSidesCause},
                                         ChangeKind{"flat", 0},
                                         ChangeKind{"other person", 0}};
inline const ChangeKind& kind_of(Change change) { return kChangeKinds.at(static_cast<std::size_t>(change)); }

struct ChangedStreams {
  PointStream reference, subject;
  std::vector<std::string> names;
  std::vector<std::size_t> mirrored;
};

class ChangedStreamMaker {
 public:
  ChangedStreamMaker(const std::string& activity, std::uint64_t seed, double duration_s = 0.0)
      : activity_(activity), random_{seed, Purpose::test, 77}, duration_s_(duration_s) {
    if (duration_s_ == 0.0) duration_s_ = 8.0 + 22.0 * uniform();
    const Person person = draw_person(seed, 1, 1.7, 0.17);
    static const std::array kActivities{Activity::walking, Activity::arm_swing, Activity::leg_crossing,
                                        Activity::standing};
    for (std::size_t k = 0; k < kActivities.size(); ++k)
      if (activity == changed_activities()[k]) motion_ = generated_motion(person, kActivities.at(k));
    if (!motion_) motion_ = squat(generated_motion(person, Activity::standing));
    const Eigen::Vector2d place_m(4.0 * uniform() - 2.0, 4.0 * uniform() - 2.0);
    place_m_ = {place_m.x(), 0.0, place_m.y()};
    for (const char* name : {"spine_base", "spine_shoulder", "head", "shoulder_left", "shoulder_right",
                             "elbow_left", "elbow_right", "wrist_left", "wrist_right", "hip_left",
                             "hip_right", "knee_left", "knee_right", "ankle_left", "ankle_right"})
      names_.emplace_back(name);
    for (std::size_t j = 0; j < names_.size(); ++j)
      offset_in_body_m_.push_back(0.03 * Eigen::Vector3d(normal(), normal(), normal()));
  }

  ChangedStreams with(const std::vector<Change>& changes) {
    const auto has = [&](Change c) { return std::ranges::find(changes, c) != changes.end(); };
    ChangedStreams streams;
    streams.names = names_;
    streams.mirrored = mirrored_points(names_);
    const std::size_t points = names_.size();
    streams.reference = {0.0, 50.0, points, {}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(duration_s_ * 50.0); ++i)
      for (const Eigen::Vector3d& at_m : joints_at(static_cast<double>(i) / 50.0))
        streams.reference.at_m.push_back(at_m);
    const double sign = uniform() < 0.5 ? -1.0 : 1.0;
    double start_s = 0.0, stretch = 1.0;
    if (has(Change::start))
      start_s = sign * (uniform() < 0.4 ? 0.1 + 0.2 * uniform() : 0.5 + 1.5 * uniform());
    static constexpr std::array<std::array<double, 2>, 9> kMistaken{
        {{24, 25}, {29, 30}, {60, 50}, {50, 60}, {60, 100}, {120, 100}, {200, 250}, {30, 60}, {60, 30}}};
    if (has(Change::rate)) {
      const auto& r = kMistaken.at(static_cast<std::size_t>(uniform() * 8.999));
      stretch = r[0] / r[1];
    }
    if (has(Change::drift)) stretch = 1.0 + sign * 0.002;
    // the subject shows at its time tau what was at start_s + stretch tau
    const double rate_hz = 30.0;
    streams.subject = {0.0, rate_hz, points, {}};
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
    if (has(Change::turn)) {
      rotation =
          Eigen::AngleAxisd(sign * (0.2 + 0.8 * uniform()), Eigen::Vector3d::UnitY()).toRotationMatrix();
      shift_m = {uniform(), 0.0, -uniform()};
    }
    if (has(Change::shift)) shift_m = {0.4, sign * 0.1, 0.3};
    if (has(Change::mirror)) rotation = Eigen::Vector3d(-1, 1, 1).asDiagonal() * rotation;
    if (has(Change::axes))
      rotation = Eigen::AngleAxisd(sign * std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                 rotation;
    double factor = 1.0;
    if (has(Change::unit))
      factor =
          std::array{1000.0, 100.0, 0.001, 0.01, 39.3701}.at(static_cast<std::size_t>(uniform() * 4.999));
    if (has(Change::scale))
      factor = std::array{1.15, 1.25, 0.85}.at(static_cast<std::size_t>(uniform() * 2.999));
    if (has(Change::small_scale)) factor = 1.05;
    const std::size_t wrist = 7,
                      from = static_cast<std::size_t>((0.35 + 0.3 * uniform()) * duration_s_ * rate_hz);
    const int axis = static_cast<int>(from % 3);
    std::vector<std::size_t> order(points);
    for (std::size_t j = 0; j < points; ++j) order[j] = j;
    const auto exchange = [&](std::size_t first, std::size_t end) {
      for (std::size_t j = first; j + 1 < end; j += 2) std::swap(order[j], order[j + 1]);
    };
    if (has(Change::all_sides)) exchange(3, 15);
    if (has(Change::legs)) exchange(9, 15);
    if (has(Change::knees)) exchange(11, 13);
    if (has(Change::neighbours)) std::swap(order[5], order[7]);
    if (has(Change::one_name_off)) std::ranges::rotate(order, order.begin() + 1);
    Motion motion = motion_;
    if (has(Change::other_person))
      motion_ = generated_motion(draw_person(99, 5, 1.7, 0.17), Activity::walk_and_stop);
    std::vector<Eigen::Vector3d> drift(points, Eigen::Vector3d::Zero());
    for (std::size_t i = 0; static_cast<double>(i) * stretch / rate_hz < duration_s_; ++i) {
      const double when_s = start_s + stretch * static_cast<double>(i) / rate_hz;
      std::vector<Eigen::Vector3d> at_m = joints_at(when_s);
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(motion_(when_s).heading_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
      for (std::size_t j = 0; j < points; ++j) {
        drift[j] = 0.93 * drift[j] + 0.003 * Eigen::Vector3d(normal(), normal(), normal());
        at_m[j] +=
            turn * offset_in_body_m_[j] + drift[j] + 0.004 * Eigen::Vector3d(normal(), normal(), normal());
      }
      Eigen::Vector3d root_m = Eigen::Vector3d::Zero();
      if (has(Change::root) || has(Change::body_frame)) root_m = at_m[0];
      if (has(Change::level_root)) root_m = {at_m[0].x(), 0.0, at_m[0].z()};
      if (has(Change::body_frame)) rotation = turn.transpose();
      for (std::size_t j = 0; j < points; ++j) {
        Eigen::Vector3d p = factor * (rotation * (at_m[order[j]] - root_m) + shift_m);
        if (has(Change::point_unit) && j == wrist) p *= 0.1;
        if (has(Change::later_unit) && i >= from) p *= 0.1;
        if (has(Change::axis_unit)) p[axis] *= 100.0;
        // who stays in place is wide along y alone
        if (has(Change::axis_scale)) p[activity_ == "walking" ? axis : 1] *= from % 2 == 0 ? 1.5 : 0.6;
        if (has(Change::flat)) p.z() = 0.0;
        streams.subject.at_m.push_back(p);
      }
    }
    motion_ = motion;
    if (has(Change::far_start)) streams.subject.first_s = -80.0;
    return streams;
  }

 private:
  double uniform() { return random_.uniform(draw_++); }
  double normal() { return random_.normal(draw_++); }

  static Motion squat(Motion standing) {
    return [standing](double time_s) {
      SkeletonPose pose = standing(time_s);
      const double deep =
          0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * time_s / 3.1 + 0.7 * std::sin(0.4 * time_s));
      for (std::size_t j = 0; j < kJointCount; ++j) {
        Eigen::Vector3d& at_m = pose.joint_in_world_m[j];
        const double height = std::clamp(at_m.y() / 0.95, 0.0, 1.0);
        at_m.y() -= 0.4 * deep * height;
        const double forward_m = 0.25 * deep * std::sin(std::numbers::pi * height);
        at_m += forward_m * Eigen::Vector3d(std::sin(pose.heading_rad), 0.0, std::cos(pose.heading_rad));
      }
      return pose;
    };
  }

  std::vector<Eigen::Vector3d> joints_at(double time_s) const {
    const SkeletonPose pose = motion_(time_s);
    std::vector<Eigen::Vector3d> at_m;
    for (const std::string& name : names_) at_m.push_back(pose.at(*joint_from_name(name)) + place_m_);
    return at_m;
  }

  std::string activity_;
  RandomStream random_;
  std::uint32_t draw_ = 0;
  double duration_s_;
  Motion motion_;
  Eigen::Vector3d place_m_;
  std::vector<std::string> names_;
  std::vector<Eigen::Vector3d> offset_in_body_m_;
};

}  // namespace trilat::testing_support
