// SPDX-License-Identifier: MIT
#include "pipeline/tracker/measure_tracker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "datasets/synthetic/depth/joint_visibility.h"
#include "datasets/synthetic/tracker/joint_errors.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/metrics/student.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

constexpr double kGross_m = 0.3;          // beyond, a joint is another one, or lost
constexpr double kVisible = 0.8;          // share from which a joint is surely visible
constexpr double kStep_m = 0.005;         // a shorter step is noise
constexpr double kParallel_rad = 0.26;    // rays of two sensors that see a person from one side
constexpr double kWalking_m_s = 0.35;     // from which on a person faces where they go
constexpr double kBehind_rad = 2.6;       // 150 degrees
constexpr std::size_t kMostPerRig = 300;  // observations of one participant
constexpr double kHiddenError_m = 0.15;   // of a joint that is hidden rather than seen
constexpr std::size_t kRays = 5;          // about a joint, of which a share is visible
constexpr double kTurned_rad = 0.3;
constexpr double kFirstBack_rad = 1.0;
constexpr double kResolution_rad = 0.0175;  // of the angle at which a back is taken for the front
constexpr std::size_t kFewestSamples = 50;
constexpr double kPaths_m[] = {0.06, 0.08, 0.11, 0.14, 0.18, 0.23, 0.3, 0.39,
                               0.5,  0.65, 0.85, 1.1,  1.4,  1.8,  2.4};
constexpr std::size_t kPaths = std::size(kPaths_m);

enum Part { common, view, own, kParts };
constexpr int kVariances = 2 * kParts;  // of the bias, then of the wander
using Row = Eigen::Matrix<double, kVariances, 1>;
using Normal = Eigen::Matrix<double, kVariances, kVariances>;

struct Variance {
  const char* name;
  BodyTrackerSpec::Groups BodyTrackerSpec::*member;
  const char* needs;
};
constexpr Variance kOfVariances[kVariances] = {
    {"bias_sigma_m", &BodyTrackerSpec::bias_sigma_m, "needs a truth of joint centres, which markers are not"},
    {"view_bias_sigma_m", &BodyTrackerSpec::view_bias_sigma_m, "needs sensors that look from several sides"},
    {"own_bias_sigma_m", &BodyTrackerSpec::own_bias_sigma_m, "needs several sensors and a person who moves"},
    {"wander_sigma_m", &BodyTrackerSpec::wander_sigma_m,
     "needs a truth, several sensors and a person who moves"},
    {"view_wander_sigma_m", &BodyTrackerSpec::view_wander_sigma_m,
     "needs sensors that look from several sides and a person who moves"},
    {"own_wander_sigma_m", &BodyTrackerSpec::own_wander_sigma_m,
     "needs several sensors and a person who moves"}};
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

