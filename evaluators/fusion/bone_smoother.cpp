// SPDX-License-Identifier: MIT
#include "evaluators/fusion/bone_smoother.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/fusion/kalman.h"

namespace trilat {
namespace {

void check(const BodyPath& path) {
  TRILAT_CHECK(path.sensors <= kMaxSensors, "a rig has at most kMaxSensors sensors");
  for (std::size_t i = 1; i < path.time_ns.size(); ++i)
    TRILAT_CHECK(path.time_ns[i] > path.time_ns[i - 1], "times rise");
  for (std::size_t j = 0; j < path.joints.size(); ++j)
    TRILAT_CHECK(std::ranges::count(path.joints, path.joints[j]) == 1, "every joint is listed once");
}

bool is_seen(const JointObservation& o) { return o.seen && o.point_in_world_m.allFinite(); }

class BoneSmoother {
 public:
  BoneSmoother(const BodyPath& path, const BoneSmootherOptions& options)
      : path_(path),
        options_(options),
        joints_(path.joints.size()),
        position_m_(path.time_ns.size() * joints_),
        moved_m_(position_m_.size()),
        farthest_m_(joints_, std::numeric_limits<double>::infinity()),
        filter_(options.acceleration_density_m2_s3, path.time_ns.size()) {
    for (std::size_t j = 0; j < joints_; ++j) start(j);
    find_bones();
    for (const Joint joint : kJointsRootFirst) {
      const auto found = std::ranges::find(path.joints, joint);
      if (found != path.joints.end()) order_.push_back(static_cast<std::size_t>(found - path.joints.begin()));
    }
  }

  SmoothedBody solve() {
    int passes = 0;
    while (passes < options_.max_iterations &&
           std::ranges::any_of(order_, [&](std::size_t j) { return is_unsettled(j); })) {
      for (const std::size_t j : order_)
        if (is_unsettled(j)) farthest_m_[j] = smooth(j);
      ++passes;
      std::ranges::reverse(order_);  // out to the hands, and back
    }
    SmoothedBody body{std::move(position_m_), {}, passes, std::move(bones_)};
    for (std::size_t slot = 0; slot < moved_m_.size(); ++slot) {
      const bool is_settled = moved_m_[slot] <= options_.step_tolerance_m;
      body.status.push_back(!body.position_m[slot].allFinite() ? SolveStatus::no_observation
                            : is_settled                       ? SolveStatus::converged
                                                               : SolveStatus::iteration_limit);
    }
    return body;
  }

 private:
  struct Neighbour {
    std::size_t joint = 0;
    double length_m = 0.0;
  };

  // Whether the joint, or one that a bone joins to it, moved by more than the tolerance when last smoothed.
  bool is_unsettled(std::size_t j) const {
    const auto moved = [&](std::size_t joint) { return farthest_m_[joint] > options_.step_tolerance_m; };
    return moved(j) || std::ranges::any_of(neighbours_[j], moved, &Neighbour::joint);
  }
  std::span<const JointObservation> seen(std::size_t i, std::size_t j) {
    const std::span<JointObservation> all(seen_.data(), path_.sensors);
    path_.observe(i, j, all);
    return all;
  }
  Eigen::Vector3d& at(std::size_t i, std::size_t j) { return position_m_[i * joints_ + j]; }
  bool has(std::size_t i, std::size_t j) { return at(i, j).allFinite(); }

  // Starts the joint at its own smoothed path, found without a gate.
  void start(std::size_t j) {
    const KalmanOptions smoother{.sigma_m = options_.sigma_m,
                                 .inferred_factor = options_.inferred_factor,
                                 .acceleration_density_m2_s3 = options_.acceleration_density_m2_s3,
                                 .speed_sigma_m_s = options_.speed_sigma_m_s,
                                 .gate_sigma = std::numeric_limits<double>::infinity(),
                                 .longest_gap_s = options_.longest_gap_s,
                                 .smooth = true};
    const JointPath joint{path_.time_ns, path_.sensors, [&](std::size_t i, std::span<JointObservation> seen) {
                            path_.observe(i, j, seen);
                          }};
    const std::vector<PointEstimate> estimates = solve_kalman(joint, smoother);
    for (std::size_t i = 0; i < estimates.size(); ++i) at(i, j) = estimates[i].position_m;
  }

