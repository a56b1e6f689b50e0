// SPDX-License-Identifier: MIT
#include "pipeline/tracker/take_view.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "datasets/synthetic/depth/joint_visibility.h"
#include "datasets/synthetic/tracker/joint_errors.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/error_statistics.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kGross_m = 0.3;         // beyond, a joint is another one, or lost
constexpr double kVisible = 0.8;         // share from which a joint is surely visible
constexpr double kStep_m = 0.005;        // a shorter step is noise
constexpr double kParallel_rad = 0.26;   // rays of two sensors that see a person from one side
constexpr double kWalking_m_s = 0.35;    // from which on a person faces where they go
constexpr double kHiddenError_m = 0.15;  // of a joint that is hidden rather than seen
constexpr double kTurned_rad = 0.3;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

// Where a body faces by its shoulders and hips, as SkeletonPose's heading; nothing without one of these
// pairs.
std::optional<double> facing(const SkeletonPose& pose) {
  Vector3d to_left = Vector3d::Zero();
  for (const Joint left : {Joint::shoulder_left, Joint::hip_left}) {
    const Joint right = mirror_of(left);
    if (pose.present[static_cast<std::size_t>(left)] && pose.present[static_cast<std::size_t>(right)])
      to_left += pose.at(left) - pose.at(right);
  }
  if (to_left.isZero()) return std::nullopt;
  return std::atan2(-to_left.z(), to_left.x());
}

double azimuth_of(SkeletonPose body, double heading_rad, const Vector3d& sensor_m) {
  body.heading_rad = heading_rad == 0.0 ? 1e-12 : heading_rad;  // 0 would be unknown
  return body_view(body, sensor_m).azimuth_rad;
}

// How two observations share each part: the expectation of their product is this times the parts' variances.
Vector3d shared_parts(const Observation& a, const Observation& b) {
  Vector3d parts = Vector3d::Zero();
  for (int m = 0; m < (a.difference ? 2 : 1); ++m)
    for (int n = 0; n < (b.difference ? 2 : 1); ++n) {
      const auto k = static_cast<std::size_t>(m), l = static_cast<std::size_t>(n);
      const double sign = m == n ? 1.0 : -1.0;
      parts[common] += sign;
      parts[view] += sign * std::cos(a.azimuth_rad[k] - b.azimuth_rad[l]);
      if (a.sensor[k] == b.sensor[l]) parts[own] += sign;
    }
  return parts;
}

// One take seen instant by instant.
class TakeView {
 public:
  TakeView(const WatchedTake& take, std::size_t number, ParticipantSums& sums)
      : take_(take), number_(number), sums_(sums) {
    for (const DepthIntrinsics& intrinsics : take.intrinsics) sight_.emplace_back(intrinsics);
    for (std::size_t s = 0; s < take.world_from_sensor.size(); ++s)
      for (std::size_t j = 0; j < kJointCount; ++j)
        for (std::size_t i = 0; i < take.bodies.instants(); ++i)
          has_states_ |= take.bodies.at(i, s).state[j] == TrackingState::inferred;
  }

  std::vector<Observation> observations(std::size_t stride) {
    std::vector<Observation> found;
    for (std::size_t i = 0; i < take_.bodies.instants(); ++i) {
      poses_.clear();
      for (std::size_t s = 0; s < take_.world_from_sensor.size(); ++s) poses_.push_back(pose_of(i, s));
      advance(i);
      if (i % stride == 0) observe(i, found);
    }
    return found;
  }

 private:
  using Shares = std::array<double, kJointCount>;  // of which is visible

  bool has_truth() const { return take_.truth_kind != TruthKind::none; }
  bool is_exact() const { return take_.truth_kind == TruthKind::exact; }
  const Vector3d& truth(std::size_t instant, std::size_t joint) const {
    return take_.truth_m[instant * kJointCount + joint];
  }

  SkeletonPose pose_of(std::size_t instant, std::size_t sensor) const {
    SkeletonPose pose;
    const ObservedBody& body = take_.bodies.at(instant, sensor);
    for (std::size_t j = 0; j < kJointCount; ++j)
      if (body.has(j)) {
        pose.joint_in_world_m[j] = take_.world_from_sensor[sensor] * body.at(static_cast<Joint>(j));
        pose.present.set(j);
      }
    return pose;
  }

