// SPDX-License-Identifier: MIT
#include "evaluators/fusion/bone_window.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "datasets/base/error.h"
#include "datasets/base/median.h"
#include "evaluators/fusion/kalman.h"

namespace trilat {

namespace {

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

constexpr Eigen::Index kUnknowns = 6;  // of a joint at an instant: position, velocity
constexpr double kFirstRadius = 1e8;   // the start is good: nearly Gauss-Newton

// Per axis, of a step driven by white acceleration of spectral density q, whose covariance is
// Q = q [dt^3/3 dt^2/2; dt^2/2 dt]: the error (later - F before), F = [1 dt; 0 1], weighs by Q^-1.
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

#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TRILAT_WIDEST_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define TRILAT_WIDEST_VECTORS  // sanitizers are not ready yet when the width is chosen
#endif

// Y -= X C^T: rows x 6 of Y, rows x columns of X, 6 x columns of C, each column `stride` behind the one
// before. Every number is summed in one order, so that all vector widths give the same bits.
TRILAT_WIDEST_VECTORS void subtract_products(double* y, const double* x, const double* c, std::ptrdiff_t rows,
                                             std::ptrdiff_t columns, std::ptrdiff_t stride) {
  using Lanes __attribute__((vector_size(64), aligned(8), may_alias)) = double;
  constexpr std::ptrdiff_t kLanes = 8;
  std::ptrdiff_t r = 0;
  for (; r + kLanes <= rows; r += kLanes) {
    Lanes sum[kUnknowns];
#pragma GCC unroll 6
    for (std::ptrdiff_t q = 0; q < kUnknowns; ++q)
      sum[q] = *reinterpret_cast<const Lanes*>(y + q * stride + r);
    for (std::ptrdiff_t k = 0; k < columns; ++k) {
      const Lanes xk = *reinterpret_cast<const Lanes*>(x + k * stride + r);
#pragma GCC unroll 6
      for (std::ptrdiff_t q = 0; q < kUnknowns; ++q) sum[q] -= xk * c[k * stride + q];
    }
#pragma GCC unroll 6
    for (std::ptrdiff_t q = 0; q < kUnknowns; ++q) *reinterpret_cast<Lanes*>(y + q * stride + r) = sum[q];
  }
  for (; r < rows; ++r)
    for (std::ptrdiff_t q = 0; q < kUnknowns; ++q)
      for (std::ptrdiff_t k = 0; k < columns; ++k) y[q * stride + r] -= x[k * stride + r] * c[k * stride + q];
}

// The normal equations of a window, H x = b: a dense block an instant, and one that ties it to the instant
// before, each joint to itself. A block Cholesky factorisation costs as many block products as there are
// instants.
class BandedSystem {
  auto part(auto& vector, std::size_t i) const {  // that of an instant
    const Eigen::Index size = diagonal_.front().rows();
    return vector.segment(static_cast<Eigen::Index>(i) * size, size);
  }

 public:
  BandedSystem(std::size_t instants, Eigen::Index size)
      : diagonal_(instants, Eigen::MatrixXd(size, size)),
        before_(diagonal_),
        factor_(diagonal_),
        tie_(diagonal_) {}

  void set_zero() {
    for (Eigen::MatrixXd& block : diagonal_) block.setZero();
    for (Eigen::MatrixXd& block : before_) block.setZero();
  }
  Eigen::MatrixXd& diagonal(std::size_t i) { return diagonal_[i]; }
  Eigen::MatrixXd& before(std::size_t i) { return before_[i]; }  // rows of i, columns of i - 1

  // Of H + diag(damping); false where that is not positive definite.
  bool factorise(const Eigen::VectorXd& damping) {
    for (std::size_t i = 0; i < diagonal_.size(); ++i) {
      factor_[i] = diagonal_[i];
      factor_[i].diagonal() += part(damping, i);
      if (i > 0) take_off(before_[i], factor_[i - 1], tie_[i], factor_[i]);
      if (!factorise(factor_[i])) return false;
    }
    return true;
  }

  // H x = b in place, by the last factorisation.
  void solve(Eigen::VectorXd& b) const {
    for (std::size_t i = 0; i < factor_.size(); ++i) {
      if (i > 0) part(b, i).noalias() -= tie_[i] * part(b, i - 1);
      factor_[i].triangularView<Eigen::Lower>().solveInPlace(part(b, i));
    }
    for (std::size_t i = factor_.size(); i-- > 0;) {
      if (i + 1 < factor_.size()) part(b, i).noalias() -= tie_[i + 1].transpose() * part(b, i + 1);
      factor_[i].triangularView<Eigen::Lower>().transpose().solveInPlace(part(b, i));
    }
  }

