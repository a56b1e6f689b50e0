// SPDX-License-Identifier: MIT
#include "evaluators/ceres/rig_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <memory_resource>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>
#include <ceres/cost_function.h>
#include <ceres/covariance.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "datasets/base/median.h"
#include "evaluators/alignment/alignment.h"
#include "evaluators/calibration/wand_positions.h"

namespace trilat {
namespace {

// Depth error of a unit: a constant, and waves of some lengths, each as cosine and sine.
inline constexpr int kDepthWaves = 12;
inline constexpr int kDepthTerms = 1 + 2 * kDepthWaves;
using DepthTerms = Eigen::Matrix<double, kDepthTerms, 1>;

// Whitened distance of a point from its observation, in the sensor's frame, less what the depth is off by.
// Unknowns: the sensor's rotation (x, y, z, w) and position, the point, and the terms if there are any.
class PointResidual : public ceres::CostFunction {
 public:
  PointResidual(const Eigen::Vector3d& measured_m, Eigen::Matrix3d whitening)
      : measured_m_(measured_m), whitening_(std::move(whitening)) {
    set_num_residuals(3);
    *mutable_parameter_block_sizes() = {4, 3, 3};
  }
  // `by_term`: how the measured point moves with each term.
  void add_terms(const Eigen::Matrix<double, 3, kDepthTerms>& by_term) {
    whitened_by_term_ = whitening_ * by_term;
    mutable_parameter_block_sizes()->push_back(kDepthTerms);
  }
  const Eigen::Matrix3d& whitening() const { return whitening_; }

  bool Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> q(unknowns[0]);
    const Eigen::Vector3d in_world_m =
        Eigen::Map<const Eigen::Vector3d>(unknowns[2]) - Eigen::Map<const Eigen::Vector3d>(unknowns[1]);
    Eigen::Map<Eigen::Vector3d> whitened(residuals);
    whitened = whitening_ * (q.conjugate() * in_world_m - measured_m_);
    const bool with_terms = parameter_block_sizes().size() > 3;
    if (with_terms) whitened += whitened_by_term_ * Eigen::Map<const DepthTerms>(unknowns[3]);
    if (!jacobians) return true;
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Eigen::Matrix3d turned = whitening_ * q.conjugate().toRotationMatrix();
    if (jacobians[0]) {
      // conj(q) v = v + 2 w (u x v) + 2 u x (u x v), u = -(x, y, z)
      const Eigen::Vector3d u = -q.vec(), &v = in_world_m;
      Eigen::Matrix3d v_cross;
      v_cross << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
      const Eigen::Matrix3d by_u = -2.0 * q.w() * v_cross + 2.0 * u.dot(v) * Eigen::Matrix3d::Identity() +
                                   2.0 * u * v.transpose() - 4.0 * v * u.transpose();
      Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> by_rotation(jacobians[0]);
      by_rotation.leftCols<3>() = -whitening_ * by_u;
      by_rotation.col(3) = whitening_ * (2.0 * u.cross(v));
    }
    if (jacobians[1]) (Eigen::Map<Rows>(jacobians[1])) = -turned;
    if (jacobians[2]) (Eigen::Map<Rows>(jacobians[2])) = turned;
    if (with_terms && jacobians[3])
      (Eigen::Map<Eigen::Matrix<double, 3, kDepthTerms, Eigen::RowMajor>>(jacobians[3])) = whitened_by_term_;
    return true;
  }

