// SPDX-License-Identifier: MIT
#include "evaluators/ceres/bone_window.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/fusion/kalman.h"

namespace trilat {

namespace {

using PathUnknown = Eigen::Matrix<double, 6, 1>;  // position, velocity

// (part of the unknown - value) / sigma: an observed position, or what is known of a velocity beforehand.
class ValueResidual final : public ceres::SizedCostFunction<3, 6> {
 public:
  enum class Part { position = 0, velocity = 3 };
  ValueResidual(Part part, const Eigen::Vector3d& value, double sigma)
      : first_(static_cast<int>(part)), value_(value), scale_(1.0 / sigma) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int axis = 0; axis < 3; ++axis)
      residuals[axis] = scale_ * (parameters[0][first_ + axis] - value_[axis]);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian.setZero();
    for (int axis = 0; axis < 3; ++axis) jacobian(axis, first_ + axis) = scale_;
    return true;
  }

 private:
  int first_;
  Eigen::Vector3d value_;
  double scale_;
};

// From one instant to the next: L^-1 (later - predicted), where L L^T = q [dt^3/3 dt^2/2; dt^2/2 dt] is the
// covariance of a step driven by white acceleration of spectral density q.
class MotionResidual final : public ceres::SizedCostFunction<6, 6, 6> {
 public:
  MotionResidual(double step_s, double density_m2_s3)
      : step_s_(step_s),
        position_scale_(std::sqrt(3.0 / (density_m2_s3 * step_s)) / step_s),
        velocity_scale_(2.0 / std::sqrt(density_m2_s3 * step_s)) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double *before = parameters[0], *after = parameters[1];
    // The second row of L^-1 is (-3 / dt, 2) / sqrt(q dt).
    const double mixed = -1.5 / step_s_ * velocity_scale_;
    for (int axis = 0; axis < 3; ++axis) {
      const double position_m = after[axis] - before[axis] - step_s_ * before[axis + 3];
      const double velocity_m_s = after[axis + 3] - before[axis + 3];
      residuals[axis] = position_scale_ * position_m;
      residuals[axis + 3] = mixed * position_m + velocity_scale_ * velocity_m_s;
    }
    if (jacobians == nullptr) return true;
    using Jacobian = Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>;
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      Jacobian jacobian(jacobians[side]);
      jacobian.setZero();
      const double sign = side == 0 ? -1.0 : 1.0;
      for (int axis = 0; axis < 3; ++axis) {
        jacobian(axis, axis) = sign * position_scale_;
        jacobian(axis + 3, axis) = sign * mixed;
        jacobian(axis + 3, axis + 3) = sign * velocity_scale_;
        if (side == 1) continue;
        jacobian(axis, axis + 3) = -step_s_ * position_scale_;
        jacobian(axis + 3, axis + 3) -= step_s_ * mixed;
      }
    }
    return true;
  }

 private:
  double step_s_, position_scale_, velocity_scale_;
};

// (|child - parent| - length) / sigma.
class BoneResidual final : public ceres::SizedCostFunction<1, 6, 6> {
 public:
  BoneResidual(double length_m, double sigma_m) : length_m_(length_m), scale_(1.0 / sigma_m) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    using Position = Eigen::Map<const Eigen::Vector3d>;
    const Eigen::Vector3d along_m = Position(parameters[1]) - Position(parameters[0]);
    const double distance_m = along_m.norm();
    residuals[0] = scale_ * (distance_m - length_m_);
    if (jacobians == nullptr) return true;
    // Joints in one place have no direction.
    const double factor = distance_m > 1e-12 ? scale_ / distance_m : 0.0;
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      Eigen::Map<PathUnknown> row(jacobians[side]);
      row.head<3>() = (side == 0 ? -factor : factor) * along_m;
      row.tail<3>().setZero();
    }
    return true;
  }

 private:
  double length_m_, scale_;
};

bool is_seen(const JointObservation& o) { return o.seen && o.point_in_world_m.allFinite(); }

void check(const BodyPath& path) {
  TRILAT_CHECK(path.sensors <= kMaxSensors &&
                   path.observations.size() == path.time_ns.size() * path.joints.size() * path.sensors,
               "every instant and joint has one observation a sensor");
  for (std::size_t i = 1; i < path.time_ns.size(); ++i)
    TRILAT_CHECK(path.time_ns[i] > path.time_ns[i - 1], "times rise");
  for (std::size_t j = 0; j < path.joints.size(); ++j)
    TRILAT_CHECK(std::count(path.joints.begin(), path.joints.end(), path.joints[j]) == 1,
                 "every joint stands once");
}

