// SPDX-License-Identifier: MIT
#include "evaluators/ceres/rig_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "evaluators/alignment/alignment.h"

namespace trilat {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Whitened distance of a point from its observation, in the sensor's frame, the measured depth corrected
// along the ray by offset + wiggle.
struct PointResidual {
  Eigen::Vector3d measured_m, along_ray;  // the ray scaled to z = 1
  Eigen::Matrix3d whitening;
  double share_b = 0.0;  // of the second knot

  template <class T>
  void whitened(const T* rotation, const T* position, const T* point, const T& correction_m, T* out) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
    const Vector in_world = Eigen::Map<const Vector>(point) - Eigen::Map<const Vector>(position);
    const Vector expected = q.conjugate() * in_world;
    const Vector corrected = measured_m.cast<T>() - correction_m * along_ray.cast<T>();
    Eigen::Map<Vector> residual(out);
    residual = whitening.cast<T>() * (expected - corrected);
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, T* out) const {
    whitened(rotation, position, point, T(0), out);
    return true;
  }
  template <class T>
  bool operator()(const T* rotation, const T* position, const T* point, const T* offset, const T* knot_a,
                  const T* knot_b, T* out) const {
    whitened(rotation, position, point, offset[0] + (1.0 - share_b) * knot_a[0] + share_b * knot_b[0], out);
    return true;
  }
};

struct Prior {
  double weight = 1.0;
  template <class T>
  bool operator()(const T* value, T* out) const {
    out[0] = weight * value[0];
    return true;
  }
};

struct KnownResidual {
  Eigen::Vector3d known_m;
  double weight = 1.0;
  template <class T>
  bool operator()(const T* point, T* out) const {
    for (int axis = 0; axis < 3; ++axis) out[axis] = weight * (point[axis] - known_m[axis]);
    return true;
  }
};

struct DepthCorrection {
  double offset_m = 0.0;
  std::map<int, double> knot_m;  // by number: depth = number * spacing
};

struct State {
  std::vector<Eigen::Quaterniond> rotation;
  std::vector<Eigen::Vector3d> position_m;
  std::vector<Eigen::Vector3d> point_m;
  std::vector<DepthCorrection> correction;
};

class Refiner {
 public:
  Refiner(const RigProblem& problem, const std::vector<RigidTransform>& start, std::size_t reference,
          const RigGauge& gauge, const RigRefinementOptions& options);
  RigRefinement run();

 private:
  PointResidual residual_of(const PointObservation& o) const;
  void start_points(const std::vector<RigidTransform>& start);
  bool move_into_world();
  bool gauge_holds() const;
  void add_observations(ceres::Problem& ceres_problem, ceres::LossFunction* loss);
  void add_priors(ceres::Problem& ceres_problem);
  void fix_gauge(ceres::Problem& ceres_problem);
  RigStatus solve(bool robust);
  bool reject_worst();
  std::size_t used_of_sensor(std::size_t sensor) const;
  void count_used();
  void measure();
  void find_covariances(ceres::Problem& ceres_problem);
  void build(ceres::Problem& ceres_problem, bool robust);
  RigRefinement result(RigStatus status);

  const RigProblem& problem_;
  const RigGauge& gauge_;
  const RigRefinementOptions& options_;
  std::size_t reference_;
  State state_;
  RigRefinement result_;
};

Refiner::Refiner(const RigProblem& problem, const std::vector<RigidTransform>& start, std::size_t reference,
                 const RigGauge& gauge, const RigRefinementOptions& options)
    : problem_(problem), gauge_(gauge), options_(options), reference_(reference) {
  result_.used.assign(problem.observations.size(), true);
  result_.chi2.assign(problem.observations.size(), kNone);
  result_.sensors.resize(problem.sensors);
  for (RefinedSensor& sensor : result_.sensors) sensor.covariance.setConstant(kNone);
  start_points(start);
  if (!options_.depth_correction) return;
  state_.correction.resize(problem.sensors);
  for (const PointObservation& o : problem.observations) {
    const int knot =
        static_cast<int>(std::floor(o.surface_depth_m / options_.depth_correction->knot_spacing_m));
    state_.correction[o.sensor].knot_m[knot] = 0.0;
    state_.correction[o.sensor].knot_m[knot + 1] = 0.0;
  }
}