 private:
  // V = B L^-T for the L of the instant before, and V V^T off S, the lower triangle alone. B ties each joint
  // to itself: column k of V ends with k's joint.
  static void take_off(const Eigen::MatrixXd& b, const Eigen::MatrixXd& l, Eigen::MatrixXd& v,
                       Eigen::MatrixXd& s) {
    const Eigen::Index size = b.rows();
    v.setZero();
    for (Eigen::Index own = 0; own < size; own += kUnknowns) {
      v.block<kUnknowns, kUnknowns>(own, own) = b.block<kUnknowns, kUnknowns>(own, own);
      if (own > 0) subtract_products(&v(0, own), &v(0, 0), &l(own, 0), own, own, size);
      for (Eigen::Index k = own; k < own + kUnknowns; ++k) {
        auto column = v.col(k).head(own + kUnknowns);
        for (Eigen::Index j = own; j < k; ++j) column -= l(k, j) * v.col(j).head(own + kUnknowns);
        column /= l(k, k);
      }
    }
    for (Eigen::Index own = 0; own < size; own += kUnknowns)
      subtract_products(&s(own, own), &v(own, own), &v(own, own), size - own, size - own, size);
  }

  // Cholesky's L in the place of S's lower triangle.
  static bool factorise(Eigen::MatrixXd& s) {
    const Eigen::Index size = s.rows();
    for (Eigen::Index own = 0; own < size; own += kUnknowns) {
      if (own > 0) subtract_products(&s(own, own), &s(own, 0), &s(own, 0), size - own, own, size);
      for (Eigen::Index j = own; j < own + kUnknowns; ++j) {
        auto column = s.col(j).tail(size - j);
        for (Eigen::Index k = own; k < j; ++k) column -= s(j, k) * s.col(k).tail(size - j);
        if (!(s(j, j) > 0.0)) return false;
        column /= std::sqrt(s(j, j));
      }
    }
    return true;
  }

  std::vector<Eigen::MatrixXd> diagonal_, before_, factor_, tie_;
};

class Window {
 public:
  Window(const BodyPath& path, const BoneWindows& windows, const TimeWindow& window,
         const BoneWindowOptions& options)
      : path_(path),
        windows_(windows),
        window_(window),
        options_(options),
        size_(kUnknowns * static_cast<Eigen::Index>(path.joints.size())),
        system_(window.last - window.first, size_) {
    for (std::size_t i = window.first + 1; i < window.last; ++i)
      steps_.emplace_back(step_s(i), options.acceleration_density_m2_s3);
  }

  void solve(std::span<PointEstimate> estimates) {
    Eigen::VectorXd x = start();
    const SolveStatus status = minimise(x);
    for (std::size_t i = window_.answer_first; i < window_.answer_last; ++i)
      for (std::size_t j = 0; j < path_.joints.size(); ++j) {
        PointEstimate& estimate = estimates[i * path_.joints.size() + j];
        estimate = failed_estimate(has(i, j) ? status : SolveStatus::no_observation);
        if (!has(i, j)) continue;
        estimate.position_m = x.segment<3>(place(i, j));
        estimate.iterations = iterations_;
      }
  }

 private:
  const Eigen::Vector3d& start_m(std::size_t i, std::size_t j) const {
    return windows_.start_m[i * path_.joints.size() + j];
  }
  bool has(std::size_t i, std::size_t j) const { return start_m(i, j).allFinite(); }
  bool moves_on(std::size_t i, std::size_t j) const {
    return i > window_.first && has(i, j) && has(i - 1, j);
  }
  Eigen::Index in_block(std::size_t j) const { return kUnknowns * static_cast<Eigen::Index>(j); }
  Eigen::Index place(std::size_t i, std::size_t j) const {
    return static_cast<Eigen::Index>(i - window_.first) * size_ + in_block(j);
  }
  double step_s(std::size_t i) const {
    return static_cast<double>(path_.time_ns[i] - path_.time_ns[i - 1]) * 1e-9;
  }

  // The smoother's positions and, as velocities, their differences.
  Eigen::VectorXd start() const {
    Eigen::VectorXd x =
        Eigen::VectorXd::Zero(size_ * static_cast<Eigen::Index>(window_.last - window_.first));
    for (std::size_t i = window_.first; i < window_.last; ++i)
      for (std::size_t j = 0; j < path_.joints.size(); ++j) {
        if (!has(i, j)) continue;
        x.segment<3>(place(i, j)) = start_m(i, j);
        if (i + 1 < window_.last && has(i + 1, j))
          x.segment<3>(place(i, j) + 3) = (start_m(i + 1, j) - start_m(i, j)) / step_s(i + 1);
        else if (moves_on(i, j))
          x.segment<3>(place(i, j) + 3) = x.segment<3>(place(i - 1, j) + 3);
      }
    return x;
  }