  // The truth, or the middle of all sensors but one.
  SkeletonPose middle(std::size_t instant, std::optional<std::size_t> without) const {
    SkeletonPose pose;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (take_.truth_kind == TruthKind::exact && truth(instant, j).allFinite()) {
        pose.joint_in_world_m[j] = truth(instant, j);
        pose.present.set(j);
        continue;
      }
      double n = 0.0;
      for (std::size_t s = 0; s < poses_.size(); ++s)
        if (poses_[s].present[j] && s != without) {
          pose.joint_in_world_m[j] += poses_[s].joint_in_world_m[j];
          n += 1.0;
        }
      if (n > 0.0) pose.joint_in_world_m[j] /= n;
      pose.present[j] = n > 0.0;
    }
    return pose;
  }

  // Where the truth faces; nothing where it has neither both shoulders nor both hips.
  std::optional<double> true_heading(std::size_t instant) const {
    SkeletonPose pose;
    for (std::size_t j = 0; has_truth() && j < kJointCount; ++j)
      if (truth(instant, j).allFinite()) {
        pose.joint_in_world_m[j] = truth(instant, j);
        pose.present.set(j);
      }
    return facing(pose);
  }

  // Where the body faces: as the truth does, else in the middle of what the sensors see, when they agree.
  std::optional<double> heading(std::size_t instant) const {
    if (const auto known_rad = true_heading(instant)) return known_rad;
    double x = 0.0, z = 0.0;
    std::vector<double> each;
    for (const SkeletonPose& seen : poses_)
      if (const auto one = facing(seen)) {
        each.push_back(*one);
        x += std::sin(*one);
        z += std::cos(*one);
      }
    const double all = std::atan2(x, z);
    for (const double one : each)
      if (std::abs(wrapped(one - all)) > std::numbers::pi / 3.0) return std::nullopt;
    return each.empty() ? std::nullopt : std::optional(all);
  }

  // Along each joint's path, and where the person walks.
  void advance(std::size_t instant) {
    const SkeletonPose now = middle(instant, std::nullopt);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      if (!now.present[j]) continue;
      const double step_m =
          last_.present[j] ? (now.joint_in_world_m[j] - last_.joint_in_world_m[j]).norm() : 0.0;
      if (last_.present[j] && step_m < kStep_m) continue;
      path_m_[j] += step_m < kGross_m ? step_m : 0.0;
      last_.joint_in_world_m[j] = now.joint_in_world_m[j];
      last_.present.set(j);
    }
    places_.push_back(now.present[static_cast<std::size_t>(Joint::spine_base)] ? now.at(Joint::spine_base)
                                                                               : Vector3d::Constant(kNaN));
    const auto window = static_cast<std::size_t>(std::lround(0.5 / take_.step_s));
    if (window == 0 || places_.size() <= window) return;
    Vector3d gone_m = places_.back() - places_[places_.size() - 1 - window];
    gone_m.y() = 0.0;
    std::optional<double> known_rad = true_heading(instant);
    if (!known_rad && gone_m.norm() > kWalking_m_s * 0.5) known_rad = std::atan2(gone_m.x(), gone_m.z());
    if (!known_rad) return;
    for (std::size_t s = 0; s < poses_.size(); ++s) {
      const auto seen_rad = facing(poses_[s]);
      if (!seen_rad) continue;
      const double off_rad =
          std::abs(azimuth_of(poses_[s], *known_rad, take_.world_from_sensor[s].translation_m));
      sums_.backs.emplace_back(off_rad, std::abs(wrapped(*seen_rad - *known_rad)) > 0.5 * std::numbers::pi);
    }
  }

  void observe(std::size_t instant, std::vector<Observation>& found) {
    const std::optional<double> heading_rad = heading(instant);
    if (!heading_rad) return;
    const std::size_t sensors = poses_.size();
    std::vector<double> azimuth_rad(sensors, kNaN);
    std::vector<Shares> visible(sensors), agreed(sensors);
    for (std::size_t s = 0; s < sensors; ++s) {
      const auto seen_rad = facing(poses_[s]);
      if (!seen_rad || std::abs(wrapped(*seen_rad - *heading_rad)) > 0.5 * std::numbers::pi) continue;
      azimuth_rad[s] = azimuth_of(poses_[s], *heading_rad, take_.world_from_sensor[s].translation_m);
      const SkeletonPose pose = middle(instant, sensors > 1 ? std::optional(s) : std::nullopt);
      sight_[s].set_persons(std::span(&pose, 1), take_.world_from_sensor[s]);
      for (std::size_t j = 0; j < kJointCount; ++j)
        visible[s][j] = pose.present[j] ? sight_[s].visible_share(0, static_cast<Joint>(j)) : 0.5;
      agreed[s] = is_exact() ? visible[s] : agreed_shares(s, visible[s]);
    }
    const Eigen::Matrix3d body_from_world = world_from_body(*heading_rad).transpose();
    const auto start = [&](std::size_t a, std::size_t b, bool difference) {
      Observation o{.take = number_,
                    .instant = instant,
                    .sensor = {a, b},
                    .azimuth_rad = {azimuth_rad[a], azimuth_rad[b]},
                    .difference = difference,
                    .body_from_world = body_from_world,
                    .error_m = {},
                    .path_m = path_m_};
      o.error_m.fill(Vector3d::Constant(kNaN));
      return o;
    };
    for (std::size_t a = 0; a < sensors; ++a) {
      if (!std::isfinite(azimuth_rad[a])) continue;
      if (has_truth()) {
        Observation o = start(a, a, false);
        for (std::size_t j = 0; j < kJointCount; ++j) {
          if (!poses_[a].present[j] || !truth(instant, j).allFinite()) continue;
          note_state(instant, a, j, visible[a][j]);
          const Vector3d error_m = poses_[a].joint_in_world_m[j] - truth(instant, j);
          if (is_exact()) note_share(agreed[a][j], error_m.norm());
          keep(o, j, error_m, is_seen(instant, a, j, visible[a][j]), is_hidden(instant, a, j, visible[a][j]),
               a);
        }
        found.push_back(o);
      }
      if (is_exact()) continue;  // else the sensors tell among themselves what markers do not
      for (std::size_t b = a + 1; b < sensors; ++b) {
        if (!std::isfinite(azimuth_rad[b])) continue;
        Observation o = start(a, b, true);
        for (std::size_t j = 0; j < kJointCount; ++j) {
          if (!poses_[a].present[j] || !poses_[b].present[j]) continue;
          const bool a_seen = is_seen(instant, a, j, visible[a][j]),
                     b_seen = is_seen(instant, b, j, visible[b][j]);
          const bool one_hidden = (is_hidden(instant, a, j, visible[a][j]) && b_seen) ||
                                  (is_hidden(instant, b, j, visible[b][j]) && a_seen);
          const double apart_m = (poses_[a].joint_in_world_m[j] - poses_[b].joint_in_world_m[j]).norm();
          if (visible[b][j] >= 1.0) note_share(agreed[a][j], apart_m);
          if (visible[a][j] >= 1.0) note_share(agreed[b][j], apart_m);
          keep(o, j, poses_[a].joint_in_world_m[j] - poses_[b].joint_in_world_m[j], a_seen && b_seen,
               one_hidden, a);
        }
        found.push_back(o);
      }
    }
  }

  // What a sensor sees of the joints where each of the others by itself puts them, NaN where they do not
  // agree with their middle: errors of a few centimetres make a hidden joint a visible one.
  Shares agreed_shares(std::size_t sensor, Shares shares) {
    for (std::size_t other = 0; other < poses_.size(); ++other) {
      if (other == sensor) continue;
      sight_[sensor].set_persons(std::span(&poses_[other], 1), take_.world_from_sensor[sensor]);
      for (std::size_t j = 0; j < kJointCount; ++j)
        if (!poses_[other].present[j] ||
            std::abs(sight_[sensor].visible_share(0, static_cast<Joint>(j)) - shares[j]) > 0.5 / kRays)
          shares[j] = kNaN;
    }
    return shares;
  }

  bool tracked(std::size_t instant, std::size_t sensor, std::size_t joint) const {
    return take_.bodies.at(instant, sensor).state[joint] == TrackingState::tracked;
  }

  bool is_seen(std::size_t instant, std::size_t sensor, std::size_t joint, double visible) const {
    return visible >= kVisible && tracked(instant, sensor, joint);
  }
  bool is_hidden(std::size_t instant, std::size_t sensor, std::size_t joint, double visible) const {
    return visible <= 0.0 && !(has_states_ && tracked(instant, sensor, joint));
  }

  void note_share(double visible, double error_m) {
    if (std::isnan(visible)) return;
    auto& [gross, count] = sums_.gross_by_share[static_cast<std::size_t>(std::lround(visible * kRays))];
    gross += error_m > kHiddenError_m ? 1.0 : 0.0;
    count += 1.0;
  }

  void note_state(std::size_t instant, std::size_t sensor, std::size_t joint, double visible) {
    if (!has_states_ || visible > 0.0) return;
    sums_.hidden_joints += 1.0;
    sums_.inferred += tracked(instant, sensor, joint) ? 0.0 : 1.0;
  }

  void keep(Observation& o, std::size_t joint, const Vector3d& error_m, bool seen, bool hidden,
            std::size_t sensor) {
    const std::size_t group = group_of(joint);
    const bool to_scale = o.difference || is_exact();  // markers stand off the joints
    if (hidden && to_scale) {
      const Vector3d parts = shared_parts(o, o);
      sums_.hidden_squares[group] += error_m.squaredNorm() / 3.0;
      sums_.hidden_count[group] += 1.0;
      sums_.hidden_row[group] += (Row() << parts, parts).finished();
    }
    if (!seen) return;
    o.error_m[joint] = o.body_from_world * error_m;
    if (!to_scale ||
        (o.difference && std::abs(wrapped(o.azimuth_rad[0] - o.azimuth_rad[1])) > kParallel_rad) ||
        error_m.norm() > kGross_m)
      return;
    const Vector3d ray =
        (poses_[sensor].joint_in_world_m[joint] - take_.world_from_sensor[sensor].translation_m).normalized();
    const double along = std::pow(error_m.dot(ray), 2);
    sums_.along += along;
    sums_.across += 0.5 * (error_m.squaredNorm() - along);
    sums_.rays += 1.0;
  }

  const WatchedTake& take_;
  std::size_t number_;
  ParticipantSums& sums_;
  std::vector<JointVisibility> sight_;
  bool has_states_ = false;
  std::vector<SkeletonPose> poses_;
  SkeletonPose last_;
  std::array<double, kJointCount> path_m_{};
  std::vector<Vector3d> places_;
};