// Each point at the median of what its observations say, an axis at a time.
void Refiner::start_points(const std::vector<RigidTransform>& start) {
  for (const RigidTransform& pose : start) {
    state_.rotation.push_back(pose.rotation);
    state_.position_m.push_back(pose.translation_m);
  }
  std::vector<std::vector<Eigen::Vector3d>> seen(problem_.points);
  for (const PointObservation& o : problem_.observations)
    seen[o.point].push_back(start[o.sensor] * o.point_in_sensor_m);
  state_.point_m.assign(problem_.points, Eigen::Vector3d::Constant(kNone));
  for (std::size_t p = 0; p < problem_.points; ++p)
    for (int axis = 0; axis < 3 && !seen[p].empty(); ++axis) {
      std::vector<double> values;
      for (const Eigen::Vector3d& point : seen[p]) values.push_back(point[axis]);
      std::sort(values.begin(), values.end());
      const std::size_t middle = values.size() / 2;
      state_.point_m[p][axis] =
          values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
    }
}

// Turns the whole solution so that it agrees with the gauge. False when the gauge does not determine a frame.
bool Refiner::move_into_world() {
  RigidTransform world;
  if (gauge_.first_points) {
    const auto& p = gauge_.first_points->points;
    const Eigen::Vector3d origin = state_.point_m[p[0]];
    const Eigen::Vector3d x = state_.point_m[p[1]] - origin;
    const Eigen::Vector3d z = x.cross(state_.point_m[p[2]] - origin);
    if (!(x.norm() > 0.01) || !(z.norm() > 0.01 * x.norm())) return false;
    Eigen::Matrix3d axes;
    axes.row(0) = x.normalized();
    axes.row(2) = z.normalized();
    axes.row(1) = axes.row(2).cross(axes.row(0));
    world.rotation = Eigen::Quaterniond(axes).normalized();
    world.translation_m = -(world.rotation * origin);
  } else if (!gauge_.known_points.empty()) {
    AlignmentSums sums;
    for (const KnownPoint& known : gauge_.known_points)
      if (state_.point_m[known.point].allFinite())
        sums.add(state_.point_m[known.point], known.point_in_world_m);
    const Alignment fit = solve_alignment(sums, AlignmentKind::rigid);
    if (fit.status != AlignmentStatus::aligned) return false;
    world = fit.truth_from_estimate;
  } else {
    const RigidTransform now{state_.rotation[reference_], state_.position_m[reference_]};
    world = gauge_.world_from_reference * now.inverse();
  }
  for (std::size_t s = 0; s < problem_.sensors; ++s) {
    const RigidTransform pose = world * RigidTransform{state_.rotation[s], state_.position_m[s]};
    state_.rotation[s] = pose.rotation;
    state_.position_m[s] = pose.translation_m;
  }
  for (Eigen::Vector3d& point : state_.point_m) point = world * point;
  return true;
}

bool Refiner::gauge_holds() const {
  if (!gauge_.first_points) return true;
  for (std::size_t p : gauge_.first_points->points) {
    bool seen = false;
    for (std::size_t i = 0; i < problem_.observations.size() && !seen; ++i)
      seen = result_.used[i] && problem_.observations[i].point == p;
    if (!seen) return false;
  }
  return true;
}

PointResidual Refiner::residual_of(const PointObservation& o) const {
  PointResidual residual;
  residual.measured_m = o.point_in_sensor_m;
  residual.along_ray = o.point_in_sensor_m / o.point_in_sensor_m.z();
  const Eigen::Matrix3d covariance = o.covariance_m2 + options_.covariance_floor_m *
                                                           options_.covariance_floor_m *
                                                           Eigen::Matrix3d::Identity();
  // covariance = L L^T, so L^-1 whitens
  residual.whitening = covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  if (options_.depth_correction) {
    const double place = o.surface_depth_m / options_.depth_correction->knot_spacing_m;
    residual.share_b = place - std::floor(place);
  }
  return residual;
}