std::size_t group_of(std::size_t joint) {
  return static_cast<std::size_t>(tracker_group_of(static_cast<Joint>(joint)));
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

double median(std::vector<double> values) {
  if (values.empty()) return kNaN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Sums of least squares, for each candidate of the wander's path.
struct Sums {
  std::array<Normal, kPaths> normal;
  std::array<Row, kPaths> right;
  Row apart = Row::Zero();  // squares of the rows if nothing of the wander were kept
  double squares = 0.0, count = 0.0;

  Sums() {
    normal.fill(Normal::Zero());
    right.fill(Row::Zero());
  }
  Sums& operator+=(const Sums& other) {
    for (std::size_t p = 0; p < kPaths; ++p) {
      normal[p] += other.normal[p];
      right[p] += other.right[p];
    }
    apart += other.apart;
    squares += other.squares;
    count += other.count;
    return *this;
  }
  // y is expected to be bias . (the bias' variances) + (still + exp(-path / wander path) moving) . (the
  // wander's).
  void add(const Vector3d& bias, const Vector3d& still, const Vector3d& moving, double path_m, double y) {
    for (std::size_t p = 0; p < kPaths; ++p) {
      Row row;
      row << bias, still + std::exp(-path_m / kPaths_m[p]) * moving;
      normal[p].noalias() += row * row.transpose();
      right[p] += y * row;
    }
    apart += (Row() << bias, still).finished().cwiseAbs2();
    squares += y * y;
    count += 1.0;
  }
};

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

// What one participant's takes say.
struct ParticipantSums {
  std::array<Sums, kTrackerGroups> products, increments;
  // Of hidden joints: the squares an axis, and what they would be if they were seen.
  std::array<double, kTrackerGroups> hidden_squares{}, hidden_count{};
  std::array<Row, kTrackerGroups> hidden_row;
  double inferred = 0.0, hidden_joints = 0.0;
  // By what share of a joint is visible, of five rays: how many are gross, of how many.
  std::array<std::array<double, 2>, kRays + 1> gross_by_share{};
  double along = 0.0, across = 0.0, rays = 0.0;
  double with_velocity = 0.0, velocities = 0.0, accelerations = 0.0;  // of errors against an exact truth
  std::vector<std::pair<double, bool>>
      backs;  // how far off the front a body is seen, and whether it is turned
  std::array<std::vector<double>, kTrackerGroups> jitter_m;

  ParticipantSums() { hidden_row.fill(Row::Zero()); }
};

// An error against the truth, or the difference of two sensors, of all joints at one instant, in the body's
// frame.
struct Observation {
  std::size_t take = 0, instant = 0;
  std::array<std::size_t, 2> sensor{};  // the second only of a difference
  std::array<double, 2> azimuth_rad{};
  bool difference = false;
  Eigen::Matrix3d body_from_world;
  std::array<Vector3d, kJointCount> error_m;
  std::array<double, kJointCount> path_m{};  // gone since the take's start
};

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
  bool has_truth() const { return take_.truth_kind != TruthKind::none; }
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

  // Where the body faces: as the truth does, else in the middle of what the sensors see, when they agree.
  std::optional<double> heading(std::size_t instant) const {
    if (has_truth()) {
      SkeletonPose pose;
      for (std::size_t j = 0; j < kJointCount; ++j)
        if (truth(instant, j).allFinite()) {
          pose.joint_in_world_m[j] = truth(instant, j);
          pose.present.set(j);
        }
      return facing(pose);
    }
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
    const double known_rad = has_truth()                          ? heading(instant).value_or(kNaN)
                             : gone_m.norm() > kWalking_m_s * 0.5 ? std::atan2(gone_m.x(), gone_m.z())
                                                                  : kNaN;
    if (!std::isfinite(known_rad)) return;
    for (std::size_t s = 0; s < poses_.size(); ++s) {
      const auto seen_rad = facing(poses_[s]);
      if (!seen_rad) continue;
      const double off_rad =
          std::abs(azimuth_of(poses_[s], known_rad, take_.world_from_sensor[s].translation_m));
      sums_.backs.emplace_back(off_rad, std::abs(wrapped(*seen_rad - known_rad)) > 0.5 * std::numbers::pi);
    }
  }

  void observe(std::size_t instant, std::vector<Observation>& found) {
    const std::optional<double> heading_rad = heading(instant);
    if (!heading_rad) return;
    const std::size_t sensors = poses_.size();
    std::vector<double> azimuth_rad(sensors, kNaN);
    std::vector<std::array<double, kJointCount>> visible(sensors);
    for (std::size_t s = 0; s < sensors; ++s) {
      const auto seen_rad = facing(poses_[s]);
      if (!seen_rad || std::abs(wrapped(*seen_rad - *heading_rad)) > 0.5 * std::numbers::pi) continue;
      azimuth_rad[s] = azimuth_of(poses_[s], *heading_rad, take_.world_from_sensor[s].translation_m);
      const SkeletonPose pose = middle(instant, sensors > 1 ? std::optional(s) : std::nullopt);
      sight_[s].set_persons(std::span(&pose, 1), take_.world_from_sensor[s]);
      for (std::size_t j = 0; j < kJointCount; ++j)
        visible[s][j] = pose.present[j] ? sight_[s].visible_share(0, static_cast<Joint>(j)) : 0.5;
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
          note_share(visible[a][j], (poses_[a].joint_in_world_m[j] - truth(instant, j)).norm());
          const Vector3d error_m = poses_[a].joint_in_world_m[j] - truth(instant, j);
          keep(o, j, error_m, is_seen(instant, a, j, visible[a][j]), is_hidden(instant, a, j, visible[a][j]),
               a);
        }
        found.push_back(o);
        continue;
      }
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
          if (visible[b][j] >= 1.0) note_share(visible[a][j], apart_m);
          if (visible[a][j] >= 1.0) note_share(visible[b][j], apart_m);
          keep(o, j, poses_[a].joint_in_world_m[j] - poses_[b].joint_in_world_m[j], a_seen && b_seen,
               one_hidden, a);
        }
        found.push_back(o);
      }
    }
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
    if (take_.truth_kind == TruthKind::markers) return;
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
    if (hidden && take_.truth_kind != TruthKind::markers) {
      const Vector3d parts = shared_parts(o, o);
      sums_.hidden_squares[group] += error_m.squaredNorm() / 3.0;
      sums_.hidden_count[group] += 1.0;
      sums_.hidden_row[group] += (Row() << parts, parts).finished();
    }
    if (!seen) return;
    o.error_m[joint] = o.body_from_world * error_m;
    if (take_.truth_kind == TruthKind::markers ||
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

// Takes the lag out of errors against an exact truth: a first-order filter errs by -lag times the speed and
// lag^2 times the acceleration.
void undo_lag(const WatchedTake& take, std::vector<Observation>& observations, ParticipantSums& sums) {
  const auto at = [&](std::size_t instant, std::size_t joint) -> const Vector3d& {
    return take.truth_m[instant * kJointCount + joint];
  };
  struct Motion {
    std::array<Vector3d, kJointCount> velocity, acceleration;  // in the body's frame
  };
  std::vector<Motion> motions(observations.size());
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

bool is_gross(const Vector3d& error_m) { return !(error_m.squaredNorm() < kGross_m * kGross_m); }

// Products of errors at two instants: they tell the bias.
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

// Half the products of two changes over one time: they tell the wander, for what stays falls out, a marker's
// distance from its joint as well.
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
          middle[o.sensor][j][axis] = median(values);
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
    most_m2[g] = changes_m2[g].empty() ? 0.0 : 30.0 * median(changes_m2[g]) / kMedianOfChi2;
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

// Least squares of the columns [first, last), whose variances are not negative: the most negative is set to 0
// until none is left. What the other columns explain is taken off first.
struct Solution {
  Row variance_m2 = Row::Zero();
  std::array<bool, kVariances> told{};
};
constexpr double kSingular = 1e-4;

// Which of the columns the data tell apart from the others; what hardly moved tells no wander.
std::array<bool, kVariances> told_apart(const Sums& sums, std::size_t path, int first, int last) {
  constexpr double kLeast = 0.04;
  const Normal& normal = sums.normal[path];
  std::array<bool, kVariances> told{};
  for (int k = first; k < last; ++k)
    told[static_cast<std::size_t>(k)] =
        normal(k, k) > 0.0 && (k < kParts || normal(k, k) > kLeast * sums.apart[k]);
  Row scale = normal.diagonal().cwiseSqrt().array().max(1e-300).matrix();
  const Eigen::SelfAdjointEigenSolver<Normal> eigen(scale.cwiseInverse().asDiagonal() * normal *
                                                    scale.cwiseInverse().asDiagonal());
  for (int k = first; k < last; ++k) {
    double blurred = 0.0;
    for (int e = 0; e < kVariances; ++e)
      if (eigen.eigenvalues()[e] < kSingular) blurred += std::pow(eigen.eigenvectors()(k, e), 2);
    if (blurred > 0.05) told[static_cast<std::size_t>(k)] = false;
  }
  return told;
}

void solve_columns(const Normal& normal, const Row& right, int first, int last, Row& variance_m2) {
  for (int k = first; k < last; ++k) variance_m2[k] = 0.0;
  const Row wanted = right - normal * variance_m2;
  std::vector<int> free;
  for (int k = first; k < last; ++k)
    if (normal(k, k) > 1e-12 * normal.diagonal().maxCoeff()) free.push_back(k);
  while (!free.empty()) {
    const auto n = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd a(n, n);
    Eigen::VectorXd b(n), scale(n);
    for (Eigen::Index i = 0; i < n; ++i)
      scale[i] = std::sqrt(normal(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(i)]));
    for (Eigen::Index i = 0; i < n; ++i) {
      b[i] = wanted[free[static_cast<std::size_t>(i)]] / scale[i];
      for (Eigen::Index k = 0; k < n; ++k)
        a(i, k) = normal(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(k)]) /
                  (scale[i] * scale[k]);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(a);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    for (Eigen::Index e = 0; e < n; ++e)
      if (eigen.eigenvalues()[e] > kSingular)
        x += eigen.eigenvectors().col(e) * eigen.eigenvectors().col(e).dot(b) / eigen.eigenvalues()[e];
    Eigen::Index worst = 0;
    if (x.minCoeff(&worst) >= 0.0) {
      for (Eigen::Index i = 0; i < n; ++i) variance_m2[free[static_cast<std::size_t>(i)]] = x[i] / scale[i];
      return;
    }
    free.erase(free.begin() + worst);
  }
}

// The wander from increments (with the bias by direction of view, which changes as a body turns).
Row wander_of(const Sums& increments, std::size_t path) {
  Row variance_m2 = Row::Zero();
  solve_columns(increments.normal[path], increments.right[path], view, kVariances, variance_m2);
  return variance_m2;
}

double misfit_of(const Sums& sums, std::size_t path, const Row& v) {
  return sums.squares - 2.0 * v.dot(sums.right[path]) + v.dot(sums.normal[path] * v);
}

Solution solve(const Sums& products, const Sums& increments, std::size_t path) {
  Solution solution;
  solution.variance_m2 = wander_of(increments, path);
  const auto wander = told_apart(increments, path, kParts, kVariances);
  solve_columns(products.normal[path], products.right[path], 0, kParts, solution.variance_m2);
  solution.told = told_apart(products, path, 0, kParts);
  for (std::size_t k = kParts; k < kVariances; ++k) solution.told[k] = wander[k];
  return solution;
}

// How much the data say of one variance beside the other columns of [first, last): the reciprocal of what
// least squares leave of it, up to a factor.
double information_of(const Normal& normal, int column, int first, int last) {
  std::vector<int> columns;
  for (int k = first; k < last; ++k)
    if (normal(k, k) > 1e-12 * normal.diagonal().maxCoeff()) columns.push_back(k);
  Eigen::MatrixXd block(columns.size(), columns.size());
  for (std::size_t a = 0; a < columns.size(); ++a)
    for (std::size_t b = 0; b < columns.size(); ++b)
      block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) =
          normal(columns[a], columns[b]) + (a == b ? 1e-9 * normal(columns[a], columns[a]) : 0.0);
  const Eigen::MatrixXd inverse = block.inverse();
  for (std::size_t a = 0; a < columns.size(); ++a)
    if (columns[a] == column)
      return 1.0 / inverse(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(a));
  return 0.0;
}

