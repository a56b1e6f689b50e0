// SPDX-License-Identifier: MIT
#include "pipeline/stream_fit/rig_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "datasets/base/median.h"
#include "evaluators/solvers/point_estimate.h"
#include "pipeline/stream_fit/stream_change.h"

namespace trilat {
namespace {

constexpr std::size_t kMaxLooks = 100;              // instants at which rigs are compared
constexpr std::size_t kMinRigPairs = 100;           // points of two sensors; fewer decide nothing
constexpr std::size_t kMaxAllOrders = 5;            // sensors of which every order of poses is tried
constexpr double kExplainedShareOfAgreeing = 0.25;  // trackers' errors about one who stands fit a third
constexpr double kExplainedShare = 0.5;             // of the distances that a change may leave
constexpr double kMinDistances = 0.04;              // of a scale

// Orders of the poses: of few sensors all, of more those that exchange two or pass three on in a circle.
std::vector<std::vector<std::size_t>> orders_of_poses(std::size_t count) {
  std::vector<std::vector<std::size_t>> orders;
  std::vector<std::size_t> order = same_order(count);
  if (count <= kMaxAllOrders) {
    while (std::ranges::next_permutation(order).found) orders.push_back(order);
    // those that move fewest first
    std::ranges::stable_sort(orders, {}, [](const std::vector<std::size_t>& o) {
      std::size_t moved = 0;
      for (std::size_t s = 0; s < o.size(); ++s) moved += o[s] == s ? 0 : 1;
      return moved;
    });
    return orders;
  }
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b)
      for (std::size_t c = 0; c < count; ++c) {
        if (a == b || a == c || b < a || c < a || (b == c && b < a)) continue;
        order = same_order(count);
        order[a] = b;
        order[b] = c == b ? a : c;
        if (c != b) order[c] = a;
        orders.push_back(order);
      }
  return orders;
}

// Other conventions of the poses, each also with the camera's axes of OpenCV and of OpenGL.
std::vector<RigChange> changes_of_convention(std::size_t sensors) {
  using Inverse = PoseConvention::Inverse;
  std::vector<RigChange> changes;
  for (const Eigen::Vector3d& axes :
       {Eigen::Vector3d(1.0, 1.0, 1.0), Eigen::Vector3d(-1.0, -1.0, 1.0), Eigen::Vector3d(-1.0, 1.0, -1.0)})
    for (const bool w_first : {false, true})
      for (const Inverse inverse : {Inverse::none, Inverse::pose, Inverse::rotation})
        if (const PoseConvention convention{w_first, inverse}; !convention.is_ours())
          changes.push_back({same_order(sensors), axes.asDiagonal().toDenseMatrix(), 1.0, convention});
  changes.push_back({same_order(sensors), Eigen::Matrix3d::Identity(), 1.0, {.bodies_in_world = true}});
  return changes;
}

}  // namespace

RigidTransform PoseConvention::meant(const RigidTransform& read) const {
  if (bodies_in_world) return {};
  RigidTransform pose = read;
  const Eigen::Quaterniond& q = read.rotation;
  if (w_first) pose.rotation = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
  if (inverse == Inverse::pose) return pose.inverse();
  if (inverse == Inverse::rotation) pose.rotation = pose.rotation.conjugate();
  return pose;
}

std::vector<std::size_t> same_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

RigLooks::RigLooks(const std::vector<SensorStream>& sensors, const std::optional<UprightPoints>& upright)
    : sensors_(sensors), upright_(upright), looks_(sensors.size()) {
  const PointStream& first = sensors.front().in_sensor;
  const std::size_t step = std::max<std::size_t>(1, first.instants() / kMaxLooks);
  for (std::size_t s = 0; s < sensors.size(); ++s)
    for (std::size_t i = 0; i < first.instants(); i += step)
      for (std::size_t j = 0; j < first.points; ++j) looks_[s].push_back(sensors[s].in_sensor.at(i, j));
}

bool RigLooks::sees_any(std::size_t sensor) const {
  return std::ranges::any_of(looks_[sensor], [](const Eigen::Vector3d& at_m) { return at_m.allFinite(); });
}

RigidTransform RigLooks::pose_of(std::size_t sensor, const RigChange& change) const {
  return change.convention.meant(sensors_[change.pose_of[sensor]].world_from_sensor);
}