void Refiner::add_observations(ceres::Problem& ceres_problem, ceres::LossFunction* loss) {
  for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
    if (!result_.used[i]) continue;
    const PointObservation& o = problem_.observations[i];
    auto residual = std::make_unique<PointResidual>(residual_of(o));
    double* rotation = state_.rotation[o.sensor].coeffs().data();
    double* position = state_.position_m[o.sensor].data();
    double* point = state_.point_m[o.point].data();
    if (!options_.depth_correction) {
      ceres_problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PointResidual, 3, 4, 3, 3>(residual.release()), loss, rotation,
          position, point);
      continue;
    }
    DepthCorrection& correction = state_.correction[o.sensor];
    const int knot =
        static_cast<int>(std::floor(o.surface_depth_m / options_.depth_correction->knot_spacing_m));
    ceres_problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PointResidual, 3, 4, 3, 3, 1, 1, 1>(residual.release()), loss,
        rotation, position, point, &correction.offset_m, &correction.knot_m.at(knot),
        &correction.knot_m.at(knot + 1));
  }
}

void Refiner::add_priors(ceres::Problem& ceres_problem) {
  for (DepthCorrection& correction : state_.correction) {
    const auto add = [&](double* value, double sigma_m) {
      if (ceres_problem.HasParameterBlock(value))
        ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, 1, 1>(new Prior{1.0 / sigma_m}),
                                       nullptr, value);
    };
    add(&correction.offset_m, options_.depth_correction->offset_sigma_m);
    for (auto& [number, value] : correction.knot_m) add(&value, options_.depth_correction->wiggle_sigma_m);
  }
  for (const KnownPoint& known : gauge_.known_points) {
    double* point = state_.point_m[known.point].data();
    if (ceres_problem.HasParameterBlock(point))
      ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<KnownResidual, 3, 3>(
                                         new KnownResidual{known.point_in_world_m, 1.0 / known.sigma_m}),
                                     nullptr, point);
  }
}

void Refiner::fix_gauge(ceres::Problem& ceres_problem) {
  for (Eigen::Quaterniond& rotation : state_.rotation)
    ceres_problem.SetManifold(rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
  if (gauge_.first_points) {
    const auto& p = gauge_.first_points->points;
    ceres_problem.SetParameterBlockConstant(state_.point_m[p[0]].data());
    ceres_problem.SetManifold(state_.point_m[p[1]].data(), new ceres::SubsetManifold(3, {1, 2}));
    ceres_problem.SetManifold(state_.point_m[p[2]].data(), new ceres::SubsetManifold(3, {2}));
  } else if (gauge_.known_points.empty()) {
    ceres_problem.SetParameterBlockConstant(state_.rotation[reference_].coeffs().data());
    ceres_problem.SetParameterBlockConstant(state_.position_m[reference_].data());
  }
}

void Refiner::build(ceres::Problem& ceres_problem, bool robust) {
  add_observations(ceres_problem, robust ? new ceres::SoftLOneLoss(options_.robust_scale) : nullptr);
  add_priors(ceres_problem);
  fix_gauge(ceres_problem);
}

RigStatus Refiner::solve(bool robust) {
  for (std::size_t s = 0; s < problem_.sensors; ++s)
    if (used_of_sensor(s) < 3) return RigStatus::sensor_undetermined;
  if (!gauge_holds() || !move_into_world()) return RigStatus::gauge_undetermined;
  ceres::Problem ceres_problem;
  build(ceres_problem, robust);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<double*> blocks;
  ceres_problem.GetParameterBlocks(&blocks);
  std::vector<const double*> points;
  for (const Eigen::Vector3d& point : state_.point_m) points.push_back(point.data());
  std::sort(points.begin(), points.end());
  for (double* block : blocks)
    options.linear_solver_ordering->AddElementToGroup(
        block, std::binary_search(points.begin(), points.end(), block) ? 0 : 1);
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = 200;
  // With a loss the steps shrink by a constant factor only; what is left is far below its own uncertainty.
  options.function_tolerance = robust ? 1e-10 : 1e-14;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  result_.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps;
  if (summary.termination_type == ceres::NO_CONVERGENCE) return RigStatus::iteration_limit;
  if (summary.termination_type != ceres::CONVERGENCE) return RigStatus::failed;
  return RigStatus::converged;
}

std::size_t Refiner::used_of_sensor(std::size_t sensor) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < result_.used.size(); ++i)
    if (result_.used[i] && problem_.observations[i].sensor == sensor) ++count;
  return count;
}