// What some participants' sums say of one parameter, NaN where nothing, and how much data say it.
struct Told {
  double value = kNaN, information = 0.0;
};

struct Estimates {
  std::array<std::array<Told, kVariances>, kTrackerGroups> sigma_m;
  std::array<Told, kTrackerGroups> jitter_m, hidden_m;
  Told visible_share, path_m, ray_ratio, lag_s, hidden_as_tracked, back_rad, exchanged;
};

// The share of a joint below which it errs as a hidden one: that which tells gross errors from others best.
void estimate_visible_share(const std::array<std::array<double, 2>, kRays + 1>& by_share, Estimates& result) {
  if (by_share.front()[1] < kFewestSamples || by_share.back()[1] < kFewestSamples) return;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t first_seen = 1; first_seen <= kRays; ++first_seen) {
    double wrong = 0.0;
    for (const bool seen : {false, true}) {
      double gross = 0.0, count = 0.0;
      for (std::size_t share = seen ? first_seen : 0; share < (seen ? kRays + 1 : first_seen); ++share) {
        gross += by_share[share][0];
        count += by_share[share][1];
      }
      wrong += gross * (1.0 - gross / count);  // squares about the mean
    }
    if (wrong >= least) continue;
    least = wrong;
    result.visible_share = {(static_cast<double>(first_seen) - 0.5) / kRays, by_share.front()[1]};
  }
}

