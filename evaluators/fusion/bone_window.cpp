// SPDX-License-Identifier: MIT
#include "evaluators/fusion/bone_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/fusion/kalman.h"

namespace trilat {
namespace {

bool is_seen(const JointObservation& o) { return o.seen && o.point_in_world_m.allFinite(); }

void check(const BodyPath& path) {
  TRILAT_CHECK(path.sensors <= kMaxSensors, "a rig has at most kMaxSensors sensors");
  for (std::size_t i = 1; i < path.time_ns.size(); ++i)
    TRILAT_CHECK(path.time_ns[i] > path.time_ns[i - 1], "times rise");
  for (std::size_t j = 0; j < path.joints.size(); ++j)
    TRILAT_CHECK(std::ranges::count(path.joints, path.joints[j]) == 1, "every joint is listed once");
}

bool is_tracked(const JointObservation& o) { return is_seen(o) && o.state == TrackingState::tracked; }

// Each joint by itself, by instant and joint.
struct Smoothed {
  std::vector<Eigen::Vector3d> position_m;
  std::vector<bool> tracked;  // by some sensor
};
Smoothed smoothed(const BodyPath& path, const BoneWindowOptions& options) {
  const std::size_t instants = path.time_ns.size(), joints = path.joints.size();
  KalmanOptions smoother;
  smoother.sigma_m = options.sigma_m;
  smoother.inferred_factor = options.inferred_factor;
  smoother.acceleration_density_m2_s3 = options.acceleration_density_m2_s3;
  smoother.speed_sigma_m_s = options.speed_sigma_m_s;
  smoother.longest_gap_s = options.longest_gap_s;
  smoother.gate_sigma = std::numeric_limits<double>::infinity();
  smoother.smooth = true;
  Smoothed all{std::vector<Eigen::Vector3d>(instants * joints), std::vector<bool>(instants * joints)};
  for (std::size_t j = 0; j < joints; ++j) {
    const JointPath joint{path.time_ns, path.sensors, [&](std::size_t i, std::span<JointObservation> seen) {
                            path.observe(i, j, seen);
                            all.tracked[i * joints + j] = std::ranges::any_of(seen, is_tracked);
                          }};
    const std::vector<PointEstimate> estimates = solve_kalman(joint, smoother);
    for (std::size_t i = 0; i < instants; ++i) all.position_m[i * joints + j] = estimates[i].position_m;
  }
  return all;
}

std::vector<MedianBone> bones_of(const BodyPath& path, const Smoothed& smoothed) {
  std::vector<MedianBone> bones;
  for (std::size_t child = 0; child < path.joints.size(); ++child) {
    const auto parent_joint = parent_of(path.joints[child]);
    if (!parent_joint) continue;
    const auto found = std::ranges::find(path.joints, *parent_joint);
    if (found == path.joints.end()) continue;
    const auto parent = static_cast<std::size_t>(found - path.joints.begin());
    std::vector<double> lengths_m;
    for (std::size_t first = 0; first < smoothed.tracked.size(); first += path.joints.size())
      if (smoothed.tracked[first + parent] && smoothed.tracked[first + child])
        lengths_m.push_back(
            (smoothed.position_m[first + child] - smoothed.position_m[first + parent]).norm());
    if (!lengths_m.empty()) bones.push_back({parent, child, median(lengths_m)});
  }
  return bones;
}

std::vector<TimeWindow> windows_of(std::span<const std::int64_t> time_ns, double window_s) {
  std::vector<TimeWindow> windows;
  if (time_ns.empty()) return windows;
  // The first instant at or after so many quarters of a window.
  const auto instant_at = [&](std::size_t quarters) {
    const double after_ns = 0.25e9 * window_s * static_cast<double>(quarters);
    const auto found = std::ranges::lower_bound(
        time_ns, after_ns, {}, [&](std::int64_t t) { return static_cast<double>(t - time_ns.front()); });
    return static_cast<std::size_t>(found - time_ns.begin());
  };
  for (std::size_t k = 0; windows.empty() || windows.back().last < time_ns.size(); ++k)
    windows.push_back(
        {instant_at(2 * k), instant_at(2 * k + 4), instant_at(2 * k + 1), instant_at(2 * k + 3)});
  // Windows shorter than the time between two instants may hold none.
  std::erase_if(windows, [](const TimeWindow& window) { return window.first == window.last; });
  windows.front().answer_first = 0;
  windows.back().answer_last = time_ns.size();
  return windows;
}

constexpr double kFirstRadius = 1e8;  // the start is good: nearly Gauss-Newton

// Per axis, of a step driven by white acceleration of spectral density q, whose covariance is Q = q [dt^3/3
// dt^2/2; dt^2/2 dt]: the error (later - F before), F = [1 dt; 0 1], weighs by Q^-1.
struct Step {
  Eigen::Matrix2d information, later_before, before;  // Q^-1, -Q^-1 F, F^T Q^-1 F
  Step(double dt_s, double density_m2_s3) {
    Eigen::Matrix2d predict;
    predict << 1.0, dt_s, 0.0, 1.0;
    information << 12.0 / (dt_s * dt_s * dt_s), -6.0 / (dt_s * dt_s), -6.0 / (dt_s * dt_s), 4.0 / dt_s;
    information /= density_m2_s3;
    later_before = -information * predict;
    before = -predict.transpose() * later_before;
  }
};

// A column an instant: of every joint three positions, then of every joint three velocities.
using Course = Eigen::ArrayXXd;

class Window {
 public:
  Window(const BodyPath& path, const BoneWindows& windows, const TimeWindow& window,
         const BoneWindowOptions& options)
      : path_(path),
        windows_(windows),
        window_(window),
        options_(options),
        instants_(static_cast<Eigen::Index>(window.last - window.first)),
        lanes_(3 * static_cast<Eigen::Index>(path.joints.size())),
        seen_((window.last - window.first) * path.joints.size() * path.sensors),
        moves_(Course::Zero(lanes_, instants_)) {
    std::size_t slot = 0;
    for (std::size_t i = window.first; i < window.last; ++i)
      for (std::size_t j = 0; j < path.joints.size(); ++j, slot += path.sensors)
        path.observe(i, j, std::span(seen_).subspan(slot, path.sensors));
    for (Eigen::Index i = 1; i < instants_; ++i) {
      steps_.emplace_back(step_s(i), options.acceleration_density_m2_s3);
      for (Eigen::Index j = 0; j < lanes_ / 3; ++j)
        if (has(i, j) && has(i - 1, j)) moves_.col(i).segment<3>(3 * j) = 1.0;
    }
  }