 private:
  Eigen::Vector3d measured_m_;
  Eigen::Matrix3d whitening_;
  Eigen::Matrix<double, 3, kDepthTerms> whitened_by_term_;
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

// Residual of the measured distance from the first to the second gauge point, which lies on the x axis.
struct DistanceResidual {
  double distance_m = 0.0, weight = 1.0;
  template <class T>
  bool operator()(const T* point, T* out) const {
    out[0] = weight * (point[0] - distance_m);
    return true;
  }
};

double square(double value) { return value * value; }

// The waves' numbers per metre of depth lie evenly between those of the longest and the shortest.
double wave_rad_per_m(const DepthCorrectionOptions& options, int wave) {
  const double fewest = 1.0 / options.longest_wave_m, most = 1.0 / options.shortest_wave_m;
  return 2.0 * std::numbers::pi * (fewest + (wave + 0.5) / kDepthWaves * (most - fewest));
}

// Standard deviations of the terms: of waves whose length is uniform within the span, as many have a number
// per metre about f as 1 / f^2.
DepthTerms prior_sigmas_m(const DepthCorrectionOptions& options) {
  DepthTerms sigmas_m;
  sigmas_m[0] = options.offset_sigma_m;
  double squares = 0.0;
  for (int wave = 0; wave < kDepthWaves; ++wave) squares += 1.0 / square(wave_rad_per_m(options, wave));
  for (int wave = 0; wave < kDepthWaves; ++wave)
    sigmas_m.segment<2>(1 + 2 * wave)
        .setConstant(options.wiggle_sigma_m / wave_rad_per_m(options, wave) / std::sqrt(squares));
  return sigmas_m;
}

// How an observed point moves with each term.
Eigen::Matrix<double, 3, kDepthTerms> by_term(const DepthSensitivity& depth,
                                              const DepthCorrectionOptions& options) {
  Eigen::Matrix<double, 3, kDepthTerms> moves;
  moves.col(0) = depth.by_error;
  for (int wave = 0; wave < kDepthWaves; ++wave) {
    const double rad_per_m = wave_rad_per_m(options, wave);
    const double cosine = std::cos(rad_per_m * depth.depth_m), sine = std::sin(rad_per_m * depth.depth_m);
    moves.col(1 + 2 * wave) = cosine * depth.by_error - rad_per_m * sine * depth.by_slope_m;
    moves.col(2 + 2 * wave) = sine * depth.by_error + rad_per_m * cosine * depth.by_slope_m;
  }
  return moves;
}

// Ceres orders unknowns by address: they lie in one block of memory, in the order in which they are made, so
// that equal problems give equal bits.
struct State {
  explicit State(std::size_t bytes) : memory(bytes) {}
  std::pmr::monotonic_buffer_resource memory;
  std::pmr::vector<Eigen::Quaterniond> rotation{&memory};
  std::pmr::vector<Eigen::Vector3d> position_m{&memory};
  std::pmr::vector<Eigen::Vector3d> point_m{&memory};
  std::pmr::vector<DepthTerms> depth_terms_m{&memory};  // none, or one a sensor
};

// Generous, so that the block never has to grow.
std::size_t enough_bytes(const RigProblem& problem) {
  return 512 * (problem.sensors + 1) + 32 * problem.points;
}

class Refiner {
 public:
  Refiner(const RigProblem& problem, const std::vector<RigidTransform>& start, std::size_t reference,
          const RigGauge& gauge, const RigRefinementOptions& options)
      : problem_(problem),
        gauge_(gauge),
        options_(options),
        reference_(reference),
        state_(enough_bytes(problem)) {
    result_.used.assign(problem.observations.size(), true);
    result_.chi2.assign(problem.observations.size(), kNaN);
    result_.sensors.resize(problem.sensors);
    for (RefinedSensor& sensor : result_.sensors) sensor.covariance.setConstant(kNaN);
    start_points(start);
    if (options_.depth_correction) state_.depth_terms_m.assign(problem.sensors, DepthTerms::Zero());
  }

  RigRefinement run() {
    RigStatus status = solve(true);
    // Far outliers make the steps with a loss small; where they led is start enough for the rounds without.
    const bool only_a_start = status == RigStatus::iteration_limit && options_.rejection_rounds > 0;
    if (status != RigStatus::converged && !only_a_start) return result(status);
    measure();
    for (int round = 0; round < options_.rejection_rounds; ++round) {
      const bool rejected = reject_worst();
      if (!rejected && round > 0) break;  // solved without these already
      status = solve(false);
      if (status != RigStatus::converged) return result(status);
      measure();
    }
    if (options_.covariances) {
      ceres::Problem ceres_problem;
      build(ceres_problem, options_.rejection_rounds == 0);
      find_covariances(ceres_problem);
    }
    return result(status);
  }