double RigLooks::distance_m(const RigChange& change) const {
  std::vector<std::vector<Eigen::Vector3d>> placed(sensors_.size());
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    const RigidTransform pose = pose_of(s, change);
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix() * change.axes;
    const Eigen::Vector3d position_m = pose.translation_m / change.distances;
    for (const Eigen::Vector3d& at_m : looks_[s]) placed[s].push_back(rotation * at_m + position_m);
  }
  double sum_m = 0.0, pairs = 0.0;
  std::vector<double> distances_m;
  for (std::size_t a = 0; a < placed.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      distances_m.clear();
      for (std::size_t k = 0; k < placed[a].size(); ++k)
        if (const double m = (placed[a][k] - placed[b][k]).norm(); std::isfinite(m)) distances_m.push_back(m);
      if (distances_m.size() < kMinRigPairs) continue;
      sum_m += median(distances_m);
      pairs += 1.0;
    }
  return pairs > 0.0 ? sum_m / pairs : kNaN;
}

double RigLooks::height_m(const RigChange& change) const {
  if (!upright_) return kNaN;
  const std::size_t points = sensors_.front().in_sensor.points;
  double sum_m = 0.0, count = 0.0;
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    const RigidTransform pose = pose_of(s, change);
    for (std::size_t k = 0; k < looks_[s].size(); k += points) {
      const Eigen::Vector3d between_m = looks_[s][k + upright_->high] - looks_[s][k + upright_->low];
      if (!between_m.allFinite()) continue;
      sum_m += (pose.rotation * (change.axes * between_m)).y();
      count += 1.0;
    }
  }
  return sum_m / count;
}

// The scale of the distances between sensors under which they agree best: units of length, then near 1.
double RigLooks::best_distances() const {
  constexpr std::array kFactors{1000.0, 100.0, 10.0, 0.1, 0.01, 0.001};
  double best = 1.0, least_m = HUGE_VAL;
  const auto look_at = [&](double factor) {
    const RigChange scaled{same_order(sensors_.size()), Eigen::Matrix3d::Identity(), factor};
    if (const double m = distance_m(scaled); m < least_m) {
      least_m = m;
      best = factor;
    }
  };
  look_at(1.0);
  for (const double factor : kFactors) look_at(factor);
  for (double factor = 0.5; factor < 2.0; factor *= 1.04) look_at(factor);
  for (double step = 0.02; step > 0.001; step *= 0.5)
    for (const double factor : {best * (1.0 + step), best / (1.0 + step)}) look_at(factor);
  return best;
}

std::optional<RigChange> RigLooks::change_of_all(bool all_agree) const {
  const RigChange as_stated{same_order(sensors_.size())};
  const double before_m = distance_m(as_stated);
  const bool is_upside_down = height_m(as_stated) < kUpsideDown_m;
  std::optional<RigChange> best;
  constexpr double kNoWorse = 1.1;
  double least_m = (!all_agree       ? kExplainedShare
                    : is_upside_down ? kNoWorse
                                     : kExplainedShareOfAgreeing) *
                   before_m;
  // a later one must leave clearly less
  constexpr double kClearly = 0.8;
  const auto look_at = [&](const RigChange& change) {
    const double high_m = height_m(change);
    if (is_upside_down ? !(high_m > -kUpsideDown_m) : high_m < kUpsideDown_m) return;
    const double left_m = distance_m(change);
    if (!(left_m < kSensorsAgree_m) || !(left_m < (best ? kClearly : 1.0) * least_m)) return;
    best = change;
    least_m = left_m;
  };
  const std::vector<std::size_t> same = same_order(sensors_.size());
  // those that change one sign first: other axes agree as well where all sensors stand level
  for (const int axis : {0, 1}) {
    RigChange one_sign{same};
    one_sign.axes(axis, axis) = -1.0;
    look_at(one_sign);
  }
  for (const bool mirrored : {true, false})
    for (const Eigen::Matrix3d& axes : signed_axes(mirrored)) look_at({same, axes});
  for (const std::vector<std::size_t>& order : orders_of_poses(sensors_.size())) look_at({order});
  for (const RigChange& change : changes_of_convention(sensors_.size())) look_at(change);
  if (const RigChange scaled{same, Eigen::Matrix3d::Identity(), best_distances()};
      std::abs(std::log(scaled.distances)) > std::log1p(kMinDistances))
    look_at(scaled);
  return best;
}

}  // namespace trilat