// The back is taken for the front beyond an angle, in a share of cases.
void estimate_backs(const std::vector<std::pair<double, bool>>& backs, Estimates& result) {
  double behind = 0.0, turned = 0.0, ahead = 0.0;
  for (const auto& [off_rad, is_turned] : backs) {
    behind += off_rad > kBehind_rad ? 1.0 : 0.0;
    turned += off_rad > kBehind_rad && is_turned ? 1.0 : 0.0;
    ahead += off_rad < std::numbers::pi - kBehind_rad ? 1.0 : 0.0;
  }
  if (behind < kFewestSamples) return;
  result.exchanged = {turned / behind, behind};
  if (ahead < kFewestSamples || turned < 0.05 * behind) return;
  double least = std::numeric_limits<double>::infinity();
  for (double angle_rad = kFirstBack_rad; angle_rad < kBehind_rad; angle_rad += 0.25 * kResolution_rad) {
    double wrong = 0.0;
    for (const auto& [off_rad, is_turned] : backs)
      wrong += std::pow((is_turned ? 1.0 : 0.0) - (off_rad > angle_rad ? turned / behind : 0.0), 2);
    if (wrong < least) {
      least = wrong;
      result.back_rad = {angle_rad, behind};
    }
  }
}

Estimates estimate(std::span<const ParticipantSums* const> participants) {
  Estimates result;
  std::array<Sums, kTrackerGroups> products, increments;
  ParticipantSums all;
  for (const ParticipantSums* p : participants) {
    for (std::size_t g = 0; g < kTrackerGroups; ++g) {
      products[g] += p->products[g];
      increments[g] += p->increments[g];
      all.hidden_squares[g] += p->hidden_squares[g];
      all.hidden_count[g] += p->hidden_count[g];
      all.hidden_row[g] += p->hidden_row[g];
      all.jitter_m[g].insert(all.jitter_m[g].end(), p->jitter_m[g].begin(), p->jitter_m[g].end());
    }
    all.inferred += p->inferred;
    for (std::size_t share = 0; share <= kRays; ++share)
      for (std::size_t k = 0; k < 2; ++k) all.gross_by_share[share][k] += p->gross_by_share[share][k];
    all.hidden_joints += p->hidden_joints;
    all.along += p->along;
    all.across += p->across;
    all.rays += p->rays;
    all.with_velocity += p->with_velocity;
    all.velocities += p->velocities;
    all.accelerations += p->accelerations;
    all.backs.insert(all.backs.end(), p->backs.begin(), p->backs.end());
  }
  // The path that explains all groups best, between the candidates by a parabola.
  std::array<double, kPaths> misfit{};
  double changes = 0.0;
  for (const Sums& sums : increments) {
    changes += sums.count;
    for (std::size_t p = 0; sums.count > 0.0 && p < kPaths; ++p)
      misfit[p] += sums.count * std::log(std::max(misfit_of(sums, p, wander_of(sums, p)), 1e-30));
  }
  const auto best = static_cast<std::size_t>(std::min_element(misfit.begin(), misfit.end()) - misfit.begin());
  bool moves = false;
  std::array<Solution, kTrackerGroups> solutions;
  for (std::size_t g = 0; g < kTrackerGroups; ++g) {
    if (products[g].count + increments[g].count < kFewestSamples) continue;
    solutions[g] = solve(products[g], increments[g], best);
    for (int k = 0; k < kVariances; ++k)
      if (solutions[g].told[static_cast<std::size_t>(k)]) {
        result.sigma_m[g][static_cast<std::size_t>(k)] = {
            std::sqrt(solutions[g].variance_m2[k]),
            k < kParts ? information_of(products[g].normal[best], k, 0, kParts)
                       : information_of(increments[g].normal[best], k, view, kVariances)};
        moves |= k >= kParts && solutions[g].variance_m2[k] > 0.0;
      }
  }
  if (moves && best > 0 && best + 1 < kPaths) {
    const double before = misfit[best - 1], at = misfit[best], after = misfit[best + 1];
    const double shift = 0.5 * (before - after) / (before - 2.0 * at + after);
    result.path_m = {kPaths_m[best] * std::pow(kPaths_m[best + 1] / kPaths_m[best], shift), changes};
  }
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    if (const auto n = static_cast<double>(all.jitter_m[g].size()); n > 0.0)
      result.jitter_m[g] = {std::accumulate(all.jitter_m[g].begin(), all.jitter_m[g].end(), 0.0) / n, n};
  for (std::size_t g = 0; g < kTrackerGroups; ++g)
    if (const double n = all.hidden_count[g]; n >= kFewestSamples)
      result.hidden_m[g] = {
          std::sqrt(
              std::max(0.0, (all.hidden_squares[g] - all.hidden_row[g].dot(solutions[g].variance_m2)) / n)),
          n};
  if (all.hidden_joints >= kFewestSamples)
    result.hidden_as_tracked = {1.0 - all.inferred / all.hidden_joints, all.hidden_joints};
  if (all.rays >= kFewestSamples) result.ray_ratio = {std::sqrt(all.along / all.across), all.rays};
  if (all.velocities > 0.01 * kFewestSamples) {
    // A first-order filter of w rad/s errs by lag / (1 + (w lag)^2) times the speed.
    const double late_s = all.with_velocity / all.velocities;
    result.lag_s = {late_s * (1.0 + late_s * late_s * all.accelerations / all.velocities), all.velocities};
  }
  estimate_visible_share(all.gross_by_share, result);
  estimate_backs(all.backs, result);
  return result;
}