 private:
  std::unique_ptr<PointResidual> residual_of(const PointObservation& o) const {
    // covariance = L L^T, so L^-1 whitens
    auto residual = std::make_unique<PointResidual>(
        o.point_in_sensor_m, o.covariance_m2.llt().matrixL().solve(Eigen::Matrix3d::Identity()));
    if (options_.depth_correction) residual->add_terms(by_term(o.depth, *options_.depth_correction));
    return residual;
  }

  // Its unknowns, in order.
  std::vector<double*> unknowns_of(const PointObservation& o) {
    std::vector<double*> unknowns{state_.rotation[o.sensor].coeffs().data(),
                                  state_.position_m[o.sensor].data(), state_.point_m[o.point].data()};
    if (options_.depth_correction) unknowns.push_back(state_.depth_terms_m[o.sensor].data());
    return unknowns;
  }

  // Each point at the median of what its observations say, an axis at a time.
  void start_points(const std::vector<RigidTransform>& start) {
    state_.rotation.reserve(start.size());
    state_.position_m.reserve(start.size());
    for (const RigidTransform& pose : start) {
      state_.rotation.push_back(pose.rotation);
      state_.position_m.push_back(pose.translation_m);
    }
    std::vector<std::vector<Eigen::Vector3d>> seen(problem_.points);
    for (const PointObservation& o : problem_.observations)
      seen[o.point].push_back(start[o.sensor] * o.point_in_sensor_m);
    state_.point_m.assign(problem_.points, Eigen::Vector3d::Constant(kNaN));
    for (std::size_t p = 0; p < problem_.points; ++p)
      for (int axis = 0; axis < 3 && !seen[p].empty(); ++axis) {
        std::vector<double> values;
        for (const Eigen::Vector3d& point : seen[p]) values.push_back(point[axis]);
        state_.point_m[p][axis] = median(std::move(values));
      }
  }

  // Turns the whole solution so that it agrees with the gauge. False when the gauge does not determine a
  // frame.
  bool move_into_world() {
    RigidTransform world;
    if (gauge_.first_points) {
      const auto& p = gauge_.first_points->points;
      const auto wand = wand_from_places(state_.point_m[p[0]], state_.point_m[p[1]], state_.point_m[p[2]]);
      if (!wand) return false;
      world = *wand;
    } else if (!gauge_.control_points.empty()) {
      AlignmentSums sums;
      for (const ControlPoint& known : gauge_.control_points)
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

  bool gauge_holds() const {
    if (!gauge_.first_points) return true;
    for (std::size_t p : gauge_.first_points->points) {
      bool seen = false;
      for (std::size_t i = 0; i < problem_.observations.size() && !seen; ++i)
        seen = result_.used[i] && problem_.observations[i].point == p;
      if (!seen) return false;
    }
    return true;
  }

  void add_observations(ceres::Problem& ceres_problem, ceres::LossFunction* loss) {
    for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
      if (!result_.used[i]) continue;
      const PointObservation& o = problem_.observations[i];
      ceres_problem.AddResidualBlock(residual_of(o).release(), loss, unknowns_of(o));
    }
  }

  void add_priors(ceres::Problem& ceres_problem) {
    for (DepthTerms& terms_m : state_.depth_terms_m) {
      const DepthTerms weights = prior_sigmas_m(*options_.depth_correction).cwiseInverse();
      ceres_problem.AddResidualBlock(
          new ceres::NormalPrior(ceres::Matrix(weights.asDiagonal()), ceres::Vector::Zero(kDepthTerms)),
          nullptr, terms_m.data());
    }
    if (gauge_.first_points && gauge_.first_points->distance_m) {
      const GaugePoints& first = *gauge_.first_points;
      ceres_problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<DistanceResidual, 1, 3>(
              new DistanceResidual{*first.distance_m, 1.0 / first.distance_sigma_m}),
          nullptr, state_.point_m[first.points[1]].data());
    }
    for (const ControlPoint& known : gauge_.control_points) {
      double* point = state_.point_m[known.point].data();
      if (ceres_problem.HasParameterBlock(point))
        ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<KnownResidual, 3, 3>(
                                           new KnownResidual{known.point_in_world_m, 1.0 / known.sigma_m}),
                                       nullptr, point);
    }
  }