  std::vector<PointEstimate> solve() {
    Course x = start();
    const SolveStatus status = minimise(x);
    std::vector<PointEstimate> estimates;
    for (std::size_t i = window_.answer_first; i < window_.answer_last; ++i)
      for (Eigen::Index joint = 0; joint < lanes_ / 3; ++joint) {
        const auto instant = static_cast<Eigen::Index>(i - window_.first);
        const bool is_answered = has(instant, joint);
        PointEstimate& estimate =
            estimates.emplace_back(failed_estimate(is_answered ? status : SolveStatus::no_observation));
        if (!is_answered) continue;
        estimate.position_m = position(x, instant, joint);
        estimate.iterations = iterations_;
      }
    return estimates;
  }

 private:
  // Instants count from the window's first.
  std::size_t of_take(Eigen::Index i) const { return window_.first + static_cast<std::size_t>(i); }
  const Eigen::Vector3d& start_m(Eigen::Index i, Eigen::Index j) const {
    return windows_.start_m[of_take(i) * path_.joints.size() + static_cast<std::size_t>(j)];
  }
  bool has(Eigen::Index i, Eigen::Index j) const { return start_m(i, j).allFinite(); }
  bool moves_on(Eigen::Index i, Eigen::Index j) const { return moves_(3 * j, i) > 0.0; }
  std::span<const JointObservation> seen(Eigen::Index i, Eigen::Index j) const {
    return {&seen_[static_cast<std::size_t>(i * (lanes_ / 3) + j) * path_.sensors], path_.sensors};
  }
  double step_s(Eigen::Index i) const {
    return static_cast<double>(path_.time_ns[of_take(i)] - path_.time_ns[of_take(i) - 1]) * 1e-9;
  }
  Eigen::Vector3d position(const Course& x, Eigen::Index i, Eigen::Index j) const {
    return x.col(i).segment<3>(3 * j).matrix();
  }
  auto positions(auto& path, Eigen::Index i) const { return path.col(i).head(lanes_); }
  auto velocities(auto& path, Eigen::Index i) const { return path.col(i).tail(lanes_); }
  Course zero_course() const { return Course::Zero(2 * lanes_, instants_); }