void Refiner::count_used() {
  for (RefinedSensor& sensor : result_.sensors) sensor.used = sensor.rejected = 0;
  for (std::size_t i = 0; i < result_.used.size(); ++i) {
    RefinedSensor& sensor = result_.sensors[problem_.observations[i].sensor];
    ++(result_.used[i] ? sensor.used : sensor.rejected);
  }
}

// Squared normalised distances of all observations, used or not, and the sensors' residuals.
void Refiner::measure() {
  std::vector<double> squares_m2(problem_.sensors, 0.0);
  count_used();
  double total = 0.0;
  std::vector<bool> point_used(problem_.points, false);
  for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
    const PointObservation& o = problem_.observations[i];
    const PointResidual residual = residual_of(o);
    double correction_m = 0.0;
    if (options_.depth_correction) {
      const DepthCorrection& c = state_.correction[o.sensor];
      const int knot =
          static_cast<int>(std::floor(o.surface_depth_m / options_.depth_correction->knot_spacing_m));
      correction_m = c.offset_m + (1.0 - residual.share_b) * c.knot_m.at(knot) +
                     residual.share_b * c.knot_m.at(knot + 1);
    }
    Eigen::Vector3d whitened;
    residual.whitened(state_.rotation[o.sensor].coeffs().data(), state_.position_m[o.sensor].data(),
                      state_.point_m[o.point].data(), correction_m, whitened.data());
    result_.chi2[i] = whitened.squaredNorm();
    if (!result_.used[i]) continue;
    total += result_.chi2[i];
    point_used[o.point] = true;
    const Eigen::Vector3d distance_m = residual.whitening.triangularView<Eigen::Lower>().solve(whitened);
    squares_m2[o.sensor] += distance_m.squaredNorm() / 3.0;
  }
  std::size_t used = 0, points = 0;
  for (bool u : result_.used) used += u;
  for (bool u : point_used) points += u;
  for (std::size_t s = 0; s < problem_.sensors; ++s)
    result_.sensors[s].rms_m =
        std::sqrt(squares_m2[s] / static_cast<double>(std::max<std::size_t>(1, result_.sensors[s].used)));
  // Priors add as many residuals as unknowns, and what they pull is in the total.
  double prior_total = 0.0;
  if (options_.depth_correction)
    for (const DepthCorrection& c : state_.correction) {
      prior_total += std::pow(c.offset_m / options_.depth_correction->offset_sigma_m, 2);
      for (const auto& [number, value] : c.knot_m)
        prior_total += std::pow(value / options_.depth_correction->wiggle_sigma_m, 2);
    }
  for (const KnownPoint& known : gauge_.known_points)
    if (point_used[known.point])
      prior_total += (state_.point_m[known.point] - known.point_in_world_m).squaredNorm() /
                     (known.sigma_m * known.sigma_m);
  std::size_t known = 0;
  for (const KnownPoint& k : gauge_.known_points) known += point_used[k.point];
  const double free_parameters =
      static_cast<double>(6 * problem_.sensors + 3 * points) - (known > 0 ? 0.0 : 6.0);
  const double residuals = static_cast<double>(3 * used + 3 * known);
  result_.reduced_chi2 =
      residuals > free_parameters ? (total + prior_total) / (residuals - free_parameters) : kNone;
  for (std::size_t p = 0; p < problem_.points; ++p)
    if (!point_used[p]) state_.point_m[p].setConstant(kNone);
}

// Leaves out the worst observation of every point that has one beyond the limit. A point seen by two sensors
// cannot say which of them is wrong, so both go.
bool Refiner::reject_worst() {
  std::map<std::size_t, std::size_t> worst;
  std::map<std::size_t, std::size_t> seen_by;
  const double limit = options_.rejection_chi2 * std::max(1.0, std::min(result_.reduced_chi2, 4.0));
  for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
    if (!result_.used[i]) continue;
    const std::size_t point = problem_.observations[i].point;
    ++seen_by[point];
    if (!(result_.chi2[i] > limit)) continue;
    const auto [entry, is_new] = worst.try_emplace(point, i);
    if (!is_new && result_.chi2[i] > result_.chi2[entry->second]) entry->second = i;
  }
  for (const auto& [point, observation] : worst) {
    result_.used[observation] = false;
    if (seen_by[point] > 2) continue;
    for (std::size_t i = 0; i < problem_.observations.size(); ++i)
      if (problem_.observations[i].point == point) result_.used[i] = false;
  }
  return !worst.empty();
}