  // Half of the sum of the losses, and its gradient and the normal equations as far as they are wanted.
  enum class Wanted { value, gradient, equations };
  double cost(const Eigen::VectorXd& x, Wanted wanted) {
    if (wanted != Wanted::value) gradient_.setZero(x.size());
    if (wanted == Wanted::equations) system_.set_zero();
    double sum = 0.0;
    for (std::size_t i = window_.first; i < window_.last; ++i)
      for (std::size_t j = 0; j < path_.joints.size(); ++j) {
        if (!has(i, j)) {
          if (wanted == Wanted::equations)
            system_.diagonal(i - window_.first).diagonal().segment(in_block(j), kUnknowns).setOnes();
          continue;
        }
        if (moves_on(i, j))
          sum += add_motion(x, i, j, wanted);
        else
          sum += add_beginning(x, i, j, wanted);
        for (const JointObservation& o : path_.of(i, j))
          if (is_seen(o)) {
            const double factor = o.state == TrackingState::tracked ? 1.0 : options_.inferred_factor;
            sum += add_value(x, i, j, 0, o.point_in_world_m, options_.sigma_m * factor, true, wanted);
          }
      }
    for (const MedianBone& bone : windows_.bones)
      for (std::size_t i = window_.first; i < window_.last; ++i)
        if (has(i, bone.parent) && has(i, bone.child)) sum += add_bone(x, i, bone, wanted);
    return 0.5 * sum;
  }

  double add_motion(const Eigen::VectorXd& x, std::size_t i, std::size_t j, Wanted wanted) {
    const Step& step = steps_[i - window_.first - 1];
    const double dt_s = step_s(i);
    const Eigen::Index here = place(i, j), before = place(i - 1, j), block = in_block(j);
    double sum = 0.0;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Eigen::Vector2d error(x[here + axis] - x[before + axis] - dt_s * x[before + axis + 3],
                                  x[here + axis + 3] - x[before + axis + 3]);
      const Eigen::Vector2d pull = step.information * error,
                            pull_before = step.later_before.transpose() * error;
      sum += error.dot(pull);
      if (wanted == Wanted::value) continue;
      for (Eigen::Index a = 0; a < 2; ++a) {
        gradient_[here + axis + 3 * a] += pull[a];
        gradient_[before + axis + 3 * a] += pull_before[a];
        if (wanted != Wanted::equations) continue;
        for (Eigen::Index b = 0; b < 2; ++b) {
          const Eigen::Index row = block + axis + 3 * a, column = block + axis + 3 * b;
          system_.diagonal(i - window_.first)(row, column) += step.information(a, b);
          system_.diagonal(i - window_.first - 1)(row, column) += step.before(a, b);
          system_.before(i - window_.first)(row, column) += step.later_before(a, b);
        }
      }
    }
    return sum;
  }

  // Of a joint's stretch in the window: how fast it may start and, if no sensor sees it in all of the
  // stretch, where: what the smoother knows from before and after holds it.
  double add_beginning(const Eigen::VectorXd& x, std::size_t i, std::size_t j, Wanted wanted) {
    bool observed = false;
    for (std::size_t k = i; k < window_.last && has(k, j) && !observed; ++k)
      observed = std::ranges::any_of(path_.of(k, j), is_seen);
    const double held = observed ? 0.0
                                 : add_value(x, i, j, 0, start_m(i, j),
                                             options_.sigma_m * options_.inferred_factor, false, wanted);
    return held + add_value(x, i, j, 3, Eigen::Vector3d::Zero(), options_.speed_sigma_m_s, false, wanted);
  }

  // (part of the unknown - value) / sigma, with Cauchy's loss where that is asked for.
  double add_value(const Eigen::VectorXd& x, std::size_t i, std::size_t j, Eigen::Index part,
                   const Eigen::Vector3d& value, double sigma, bool robust, Wanted wanted) {
    const Eigen::Index at = place(i, j) + part;
    const Eigen::Vector3d off = (x.segment<3>(at) - value) / sigma;
    const double squared = off.squaredNorm(), scale = options_.loss_scale_m / options_.sigma_m;
    const bool bends = robust && std::isfinite(scale);
    const double weight = bends ? 1.0 / (1.0 + squared / (scale * scale)) : 1.0;
    if (wanted != Wanted::value) gradient_.segment<3>(at) += weight / sigma * off;
    if (wanted == Wanted::equations) {
      auto block = system_.diagonal(i - window_.first).block<3, 3>(in_block(j) + part, in_block(j) + part);
      block.diagonal().array() += weight / (sigma * sigma);
      // the loss bends, so along the error the curvature is less; where it is negative, it counts as none
      if (bends && squared > 0.0)
        block -= std::min(weight / squared, 2.0 * weight * weight / (scale * scale)) / (sigma * sigma) * off *
                 off.transpose();
    }
    return bends ? scale * scale * std::log1p(squared / (scale * scale)) : squared;
  }