  // The smoother's positions and, as velocities, their differences.
  Course start() const {
    Course x = zero_course();
    for (Eigen::Index i = 0; i < instants_; ++i)
      for (Eigen::Index j = 0; j < lanes_ / 3; ++j) {
        if (!has(i, j)) continue;
        x.col(i).segment<3>(3 * j) = start_m(i, j);
        auto velocity = x.col(i).segment<3>(lanes_ + 3 * j);
        if (i + 1 < instants_ && has(i + 1, j))
          velocity = (start_m(i + 1, j) - start_m(i, j)) / step_s(i + 1);
        else if (moves_on(i, j))
          velocity = x.col(i - 1).segment<3>(lanes_ + 3 * j);
      }
    return x;
  }

  // Half of the sum of the losses; with its gradient and the normal equations if they are wanted.
  double cost(const Course& x, bool equations) {
    if (equations) {
      gradient_ = zero_course();
      curvature_ = zero_course();
      position_velocity_ = across_ = Course::Zero(lanes_, instants_);
      bone_rows_ = Course::Zero(3 * static_cast<Eigen::Index>(windows_.bones.size()), instants_);
    }
    double sum = 0.0;
    for (Eigen::Index i = 0; i < instants_; ++i) {
      if (i > 0) sum += add_motion(x, i, equations);
      for (Eigen::Index j = 0; j < lanes_ / 3; ++j) {
        if (!has(i, j)) {
          if (equations)
            curvature_.col(i).segment<3>(3 * j) = curvature_.col(i).segment<3>(lanes_ + 3 * j) = 1.0;
          continue;
        }
        if (!moves_on(i, j)) sum += add_beginning(x, i, j, equations);
        for (const JointObservation& o : seen(i, j))
          if (is_seen(o)) {
            const double factor = o.state == TrackingState::tracked ? 1.0 : options_.inferred_factor;
            sum += add_value(x, i, 3 * j, o.point_in_world_m, options_.sigma_m * factor, true, equations);
          }
      }
      for (std::size_t bone = 0; bone < windows_.bones.size(); ++bone) sum += add_bone(x, i, bone, equations);
    }
    return 0.5 * sum;
  }

  double add_motion(const Course& x, Eigen::Index i, bool equations) {
    const Step& step = steps_[static_cast<std::size_t>(i - 1)];
    const auto moves = moves_.col(i);
    const Eigen::ArrayXd off =
        moves * (positions(x, i) - positions(x, i - 1) - step_s(i) * velocities(x, i - 1));
    const Eigen::ArrayXd turn = moves * (velocities(x, i) - velocities(x, i - 1));
    const Eigen::Matrix2d &q = step.information, &t = step.later_before, &b = step.before;
    const Eigen::ArrayXd pull = q(0, 0) * off + q(0, 1) * turn, pull_speed = q(1, 0) * off + q(1, 1) * turn;
    if (equations) {
      positions(gradient_, i) += pull;
      velocities(gradient_, i) += pull_speed;
      positions(gradient_, i - 1) += t(0, 0) * off + t(1, 0) * turn;
      velocities(gradient_, i - 1) += t(0, 1) * off + t(1, 1) * turn;
      positions(curvature_, i) += q(0, 0) * moves;
      velocities(curvature_, i) += q(1, 1) * moves;
      position_velocity_.col(i) += q(0, 1) * moves;
      positions(curvature_, i - 1) += b(0, 0) * moves;
      velocities(curvature_, i - 1) += b(1, 1) * moves;
      position_velocity_.col(i - 1) += b(0, 1) * moves;
    }
    return (off * pull + turn * pull_speed).sum();
  }