void Refiner::find_covariances(ceres::Problem& ceres_problem) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  ceres::Covariance covariance(options);
  std::vector<std::pair<const double*, const double*>> wanted;
  for (std::size_t s = 0; s < problem_.sensors; ++s) {
    const double* rotation = state_.rotation[s].coeffs().data();
    const double* position = state_.position_m[s].data();
    wanted.emplace_back(rotation, rotation);
    wanted.emplace_back(rotation, position);
    wanted.emplace_back(position, position);
    if (options_.depth_correction)
      wanted.emplace_back(&state_.correction[s].offset_m, &state_.correction[s].offset_m);
  }
  if (!covariance.Compute(wanted, &ceres_problem)) return;
  const double scale = std::max(1.0, std::isfinite(result_.reduced_chi2) ? result_.reduced_chi2 : 1.0);
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  for (std::size_t s = 0; s < problem_.sensors; ++s) {
    const double* rotation = state_.rotation[s].coeffs().data();
    const double* position = state_.position_m[s].data();
    Block rr, rp, pp;
    if (!covariance.GetCovarianceBlockInTangentSpace(rotation, rotation, rr.data()) ||
        !covariance.GetCovarianceBlockInTangentSpace(rotation, position, rp.data()) ||
        !covariance.GetCovarianceBlockInTangentSpace(position, position, pp.data()))
      continue;
    // The manifold turns by twice its tangent vector.
    auto& result = result_.sensors[s].covariance;
    result << 4.0 * rr, 2.0 * rp, 2.0 * rp.transpose(), pp;
    result *= scale;
    double variance = 0.0;
    if (options_.depth_correction && covariance.GetCovarianceBlock(&state_.correction[s].offset_m,
                                                                   &state_.correction[s].offset_m, &variance))
      result_.sensors[s].depth_offset_sigma_m = std::sqrt(scale * variance);
  }
}

RigRefinement Refiner::result(RigStatus status) {
  result_.status = status;
  count_used();  // of what the last rejection left, when nothing was measured since
  for (std::size_t s = 0; s < problem_.sensors; ++s) {
    result_.sensors[s].world_from_sensor = {state_.rotation[s].normalized(), state_.position_m[s]};
    if (options_.depth_correction) result_.sensors[s].depth_offset_m = state_.correction[s].offset_m;
  }
  result_.point_in_world_m = state_.point_m;
  return result_;
}

RigRefinement Refiner::run() {
  RigStatus status = solve(true);
  // Far outliers make the steps with a loss small; where they led is start enough for the rounds without.
  const bool only_a_start = status == RigStatus::iteration_limit && options_.rejection_rounds > 0;
  if (status != RigStatus::converged && !only_a_start) return result(status);
  measure();
  for (int round = 0; round < options_.rejection_rounds; ++round) {
    const bool rejected = reject_worst();
    status = solve(false);
    if (status != RigStatus::converged) return result(status);
    measure();
    if (!rejected && round > 0) break;
  }
  if (options_.covariances) {
    ceres::Problem ceres_problem;
    build(ceres_problem, options_.rejection_rounds == 0);
    find_covariances(ceres_problem);
  }
  return result(status);
}

}  // namespace

std::string name_of(RigStatus status) {
  constexpr std::array<const char*, 6> kNames{"not_solved",          "converged",       "gauge_undetermined",
                                              "sensor_undetermined", "iteration_limit", "failed"};
  return kNames.at(static_cast<std::size_t>(status));
}

RigRefinement refine_rig(const RigProblem& problem, const std::vector<RigidTransform>& reference_from_sensor,
                         std::size_t reference, const RigGauge& gauge, const RigRefinementOptions& options) {
  return Refiner(problem, reference_from_sensor, reference, gauge, options).run();
}

}  // namespace trilat