  void find_bones() {
    neighbours_.resize(joints_);
    const auto is_tracked = [&](std::size_t i, std::size_t j) {
      return std::ranges::any_of(seen(i, j), [](const JointObservation& o) {
        return is_seen(o) && o.state == TrackingState::tracked;
      });
    };
    for (std::size_t child = 0; child < joints_; ++child) {
      const auto parent_joint = parent_of(path_.joints[child]);
      if (!parent_joint) continue;
      const auto found = std::ranges::find(path_.joints, *parent_joint);
      if (found == path_.joints.end()) continue;
      const auto parent = static_cast<std::size_t>(found - path_.joints.begin());
      std::vector<double> lengths_m;
      for (std::size_t i = 0; i < path_.time_ns.size(); ++i)
        if (is_tracked(i, parent) && is_tracked(i, child))
          lengths_m.push_back((at(i, child) - at(i, parent)).norm());
      if (lengths_m.empty()) continue;
      bones_.push_back({parent, child, median(lengths_m)});
      neighbours_[parent].push_back({child, bones_.back().length_m});
      neighbours_[child].push_back({parent, bones_.back().length_m});
    }
  }

  // The information of sensors and bones on a joint at an instant, linearised at its present position.
  PositionInformation measured(std::size_t i, std::size_t j) {
    PositionInformation information;
    const Eigen::Vector3d x_m = at(i, j);
    for (const JointObservation& o : seen(i, j)) {
      if (!is_seen(o)) continue;
      const double factor = o.state == TrackingState::tracked ? 1.0 : options_.inferred_factor;
      const double sigma_m = factor * options_.sigma_m, scale_m = factor * options_.loss_scale_m;
      const double far2 = (x_m - o.point_in_world_m).squaredNorm() / (scale_m * scale_m);
      information.add_point(o.point_in_world_m, 1.0 / ((1.0 + far2) * sigma_m * sigma_m));
    }
    for (const Neighbour& bone : neighbours_[j]) {
      const Eigen::Vector3d& other_m = at(i, bone.joint);
      const double distance_m = (x_m - other_m).norm();
      // Joints in one place have no direction; nor has one whose neighbour is not there, which is NaN.
      if (!(distance_m > 1e-12)) continue;
      const Eigen::Vector3d direction = (x_m - other_m) / distance_m;
      const double weight = 1.0 / (options_.bone_sigma_m * options_.bone_sigma_m);
      // Across a bone that is too long its length pulls straight: the positive part of the Hessian, without
      // which a joint that nothing else holds swings from side to side.
      const double across = std::max(0.0, 1.0 - bone.length_m / distance_m);
      information.add_point(other_m + bone.length_m * direction, across * weight);
      information.add_distance(direction, direction.dot(other_m) + bone.length_m, (1.0 - across) * weight);
    }
    return information;
  }

  // Smooths all stretches of a joint's path. Returns the largest distance, in metres, that it moved.
  double smooth(std::size_t j) {
    double farthest_m = 0.0;
    for (std::size_t first = 0; first < path_.time_ns.size(); ++first) {
      std::size_t last = first;
      while (last < path_.time_ns.size() && has(last, j)) ++last;
      if (last == first) continue;
      farthest_m = std::max(farthest_m, smooth(j, first, last));
      first = last;
    }
    return farthest_m;
  }

  double smooth(std::size_t j, std::size_t first, std::size_t last) {
    constexpr double kAnywhere_m2 = 100.0;  // hardly holds a joint where it is
    filter_.begin(
        MotionState::at(at(first, j), kAnywhere_m2, options_.speed_sigma_m_s * options_.speed_sigma_m_s));
    for (std::size_t i = first; i < last; ++i) {
      if (i > first) filter_.predict(static_cast<double>(path_.time_ns[i] - path_.time_ns[i - 1]) * 1e-9);
      filter_.update(measured(i, j));
    }
    double farthest_m = 0.0;
    filter_.smooth(last - first, false, [&](std::size_t k, const MotionState& state) {
      Eigen::Vector3d& position_m = at(first + k, j);
      const double moved_m = (state.mean.head<3>() - position_m).norm();
      moved_m_[(first + k) * joints_ + j] = moved_m;
      farthest_m = std::max(farthest_m, moved_m);
      position_m = state.mean.head<3>();
    });
    return farthest_m;
  }

  const BodyPath& path_;
  const BoneSmootherOptions& options_;
  std::size_t joints_;
  std::vector<Eigen::Vector3d> position_m_;  // by instant and joint, NaN where there is no path
  std::vector<double> moved_m_;              // when it was last smoothed
  std::vector<double> farthest_m_;           // of each joint, when it was last smoothed
  std::vector<MedianBone> bones_;
  std::vector<std::vector<Neighbour>> neighbours_;  // by joint
  std::vector<std::size_t> order_;                  // of the joints in the next pass
  MotionFilter filter_;
  std::array<JointObservation, kMaxSensors> seen_;
};

}  // namespace

SmoothedBody smooth_bones(const BodyPath& path, const BoneSmootherOptions& options) {
  check(path);
  return BoneSmoother(path, options).solve();
}

}  // namespace trilat