  // Of a joint's stretch in the window: how fast it may start and, if no sensor sees it in all of the
  // stretch, where: what the smoother knows from before and after holds it.
  double add_beginning(const Course& x, Eigen::Index i, Eigen::Index j, bool equations) {
    bool observed = false;
    for (Eigen::Index k = i; k < instants_ && has(k, j) && !observed; ++k)
      observed = std::ranges::any_of(seen(k, j), is_seen);
    const double held = observed ? 0.0
                                 : add_value(x, i, 3 * j, start_m(i, j),
                                             options_.sigma_m * options_.inferred_factor, false, equations);
    return held + add_value(x, i, lanes_ + 3 * j, Eigen::Vector3d::Zero(), options_.speed_sigma_m_s, false,
                            equations);
  }

  // (three numbers of x - value) / sigma, with Cauchy's loss where that is asked for.
  double add_value(const Course& x, Eigen::Index i, Eigen::Index at, const Eigen::Vector3d& value,
                   double sigma, bool robust, bool equations) {
    const Eigen::Vector3d off = (x.col(i).segment<3>(at).matrix() - value) / sigma;
    const double squared = off.squaredNorm(), scale = options_.loss_scale_m / options_.sigma_m;
    const bool bends = robust && std::isfinite(scale);
    const double weight = bends ? 1.0 / (1.0 + squared / (scale * scale)) : 1.0;
    if (equations) {
      gradient_.col(i).segment<3>(at) += weight / sigma * off.array();
      curvature_.col(i).segment<3>(at) += weight / (sigma * sigma);
      // the loss bends, so along the error the curvature is less; where it is negative, it counts as none
      if (bends && squared > 0.0)
        add_square(i, at, off,
                   -std::min(weight / squared, 2.0 * weight * weight / (scale * scale)) / (sigma * sigma));
    }
    return bends ? scale * scale * std::log1p(squared / (scale * scale)) : squared;
  }

  // (|child - parent| - length) / sigma.
  double add_bone(const Course& x, Eigen::Index i, std::size_t number, bool equations) {
    const MedianBone& bone = windows_.bones[number];
    const auto parent = static_cast<Eigen::Index>(bone.parent), child = static_cast<Eigen::Index>(bone.child);
    if (!has(i, parent) || !has(i, child)) return 0.0;
    const Eigen::Vector3d along_m = position(x, i, child) - position(x, i, parent);
    const double distance_m = along_m.norm();
    const double off = (distance_m - bone.length_m) / options_.bone_sigma_m;
    // Joints in one place have no direction.
    if (equations && distance_m > 1e-12) {
      const Eigen::Vector3d row = along_m / (distance_m * options_.bone_sigma_m);
      gradient_.col(i).segment<3>(3 * parent) -= off * row.array();
      gradient_.col(i).segment<3>(3 * child) += off * row.array();
      add_square(i, 3 * parent, row, 1.0);
      add_square(i, 3 * child, row, 1.0);
      bone_rows_.col(i).segment<3>(3 * static_cast<Eigen::Index>(number)) = row;
    }
    return off * off;
  }

  // factor * v v^T on a joint's position.
  void add_square(Eigen::Index i, Eigen::Index at, const Eigen::Vector3d& v, double factor) {
    curvature_.col(i).segment<3>(at) += factor * v.array().square();
    across_.col(i).segment<3>(at) += factor * Eigen::Array3d(v.y() * v.z(), v.x() * v.z(), v.x() * v.y());
  }