// Value and interval of one parameter from all participants and from all but each. What a participant adds to
// the information says whether they count: degrees of freedom are of so many as would say as much in equal
// parts.
std::optional<MeasuredParameter> with_interval(const Told& whole, const std::vector<Told>& without,
                                               double most, double least_half) {
  if (!std::isfinite(whole.value)) return std::nullopt;
  MeasuredParameter m{.name = {}, .group = {}, .value = whole.value};
  std::vector<double> pieces;
  double sum = 0.0, squares = 0.0;
  for (const Told& one : without) {
    const double added = whole.information - one.information;
    if (added < 0.01 * whole.information / static_cast<double>(without.size())) continue;
    sum += added;
    squares += added * added;
    ++m.participants;
    if (std::isfinite(one.value)) pieces.push_back(one.value);
  }
  const auto equal_parts = static_cast<std::size_t>(squares > 0.0 ? std::lround(sum * sum / squares) : 0);
  if (pieces.size() < 3 || pieces.size() < m.participants || equal_parts < 2) return m;
  const auto n = static_cast<double>(pieces.size());
  const double mean = std::accumulate(pieces.begin(), pieces.end(), 0.0) / n;
  double spread = 0.0;
  for (const double piece : pieces) spread += std::pow(piece - mean, 2);
  const double half =
      std::max(least_half, student_quantile(equal_parts - 1) * std::sqrt((n - 1.0) / n * spread));
  m.low = std::max(0.0, m.value - half);
  m.high = std::min(most, m.value + half);
  return m;
}

}  // namespace