  void fix_gauge(ceres::Problem& ceres_problem) {
    for (Eigen::Quaterniond& rotation : state_.rotation)
      ceres_problem.SetManifold(rotation.coeffs().data(), new ceres::EigenQuaternionManifold);
    if (gauge_.first_points) {
      const auto& p = gauge_.first_points->points;
      ceres_problem.SetParameterBlockConstant(state_.point_m[p[0]].data());
      ceres_problem.SetManifold(state_.point_m[p[1]].data(), new ceres::SubsetManifold(3, {1, 2}));
      ceres_problem.SetManifold(state_.point_m[p[2]].data(), new ceres::SubsetManifold(3, {2}));
    } else if (gauge_.control_points.empty()) {
      ceres_problem.SetParameterBlockConstant(state_.rotation[reference_].coeffs().data());
      ceres_problem.SetParameterBlockConstant(state_.position_m[reference_].data());
    }
  }

  RigStatus solve(bool robust) {
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
    std::ranges::sort(points);
    for (double* block : blocks)
      options.linear_solver_ordering->AddElementToGroup(block,
                                                        std::ranges::binary_search(points, block) ? 0 : 1);
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    options.max_num_iterations = 2000;
    // With a loss the steps shrink by a constant factor only, slowly where a tracker often takes left for
    // right; what is left is far below its own uncertainty.
    options.function_tolerance = robust ? 1e-7 : 1e-14;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_problem, &summary);
    result_.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps;
    if (summary.termination_type == ceres::NO_CONVERGENCE) return RigStatus::iteration_limit;
    if (summary.termination_type != ceres::CONVERGENCE) return RigStatus::failed;
    return RigStatus::converged;
  }