  // (|child - parent| - length) / sigma.
  double add_bone(const Eigen::VectorXd& x, std::size_t i, const MedianBone& bone, Wanted wanted) {
    const Eigen::Index parent = in_block(bone.parent), child = in_block(bone.child);
    const Eigen::Vector3d along_m = x.segment<3>(place(i, bone.child)) - x.segment<3>(place(i, bone.parent));
    const double distance_m = along_m.norm();
    const double off = (distance_m - bone.length_m) / options_.bone_sigma_m;
    // Joints in one place have no direction.
    if (wanted != Wanted::value && distance_m > 1e-12) {
      const Eigen::Vector3d row = along_m / (distance_m * options_.bone_sigma_m);
      gradient_.segment<3>(place(i, bone.parent)) -= off * row;
      gradient_.segment<3>(place(i, bone.child)) += off * row;
      if (wanted != Wanted::equations) return off * off;
      const Eigen::Matrix3d square = row * row.transpose();
      Eigen::MatrixXd& block = system_.diagonal(i - window_.first);
      block.block<3, 3>(parent, parent) += square;
      block.block<3, 3>(child, child) += square;
      block.block<3, 3>(parent, child) -= square;
      block.block<3, 3>(child, parent) -= square;
    }
    return off * off;
  }

  bool factorise(double radius) {
    Eigen::VectorXd damping(gradient_.size());
    for (std::size_t i = 0; i < window_.last - window_.first; ++i)
      damping.segment(static_cast<Eigen::Index>(i) * size_, size_) =
          system_.diagonal(i).diagonal().cwiseMax(1e-6) / radius;
    return system_.factorise(damping);
  }

  // Levenberg and Marquardt, the trust region's radius after Nielsen (1999). A factorisation serves as long
  // as its steps gain most of what they promise; only a fresh one may say that the end is reached.
  SolveStatus minimise(Eigen::VectorXd& x) {
    constexpr double kLeastGradient = 1e-12, kLeastStep = 1e-12, kLeastRadius = 1e-32, kLeastGain = 1e-3,
                     kGoodGain = 0.7;
    double radius = kFirstRadius, shrink = 2.0, now = cost(x, Wanted::equations);
    bool fresh = true;
    for (iterations_ = 0; iterations_ < options_.max_iterations;) {
      if (!std::isfinite(now)) return SolveStatus::diverged;
      if (gradient_.lpNorm<Eigen::Infinity>() <= kLeastGradient) return SolveStatus::converged;
      ++iterations_;
      Eigen::VectorXd step = -gradient_;
      const bool solved = !fresh || factorise(radius);
      if (solved) system_.solve(step);
      const Eigen::VectorXd next = x + step;
      const double then = solved ? cost(next, Wanted::value) : now, promised = -0.5 * step.dot(gradient_);
      const double gain = (now - then) / promised;
      const bool ends = solved && (step.norm() <= kLeastStep * (x.norm() + kLeastStep) ||
                                   std::abs(now - then) <= options_.function_tolerance * now);
      const bool is_better = then < now && gain > kLeastGain;
      if (is_better) x = next;
      if (ends && fresh) return SolveStatus::converged;
      if (!is_better && fresh) {
        radius /= shrink;
        shrink *= 2.0;
        if (radius < kLeastRadius) return SolveStatus::diverged;
        continue;
      }
      if (fresh) {
        radius = std::min(radius / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3)), 1e16);
        shrink = 2.0;
      }
      fresh = ends || gain < kGoodGain || radius < kFirstRadius;
      now = cost(x, fresh ? Wanted::equations : Wanted::gradient);
    }
    return SolveStatus::iteration_limit;
  }

  const BodyPath& path_;
  const BoneWindows& windows_;
  const TimeWindow& window_;
  const BoneWindowOptions& options_;
  Eigen::Index size_;  // of an instant's unknowns
  BandedSystem system_;
  std::vector<Step> steps_;  // to each instant but the first
  Eigen::VectorXd gradient_;
  int iterations_ = 0;
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