std::array<double, kTrackerGroups> resting_jitter_m(std::span<const double> time_s,
                                                    std::span<const ObservedBody> bodies) {
  constexpr std::size_t kAround = 8;  // frames to each side in which a joint rests
  constexpr float kRests_m = 0.004f;
  constexpr double kMadToSigma = 1.4826;
  std::array<std::vector<double>, kTrackerGroups> changes_m;
  for (std::size_t i = kAround; i + kAround < bodies.size(); ++i) {
    const double period_s = time_s[i + 1] - time_s[i];
    if (std::abs(period_s - (time_s[i] - time_s[i - 1])) > 0.2 * period_s) continue;
    for (std::size_t j = 0; j < kJointCount; ++j) {
      const auto at = [&](std::size_t k) -> const Eigen::Vector3f& { return bodies[k].joint_in_sensor_m[j]; };
      bool rests = true;
      for (std::size_t k = i - kAround; rests && k <= i + kAround; ++k)
        rests = bodies[k].state[j] == TrackingState::tracked;
      if (!rests || (at(i + kAround) - at(i - kAround)).norm() > kRests_m) continue;
      const Eigen::Vector3f change = at(i + 1) - 2.0f * at(i) + at(i - 1);
      for (int axis = 0; axis < 3; ++axis)
        changes_m[group_of(j)].push_back(std::abs(static_cast<double>(change[axis])));
    }
  }
  std::array<double, kTrackerGroups> jitter_m;
  for (std::size_t g = 0; g < kTrackerGroups; ++g) {
    jitter_m[g] = kNaN;
    if (changes_m[g].size() < kFewestSamples) continue;
    const double most_m = 5.0 * kMadToSigma * median(changes_m[g]);  // beyond, it jumped
    double squares = 0.0, count = 0.0;
    for (const double change_m : changes_m[g])
      if (change_m <= most_m) {
        squares += change_m * change_m;
        count += 1.0;
      }
    jitter_m[g] = std::sqrt(squares / count / 6.0);
  }
  return jitter_m;
}