// Each joint by itself, smoothed.
std::vector<Eigen::Vector3d> smoothed(const BodyPath& path, const BoneWindowOptions& options) {
  const std::size_t instants = path.time_ns.size(), joints = path.joints.size();
  KalmanOptions smoother;
  smoother.sigma_m = options.sigma_m;
  smoother.inferred_factor = options.inferred_factor;
  smoother.acceleration_density_m2_s3 = options.acceleration_density_m2_s3;
  smoother.speed_sigma_m_s = options.speed_sigma_m_s;
  smoother.longest_gap_s = options.longest_gap_s;
  smoother.gate_sigma = std::numeric_limits<double>::infinity();
  smoother.smooth = true;
  std::vector<Eigen::Vector3d> position_m(instants * joints);
  std::vector<JointObservation> seen(instants * path.sensors);
  std::vector<PointEstimate> estimates(instants);
  for (std::size_t j = 0; j < joints; ++j) {
    for (std::size_t i = 0; i < instants; ++i)
      std::ranges::copy(path.of(i, j), seen.begin() + static_cast<std::ptrdiff_t>(i * path.sensors));
    solve_kalman(path.time_ns, seen, path.sensors, smoother, estimates);
    for (std::size_t i = 0; i < instants; ++i) position_m[i * joints + j] = estimates[i].position_m;
  }
  return position_m;
}

bool is_tracked(std::span<const JointObservation> observations) {
  return std::ranges::any_of(observations, [](const JointObservation& o) {
    return is_seen(o) && o.state == TrackingState::tracked;
  });
}