  // Leaves out the worst observation of every point that has one beyond the limit. A point seen by two
  // sensors cannot say which of them is wrong, so both go.
  bool reject_worst() {
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

  std::size_t used_of_sensor(std::size_t sensor) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < result_.used.size(); ++i)
      if (result_.used[i] && problem_.observations[i].sensor == sensor) ++count;
    return count;
  }

  const double* depth_terms_m(std::size_t sensor) const {
    return options_.depth_correction ? state_.depth_terms_m[sensor].data() : nullptr;
  }
  void count_used() {
    for (RefinedSensor& sensor : result_.sensors) sensor.used = sensor.rejected = 0;
    for (std::size_t i = 0; i < result_.used.size(); ++i) {
      RefinedSensor& sensor = result_.sensors[problem_.observations[i].sensor];
      ++(result_.used[i] ? sensor.used : sensor.rejected);
    }
  }

  // Squared normalised distances of all observations, used or not, and the sensors' residuals.
  void measure() {
    std::vector<double> squares_m2(problem_.sensors, 0.0);
    std::vector<bool> point_used(problem_.points, false);
    count_used();
    double total = 0.0;
    std::size_t used = 0;
    for (std::size_t i = 0; i < problem_.observations.size(); ++i) {
      const PointObservation& o = problem_.observations[i];
      const std::unique_ptr<PointResidual> residual = residual_of(o);
      Eigen::Vector3d whitened;
      residual->Evaluate(unknowns_of(o).data(), whitened.data(), nullptr);
      result_.chi2[i] = whitened.squaredNorm();
      if (!result_.used[i]) continue;
      ++used;
      total += result_.chi2[i];
      point_used[o.point] = true;
      squares_m2[o.sensor] +=
          residual->whitening().triangularView<Eigen::Lower>().solve(whitened).squaredNorm() / 3.0;
    }
    for (std::size_t s = 0; s < problem_.sensors; ++s) {
      RefinedSensor& sensor = result_.sensors[s];
      sensor.rms_m = std::sqrt(squares_m2[s] / static_cast<double>(std::max<std::size_t>(1, sensor.used)));
    }
    for (std::size_t p = 0; p < problem_.points; ++p)
      if (!point_used[p]) state_.point_m[p].setConstant(kNaN);
    result_.reduced_chi2 = reduced_chi2(total, used, point_used);
  }

  // Priors of the depth correction add as many residuals as unknowns; what they pull is in the total.
  double reduced_chi2(double total, std::size_t used, const std::vector<bool>& point_used) const {
    for (const DepthTerms& terms_m : state_.depth_terms_m)
      total += terms_m.cwiseQuotient(prior_sigmas_m(*options_.depth_correction)).squaredNorm();
    std::size_t residuals = 3 * used, control_points = 0;
    for (const ControlPoint& known : gauge_.control_points) {
      if (!point_used[known.point]) continue;
      ++control_points;
      residuals += 3;
      total += (state_.point_m[known.point] - known.point_in_world_m).squaredNorm() / square(known.sigma_m);
    }
    if (gauge_.first_points && gauge_.first_points->distance_m) {
      ++residuals;
      total +=
          square((state_.point_m[gauge_.first_points->points[1]].x() - *gauge_.first_points->distance_m) /
                 gauge_.first_points->distance_sigma_m);
    }
    const auto points = static_cast<std::size_t>(std::ranges::count(point_used, true));
    const std::size_t unknowns = 6 * problem_.sensors + 3 * points - (control_points > 0 ? 0 : 6);
    return residuals > unknowns ? total / static_cast<double>(residuals - unknowns) : kNaN;
  }

  void find_covariances(ceres::Problem& ceres_problem) {
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
      if (options_.depth_correction) wanted.emplace_back(depth_terms_m(s), depth_terms_m(s));
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
      Eigen::Matrix<double, kDepthTerms, kDepthTerms, Eigen::RowMajor> terms;
      if (options_.depth_correction &&
          covariance.GetCovarianceBlock(depth_terms_m(s), depth_terms_m(s), terms.data()))
        result_.sensors[s].depth_offset_sigma_m = std::sqrt(scale * terms(0, 0));
    }
  }

  void build(ceres::Problem& ceres_problem, bool robust) {
    add_observations(ceres_problem, robust ? new ceres::SoftLOneLoss(options_.robust_scale) : nullptr);
    add_priors(ceres_problem);
    fix_gauge(ceres_problem);
  }

  RigRefinement result(RigStatus status) {
    result_.status = status;
    count_used();  // of what the last rejection left, when nothing was measured since
    for (std::size_t s = 0; s < problem_.sensors; ++s) {
      result_.sensors[s].world_from_sensor = {state_.rotation[s].normalized(), state_.position_m[s]};
      if (!options_.depth_correction) continue;
      const DepthTerms& terms_m = state_.depth_terms_m[s];
      result_.sensors[s].depth_offset_m = terms_m[0];
      result_.sensors[s].depth_chi2 =
          terms_m.cwiseQuotient(prior_sigmas_m(*options_.depth_correction)).squaredNorm();
    }
    result_.point_in_world_m.assign(state_.point_m.begin(), state_.point_m.end());
    return result_;
  }

  const RigProblem& problem_;
  const RigGauge& gauge_;
  const RigRefinementOptions& options_;
  std::size_t reference_;
  State state_;
  RigRefinement result_;
};

}  // namespace

std::string name_of(RigStatus status) {
  constexpr std::array<const char*, 6> kNames{"not_solved",          "converged",       "gauge_undetermined",
                                              "sensor_undetermined", "iteration_limit", "failed"};
  return kNames.at(static_cast<std::size_t>(status));
}

RigRefinement bundle_adjust(const RigProblem& problem,
                            const std::vector<RigidTransform>& reference_from_sensor, std::size_t reference,
                            const RigGauge& gauge, const RigRefinementOptions& options) {
  return Refiner(problem, reference_from_sensor, reference, gauge, options).run();
}

}  // namespace trilat