bool is_gross(const Vector3d& error_m) { return !(error_m.squaredNorm() < kGross_m * kGross_m); }

}  // namespace

std::vector<Observation> observe_take(const WatchedTake& take, std::size_t number, std::size_t stride,
                                      ParticipantSums& sums) {
  return TakeView(take, number, sums).observations(stride);
}

void undo_lag(const WatchedTake& take, std::vector<Observation>& observations, ParticipantSums& sums) {
  const auto at = [&](std::size_t instant, std::size_t joint) -> const Vector3d& {
    return take.truth_m[instant * kJointCount + joint];
  };
  struct Moving {
    std::array<Vector3d, kJointCount> velocity, acceleration;  // in the body's frame
  };
  std::vector<Moving> motions(observations.size());
  double with_velocity = 0.0, velocities = 0.0, with_acceleration = 0.0, accelerations = 0.0;
  for (std::size_t n = 0; n < observations.size(); ++n) {
    const Observation& o = observations[n];
    const std::size_t i = o.instant;
    const bool inside = i > 0 && i + 1 < take.bodies.instants();
    for (std::size_t j = 0; j < kJointCount; ++j) {
      Vector3d &v = motions[n].velocity[j], &a = motions[n].acceleration[j];
      v = a = Vector3d::Constant(kNaN);
      if (!inside) continue;
      v = o.body_from_world * (at(i + 1, j) - at(i - 1, j)) / (2.0 * take.step_s);
      a = o.body_from_world * (at(i + 1, j) - 2.0 * at(i, j) + at(i - 1, j)) / (take.step_s * take.step_s);
      if (!v.allFinite() || !a.allFinite() || !o.error_m[j].allFinite()) continue;
      with_velocity -= o.error_m[j].dot(v);
      velocities += v.squaredNorm();
      with_acceleration += o.error_m[j].dot(a);
      accelerations += a.squaredNorm();
    }
  }
  sums.with_velocity += with_velocity;
  sums.velocities += velocities;
  sums.accelerations += accelerations;
  if (velocities <= 0.0 || accelerations <= 0.0) return;
  for (std::size_t n = 0; n < observations.size(); ++n)
    for (std::size_t j = 0; j < kJointCount; ++j)
      observations[n].error_m[j] += with_velocity / velocities * motions[n].velocity[j] -
                                    with_acceleration / accelerations * motions[n].acceleration[j];
}