std::vector<MedianBone> bones_of(const BodyPath& path, const std::vector<Eigen::Vector3d>& position_m) {
  std::vector<MedianBone> bones;
  for (std::size_t child = 0; child < path.joints.size(); ++child) {
    const auto parent_joint = parent_of(path.joints[child]);
    if (!parent_joint) continue;
    const auto found = std::ranges::find(path.joints, *parent_joint);
    if (found == path.joints.end()) continue;
    const auto parent = static_cast<std::size_t>(found - path.joints.begin());
    std::vector<double> lengths_m;
    for (std::size_t i = 0; i < path.time_ns.size(); ++i)
      if (is_tracked(path.of(i, parent)) && is_tracked(path.of(i, child)))
        lengths_m.push_back(
            (position_m[i * path.joints.size() + child] - position_m[i * path.joints.size() + parent])
                .norm());
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
  windows.front().answer_first = 0;
  windows.back().answer_last = time_ns.size();
  return windows;
}

ceres::Solver::Options solver_options(const BoneWindowOptions& options) {
  ceres::Solver::Options result;
  result.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // As fast here as SuiteSparse, whose bits depend on the BLAS that is installed.
  result.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  result.logging_type = ceres::SILENT;
  result.num_threads = 1;
  result.max_num_iterations = options.max_iterations;
  result.initial_trust_region_radius = 1e8;  // the start is good: nearly Gauss-Newton
  result.function_tolerance = options.function_tolerance;
  result.gradient_tolerance = 1e-12;
  result.parameter_tolerance = 1e-12;
  return result;
}

class Window {
 public:
  Window(const BodyPath& path, const BoneWindows& windows, const TimeWindow& window,
         const BoneWindowOptions& options)
      : path_(path), windows_(windows), window_(window), options_(options) {
    unknown_.resize((window.last - window.first) * path.joints.size());
  }

  void solve(std::span<PointEstimate> estimates) {
    for (std::size_t j = 0; j < path_.joints.size(); ++j) add_joint(j);
    for (const MedianBone& bone : windows_.bones) add_bone(bone);
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(options_), &problem_, &summary);
    SolveStatus status = SolveStatus::diverged;
    if (summary.termination_type == ceres::CONVERGENCE) status = SolveStatus::converged;
    if (summary.termination_type == ceres::NO_CONVERGENCE) status = SolveStatus::iteration_limit;
    for (std::size_t i = window_.answer_first; i < window_.answer_last; ++i)
      for (std::size_t j = 0; j < path_.joints.size(); ++j) {
        PointEstimate& estimate = estimates[i * path_.joints.size() + j];
        estimate = failed_estimate(has(i, j) ? status : SolveStatus::no_observation);
        if (!has(i, j)) continue;
        estimate.position_m = unknown(i, j).head<3>();
        estimate.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
      }
  }

 private:
  const Eigen::Vector3d& start_m(std::size_t i, std::size_t j) const {
    return windows_.start_m[i * path_.joints.size() + j];
  }
  bool has(std::size_t i, std::size_t j) const { return start_m(i, j).allFinite(); }
  PathUnknown& unknown(std::size_t i, std::size_t j) {
    return unknown_[(i - window_.first) * path_.joints.size() + j];
  }
  double step_s(std::size_t i) const {
    return static_cast<double>(path_.time_ns[i] - path_.time_ns[i - 1]) * 1e-9;
  }

  void add_joint(std::size_t j) {
    for (std::size_t i = window_.first; i < window_.last;) {
      if (!has(i, j)) {
        ++i;
        continue;
      }
      std::size_t end = i + 1;
      while (end < window_.last && has(end, j)) ++end;
      add_stretch(j, i, end);
      i = end;
    }
  }

  // One joint while it has a path.
  void add_stretch(std::size_t j, std::size_t first, std::size_t end) {
    bool observed = false;
    for (std::size_t i = first; i < end; ++i) {
      PathUnknown& x = unknown(i, j);
      x.head<3>() = start_m(i, j);
      x.tail<3>().setZero();
      if (i + 1 < end) x.tail<3>() = (start_m(i + 1, j) - start_m(i, j)) / step_s(i + 1);
      if (i > first) {
        if (i + 1 == end) x.tail<3>() = unknown(i - 1, j).tail<3>();
        problem_.AddResidualBlock(new MotionResidual(step_s(i), options_.acceleration_density_m2_s3), nullptr,
                                  unknown(i - 1, j).data(), x.data());
      }
      observed |= add_observations(i, j);
    }
    add_value(ValueResidual::Part::velocity, Eigen::Vector3d::Zero(), options_.speed_sigma_m_s, nullptr,
              unknown(first, j));
    // Carried through the whole window: what the smoother knows from before and after holds it.
    if (!observed)
      add_value(ValueResidual::Part::position, start_m(first, j), options_.sigma_m * options_.inferred_factor,
                nullptr, unknown(first, j));
  }

  bool add_observations(std::size_t i, std::size_t j) {
    bool observed = false;
    for (const JointObservation& o : path_.of(i, j)) {
      if (!is_seen(o)) continue;
      const double factor = o.state == TrackingState::tracked ? 1.0 : options_.inferred_factor;
      add_value(ValueResidual::Part::position, o.point_in_world_m, options_.sigma_m * factor, loss(),
                unknown(i, j));
      observed = true;
    }
    return observed;
  }

  void add_value(ValueResidual::Part part, const Eigen::Vector3d& value, double sigma,
                 ceres::LossFunction* loss, PathUnknown& x) {
    problem_.AddResidualBlock(new ValueResidual(part, value, sigma), loss, x.data());
  }

  void add_bone(const MedianBone& bone) {
    for (std::size_t i = window_.first; i < window_.last; ++i)
      if (has(i, bone.parent) && has(i, bone.child))
        problem_.AddResidualBlock(new BoneResidual(bone.length_m, options_.bone_sigma_m), nullptr,
                                  unknown(i, bone.parent).data(), unknown(i, bone.child).data());
  }

  // One for all terms; the problem owns it.
  ceres::LossFunction* loss() {
    if (!loss_ && std::isfinite(options_.loss_scale_m))
      loss_ = new ceres::CauchyLoss(options_.loss_scale_m / options_.sigma_m);
    return loss_;
  }

  const BodyPath& path_;
  const BoneWindows& windows_;
  const TimeWindow& window_;
  const BoneWindowOptions& options_;
  // Ceres orders unknowns by address: in one block, so that equal problems give equal bits.
  std::vector<PathUnknown> unknown_;
  ceres::Problem problem_;
  ceres::LossFunction* loss_ = nullptr;
};

}  // namespace

BoneWindows plan_bone_windows(const BodyPath& path, const BoneWindowOptions& options) {
  check(path);
  BoneWindows result;
  result.start_m = smoothed(path, options);
  result.bones = bones_of(path, result.start_m);
  result.windows = windows_of(path.time_ns, options.window_s);
  return result;
}

void solve_bone_window(const BodyPath& path, const BoneWindows& windows, std::size_t window,
                       const BoneWindowOptions& options, std::span<PointEstimate> estimates) {
  TRILAT_CHECK(
      window < windows.windows.size() && estimates.size() == path.time_ns.size() * path.joints.size(),
      "the window is there and every instant and joint has an estimate");
  Window(path, windows, windows.windows[window], options).solve(estimates);
}

}  // namespace trilat