TrackerMeasurement measure_tracker(std::span<const WatchedTake> takes) {
  std::map<std::string, std::map<std::string, std::vector<std::size_t>>> rigs;  // of each participant
  for (std::size_t t = 0; t < takes.size(); ++t) rigs[takes[t].participant][takes[t].rig].push_back(t);
  std::vector<ParticipantSums> sums;
  for (const auto& [participant, of_rig] : rigs) {
    ParticipantSums& mine = sums.emplace_back();
    for (const auto& [rig, numbers] : of_rig) {
      std::size_t expected = 0;
      for (const std::size_t t : numbers) {
        const std::size_t sensors = takes[t].world_from_sensor.size();
        const bool differs = takes[t].truth_kind == TruthKind::none;
        expected += takes[t].bodies.instants() * (differs ? sensors * (sensors - 1) / 2 : sensors);
      }
      const std::size_t stride = std::max<std::size_t>(1, expected / kMostPerRig);
      std::vector<Observation> together;
      for (const std::size_t t : numbers) {
        for (std::size_t g = 0; g < kTrackerGroups; ++g)
          if (std::isfinite(takes[t].jitter_m[g])) mine.jitter_m[g].push_back(takes[t].jitter_m[g]);
        std::vector<Observation> seen = TakeView(takes[t], t, mine).observations(stride);
        if (takes[t].truth_kind == TruthKind::exact) undo_lag(takes[t], seen, mine);
        add_increments(seen, takes[t], mine);
        if (takes[t].truth_kind != TruthKind::markers)
          together.insert(together.end(), seen.begin(), seen.end());
      }
      add_products(together, mine);
    }
  }
  std::vector<const ParticipantSums*> all;
  for (const ParticipantSums& one : sums) all.push_back(&one);
  const Estimates whole = estimate(all);
  std::vector<Estimates> without;
  for (std::size_t p = 0; all.size() >= 3 && p < all.size(); ++p) {
    std::vector<const ParticipantSums*> rest = all;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(p));
    without.push_back(estimate(rest));
  }

  TrackerMeasurement result{.spec = default_body_tracker(), .measured = {}, .untold = {}};
  const auto told = [&](const char* name, std::string_view group, const auto& member_of,
                        double most = kUnlimited, double least_half = 0.0) {
    std::vector<Told> pieces;
    for (const Estimates& one : without) pieces.push_back(member_of(one));
    auto m = with_interval(member_of(whole), pieces, most, least_half);
    if (!m) return false;
    m->name = name;
    m->group = group;
    m->participants = without.empty() ? sums.size() : m->participants;
    result.measured.push_back(*m);
    return true;
  };
  const auto of_groups = [&](const char* name, BodyTrackerSpec::Groups BodyTrackerSpec::*member,
                             const auto& told_of, const char* why) {
    bool any = false;
    for (std::size_t g = 0; g < kTrackerGroups; ++g)
      if (told(name, name_of(static_cast<TrackerGroup>(g)),
               [&](const Estimates& e) { return told_of(e, g); })) {
        (result.spec.*member)[g] = result.measured.back().value;
        any = true;
      }
    if (!any) result.untold.push_back({name, why});
  };
  const auto value = [&](const char* name, double BodyTrackerSpec::*member, Told Estimates::*estimate,
                         double most, const char* why, double least_half = 0.0) {
    if (told(
            name, "", [&](const Estimates& e) { return e.*estimate; }, most, least_half))
      result.spec.*member = result.measured.back().value;
    else
      result.untold.push_back({name, why});
  };
  for (std::size_t k = 0; k < kVariances; ++k)
    of_groups(
        kOfVariances[k].name, kOfVariances[k].member,
        [&](const Estimates& e, std::size_t g) { return e.sigma_m[g][k]; }, kOfVariances[k].needs);
  of_groups(
      "jitter_sigma_m", &BodyTrackerSpec::jitter_sigma_m,
      [](const Estimates& e, std::size_t g) { return e.jitter_m[g]; },
      "needs joints that rest for half a second");
  of_groups(
      "inferred_error_sigma_m", &BodyTrackerSpec::inferred_error_sigma_m,
      [](const Estimates& e, std::size_t g) { return e.hidden_m[g]; },
      "needs joints that one sensor cannot see, and a truth or another sensor that sees them");
  value("wander_path_m", &BodyTrackerSpec::wander_path_m, &Estimates::path_m, kUnlimited,
        "needs joints that move by more than their errors keep");
  value("ray_ratio", &BodyTrackerSpec::ray_ratio, &Estimates::ray_ratio, kUnlimited,
        "needs an exact truth, or two sensors that look from one side");
  value("lag_s", &BodyTrackerSpec::lag_s, &Estimates::lag_s, kUnlimited,
        "needs a truth whose clock was not set by the motion");
  value("least_visible_share", &BodyTrackerSpec::least_visible_share, &Estimates::visible_share, 1.0,
        "needs joints that one sensor cannot see, and a truth or another sensor that sees them", 0.5 / kRays);
  value("hidden_as_tracked_share", &BodyTrackerSpec::hidden_as_tracked_share, &Estimates::hidden_as_tracked,
        1.0, "needs tracking states and a truth");
  value("back_view_angle_rad", &BodyTrackerSpec::back_view_angle_rad, &Estimates::back_rad, std::numbers::pi,
        "needs a person who is seen from all sides", kResolution_rad);
  value("exchanged_share", &BodyTrackerSpec::exchanged_share, &Estimates::exchanged, 1.0,
        "needs a person who is seen from behind");
  for (const char* name :
       {"jump_rate_per_minute", "jump_size_m", "jump_duration_s", "identity_changes_per_minute"})
    result.untold.push_back({name, "is not measured"});
  result.untold.push_back({"unit_depth_share", "is part of own_bias_sigma_m"});
  return result;
}

}  // namespace trilat