void add_products(const std::vector<Observation>& all, ParticipantSums& sums) {
  for (std::size_t m = 0; m < all.size(); ++m)
    for (std::size_t n = m + 1; n < all.size(); ++n) {
      const Observation &a = all[m], &b = all[n];
      const bool one_take = a.take == b.take;
      if (one_take && a.instant == b.instant) continue;
      const Vector3d parts = shared_parts(a, b);
      const Vector3d kept = one_take ? parts : Vector3d::Zero();
      for (std::size_t j = 0; j < kJointCount; ++j)
        if (!is_gross(a.error_m[j]) && !is_gross(b.error_m[j]))
          sums.products[group_of(j)].add(parts, Vector3d::Zero(), kept, std::abs(a.path_m[j] - b.path_m[j]),
                                         a.error_m[j].dot(b.error_m[j]) / 3.0);
    }
}

void add_increments(const std::vector<Observation>& all, const WatchedTake& take, ParticipantSums& sums) {
  std::vector<std::pair<std::size_t, std::size_t>> instants;  // first observation and one behind the last
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (m == 0 || all[m].instant != all[m - 1].instant) instants.emplace_back(m, m);
    instants.back().second = m + 1;
  }
  std::map<std::array<std::size_t, 2>, std::array<Vector3d, kJointCount>> middle;
  if (take.truth_kind == TruthKind::markers)
    for (const Observation& o : all) {
      if (middle.contains(o.sensor)) continue;
      for (std::size_t j = 0; j < kJointCount; ++j)
        for (int axis = 0; axis < 3; ++axis) {
          std::vector<double> values;
          for (const Observation& other : all)
            if (other.sensor == o.sensor && other.error_m[j].allFinite())
              values.push_back(other.error_m[j][axis]);
          middle[o.sensor][j][axis] = quantiles_of(values, {0.5})[0];
        }
    }
  else
    for (const Observation& o : all) middle[o.sensor].fill(Vector3d::Zero());
  const auto find = [&](const std::pair<std::size_t, std::size_t>& range, const Observation& like) {
    for (std::size_t m = range.first; m < range.second; ++m)
      if (all[m].sensor == like.sensor) return &all[m];
    return static_cast<const Observation*>(nullptr);
  };
  // Seen from another side the bias is another one.
  const auto turned = [&](const Observation& o, const Observation& then) {
    return std::abs(wrapped(o.azimuth_rad[0] - then.azimuth_rad[0])) > kTurned_rad ||
           std::abs(wrapped(o.azimuth_rad[1] - then.azimuth_rad[1])) > kTurned_rad;
  };
  // What is beyond five times the usual change is no wander.
  std::array<std::vector<double>, kTrackerGroups> changes_m2;
  for (std::size_t m = 0; m + 1 < instants.size(); ++m)
    for (std::size_t n = m + 1; n < instants.size(); n += 1 + (n - m))
      for (std::size_t k = instants[m].first; k < instants[m].second; ++k)
        if (const Observation* then = find(instants[n], all[k]))
          for (std::size_t j = 0; j < kJointCount; ++j)
            if (!is_gross(all[k].error_m[j] - then->error_m[j]))
              changes_m2[group_of(j)].push_back((all[k].error_m[j] - then->error_m[j]).squaredNorm());
  std::array<double, kTrackerGroups> most_m2{};
  constexpr double kMedianOfChi2 = 2.366;  // of three degrees
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    most_m2[g] = changes_m2[g].empty() ? 0.0 : 30.0 * quantiles_of(changes_m2[g], {0.5})[0] / kMedianOfChi2;
  const auto usable = [&](const Observation& o, const Observation& then, std::size_t j) {
    return !is_gross(o.error_m[j] - middle.at(o.sensor)[j]) &&
           !is_gross(then.error_m[j] - middle.at(o.sensor)[j]) &&
           (o.error_m[j] - then.error_m[j]).squaredNorm() <= most_m2[group_of(j)];
  };
  for (std::size_t m = 0; m < instants.size(); ++m)
    for (std::size_t n = m + 1; n < instants.size(); ++n)
      for (std::size_t k = instants[m].first; k < instants[m].second; ++k)
        for (std::size_t l = k; l < (all[k].difference ? k + 1 : instants[m].second); ++l) {
          const Observation &a = all[k], &b = all[l];
          if (a.difference != b.difference) continue;
          const Observation *a_then = find(instants[n], a), *b_then = find(instants[n], b);
          if (a_then == nullptr || b_then == nullptr || turned(a, *a_then) || turned(b, *b_then)) continue;
          const Vector3d at_once = 0.5 * (shared_parts(a, b) + shared_parts(*a_then, *b_then)),
                         apart = 0.5 * (shared_parts(a, *b_then) + shared_parts(*a_then, b));
          for (std::size_t j = 0; j < kJointCount; ++j) {
            if (!usable(a, *a_then, j) || !usable(b, *b_then, j)) continue;
            const double jitter_m = take.jitter_m[group_of(j)];
            const double y =
                (a.error_m[j] - a_then->error_m[j]).dot(b.error_m[j] - b_then->error_m[j]) / 6.0 -
                (k == l && std::isfinite(jitter_m) ? jitter_m * jitter_m : 0.0);
            sums.increments[group_of(j)].add(at_once - apart, at_once, -apart,
                                             std::abs(a.path_m[j] - a_then->path_m[j]), y);
          }
        }
}

}  // namespace trilat