  // What the equations say without bones and across the axes: every coordinate a chain in time of its own, a
  // tridiagonal system of 2 x 2 blocks. Its inverse is the preconditioner.
  void factorise(double radius) {
    damped_ = curvature_ + curvature_.max(1e-6) / radius;
    inverse_ = zero_course();
    inverse_across_ = Course::Zero(lanes_, instants_);
    for (auto& row : carry_)
      for (Course& c : row) c = Course::Zero(lanes_, instants_);
    for (Eigen::Index i = 0; i < instants_; ++i) {
      Eigen::ArrayXd p = positions(damped_, i), v = velocities(damped_, i), pv = position_velocity_.col(i);
      if (i > 0) {
        const Eigen::Matrix2d& t = steps_[static_cast<std::size_t>(i - 1)].later_before;
        const auto moves = moves_.col(i);
        for (Eigen::Index a = 0; a < 2; ++a) {
          carry_[a][0].col(i) =
              moves * (t(a, 0) * positions(inverse_, i - 1) + t(a, 1) * inverse_across_.col(i - 1));
          carry_[a][1].col(i) =
              moves * (t(a, 0) * inverse_across_.col(i - 1) + t(a, 1) * velocities(inverse_, i - 1));
        }
        p -= carry_[0][0].col(i) * t(0, 0) + carry_[0][1].col(i) * t(0, 1);
        v -= carry_[1][0].col(i) * t(1, 0) + carry_[1][1].col(i) * t(1, 1);
        pv -= carry_[0][0].col(i) * t(1, 0) + carry_[0][1].col(i) * t(1, 1);
      }
      const Eigen::ArrayXd determinant = p * v - pv.square();
      positions(inverse_, i) = v / determinant;
      velocities(inverse_, i) = p / determinant;
      inverse_across_.col(i) = -pv / determinant;
    }
  }
  Course precondition(Course r) const {
    for (Eigen::Index i = 1; i < instants_; ++i) {
      positions(r, i) -=
          carry_[0][0].col(i) * positions(r, i - 1) + carry_[0][1].col(i) * velocities(r, i - 1);
      velocities(r, i) -=
          carry_[1][0].col(i) * positions(r, i - 1) + carry_[1][1].col(i) * velocities(r, i - 1);
    }
    for (Eigen::Index i = instants_; i-- > 0;) {
      const Eigen::ArrayXd p = positions(r, i);
      positions(r, i) = positions(inverse_, i) * p + inverse_across_.col(i) * velocities(r, i);
      velocities(r, i) = inverse_across_.col(i) * p + velocities(inverse_, i) * velocities(r, i);
      if (i + 1 == instants_) continue;
      positions(r, i) -=
          carry_[0][0].col(i + 1) * positions(r, i + 1) + carry_[1][0].col(i + 1) * velocities(r, i + 1);
      velocities(r, i) -=
          carry_[0][1].col(i + 1) * positions(r, i + 1) + carry_[1][1].col(i + 1) * velocities(r, i + 1);
    }
    return r;
  }

  // The normal equations, damped, times a path.
  Course product(const Course& x) const {
    Course result = damped_ * x;
    for (Eigen::Index i = 0; i < instants_; ++i) {
      positions(result, i) += position_velocity_.col(i) * velocities(x, i);
      velocities(result, i) += position_velocity_.col(i) * positions(x, i);
      for (Eigen::Index at = 0; at < lanes_; at += 3) {
        const Eigen::Array3d p = x.col(i).segment<3>(at), c = across_.col(i).segment<3>(at);
        result.col(i).segment<3>(at) +=
            Eigen::Array3d(c[2] * p[1] + c[1] * p[2], c[2] * p[0] + c[0] * p[2], c[1] * p[0] + c[0] * p[1]);
      }
      for (std::size_t k = 0; k < windows_.bones.size(); ++k) {
        const auto row = bone_rows_.col(i).segment<3>(3 * static_cast<Eigen::Index>(k));
        const auto parent = 3 * static_cast<Eigen::Index>(windows_.bones[k].parent),
                   child = 3 * static_cast<Eigen::Index>(windows_.bones[k].child);
        result.col(i).segment<3>(parent) -= (row * x.col(i).segment<3>(child)).sum() * row;
        result.col(i).segment<3>(child) -= (row * x.col(i).segment<3>(parent)).sum() * row;
      }
      if (i == 0) continue;
      const Eigen::Matrix2d& t = steps_[static_cast<std::size_t>(i - 1)].later_before;
      const auto moves = moves_.col(i);
      positions(result, i) += moves * (t(0, 0) * positions(x, i - 1) + t(0, 1) * velocities(x, i - 1));
      velocities(result, i) += moves * (t(1, 0) * positions(x, i - 1) + t(1, 1) * velocities(x, i - 1));
      positions(result, i - 1) += moves * (t(0, 0) * positions(x, i) + t(1, 0) * velocities(x, i));
      velocities(result, i - 1) += moves * (t(0, 1) * positions(x, i) + t(1, 1) * velocities(x, i));
    }
    return result;
  }

  // By conjugate gradients. Coarser steps are quicker where joints are seen, and lose their way where a joint
  // hidden for a whole window turns about its parent.
  Course step() const {
    constexpr double kResidual = 1e-3;
    constexpr int kMostProducts = 1000;
    Course x = zero_course(), residual = -gradient_, z = precondition(residual), direction = z;
    double size = (residual * z).sum();
    const double enough = kResidual * kResidual * size;
    for (int k = 0; k < kMostProducts && size > enough; ++k) {
      const Course image = product(direction);
      const double along = size / (direction * image).sum();
      if (!(along > 0.0)) break;
      x += along * direction;
      residual -= along * image;
      z = precondition(residual);
      const double before = std::exchange(size, (residual * z).sum());
      direction = z + size / before * direction;
    }
    return x;
  }

  // Levenberg and Marquardt with inexact steps; the trust region's radius after Nielsen (1999).
  SolveStatus minimise(Course& x) {
    constexpr double kLeastGradient = 1e-12, kLeastStep = 1e-12, kLeastRadius = 1e-32, kLeastGain = 1e-3;
    double radius = kFirstRadius, shrink = 2.0, now = cost(x, true);
    for (iterations_ = 0; iterations_ < options_.max_iterations;) {
      if (!std::isfinite(now)) return SolveStatus::diverged;
      if (gradient_.abs().maxCoeff() <= kLeastGradient) return SolveStatus::converged;
      ++iterations_;
      factorise(radius);
      const Course off = step();
      const Course next = x + off;
      const double then = cost(next, false), gain = (now - then) / (-0.5 * (off * gradient_).sum());
      const bool ends = off.matrix().norm() <= kLeastStep * (x.matrix().norm() + kLeastStep) ||
                        std::abs(now - then) <= options_.function_tolerance * now;
      const bool is_better = then < now && gain > kLeastGain;
      if (is_better) x = next;
      if (ends) return SolveStatus::converged;
      if (is_better) {
        radius = std::min(radius / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3)), 1e16);
        shrink = 2.0;
        now = cost(x, true);
      } else {
        radius /= shrink;
        shrink *= 2.0;
        if (radius < kLeastRadius) return SolveStatus::diverged;
      }
    }
    return SolveStatus::iteration_limit;
  }

  const BodyPath& path_;
  const BoneWindows& windows_;
  const TimeWindow& window_;
  const BoneWindowOptions& options_;
  Eigen::Index instants_, lanes_;       // lanes: the coordinates of all joints
  std::vector<JointObservation> seen_;  // by instant, joint and sensor
  Course moves_;                        // 1 where a coordinate goes on from the instant before
  std::vector<Step> steps_;             // to each instant but the first
  // The normal equations: diagonal; position with velocity; yz, xz, xy of each position; bones.
  Course gradient_, curvature_, position_velocity_, across_, bone_rows_;
  // The chains' factorisation: D_i^-1, and what comes over from the instant before, T_i D_{i-1}^-1.
  Course damped_, inverse_, inverse_across_;
  std::array<std::array<Course, 2>, 2> carry_;
  int iterations_ = 0;
};

}  // namespace

BoneWindows plan_bone_windows(const BodyPath& path, const BoneWindowOptions& options) {
  check(path);
  BoneWindows result;
  Smoothed start = smoothed(path, options);
  result.bones = bones_of(path, start);
  result.start_m = std::move(start.position_m);
  result.windows = windows_of(path.time_ns, options.window_s);
  return result;
}

std::vector<PointEstimate> solve_bone_window(const BodyPath& path, const BoneWindows& windows,
                                             std::size_t window, const BoneWindowOptions& options) {
  TRILAT_CHECK(window < windows.windows.size(), "the window is there");
  return Window(path, windows, windows.windows[window], options).solve();
}

}  // namespace trilat
