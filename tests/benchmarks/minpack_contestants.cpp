// SPDX-License-Identifier: MIT
#include <limits>

#include <Eigen/Dense>
#include <cminpack.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <unsupported/Eigen/LevenbergMarquardt>

#include "tests/benchmarks/contestants.h"

namespace trilat {
namespace {

constexpr int kRanges = 4;

// Sizes are told at run time: with fixed ones the solver does not compile (Eigen 3.4).
struct EigenRanges : Eigen::DenseFunctor<double> {
  const RangeProblem* problem = nullptr;

  EigenRanges() : DenseFunctor(3, kRanges) {}

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& residuals) const {
    const Eigen::Vector3d x_m = x;
    for (int i = 0; i < kRanges; ++i)
      residuals[i] = (x_m - problem->sensor_m[i]).norm() - problem->range_m[i];
    return 0;
  }
  int df(const Eigen::VectorXd& x, JacobianType& jacobian) const {
    const Eigen::Vector3d x_m = x;
    for (int i = 0; i < kRanges; ++i) jacobian.row(i) = (x_m - problem->sensor_m[i]).normalized().transpose();
    return 0;
  }
};

struct EigenLm {
  EigenRanges ranges;
  Eigen::LevenbergMarquardt<EigenRanges> solver{ranges};
  Eigen::VectorXd x;

  explicit EigenLm(Tolerance tolerance) {
    solver.setFtol(tolerance.rule == 0 ? tolerance.value : 0.0);
    solver.setXtol(tolerance.rule == 1 ? tolerance.value : 0.0);
    solver.setGtol(tolerance.rule == 2 ? tolerance.value : 0.0);
    solver.setMaxfev(kMostIterations);
  }
  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) {
    ranges.problem = &problem;
    x = x_m;
    solver.minimize(x);
    x_m = x;
    return static_cast<int>(solver.iterations());
  }
};

// flag 1 wants residuals, 2 the Jacobian.
int minpack_ranges(void* data, int m, int, const double* parameters, double* residuals, double* jacobian,
                   int stride, int flag) {
  const auto& problem = *static_cast<const RangeProblem*>(data);
  const Eigen::Map<const Eigen::Vector3d> x(parameters);
  for (int i = 0; i < m; ++i) {
    const Eigen::Vector3d from_sensor = x - problem.sensor_m[i];
    const double distance = from_sensor.norm();
    if (flag == 1) residuals[i] = distance - problem.range_m[i];
    for (int axis = 0; flag == 2 && axis < 3; ++axis)
      jacobian[i + stride * axis] = from_sensor[axis] / distance;
  }
  return 0;
}

struct Cminpack {
  double tolerance;

  explicit Cminpack(Tolerance wanted) : tolerance(wanted.value) {}
  double operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) const {
    double residuals[kRanges], jacobian[3 * kRanges], work[5 * 3 + kRanges];
    int pivots[3];
    lmder1(minpack_ranges, const_cast<RangeProblem*>(&problem), kRanges, 3, x_m.data(), residuals, jacobian,
           kRanges, tolerance, pivots, work, 5 * 3 + kRanges);
    return std::numeric_limits<double>::quiet_NaN();
  }
};

int gsl_residuals(const gsl_vector* parameters, void* data, gsl_vector* residuals) {
  const auto& problem = *static_cast<const RangeProblem*>(data);
  const Eigen::Map<const Eigen::Vector3d> x(parameters->data);
  for (int i = 0; i < kRanges; ++i)
    gsl_vector_set(residuals, static_cast<std::size_t>(i),
                   (x - problem.sensor_m[i]).norm() - problem.range_m[i]);
  return GSL_SUCCESS;
}

int gsl_jacobian(const gsl_vector* parameters, void* data, gsl_matrix* jacobian) {
  const auto& problem = *static_cast<const RangeProblem*>(data);
  const Eigen::Map<const Eigen::Vector3d> x(parameters->data);
  for (int i = 0; i < kRanges; ++i) {
    const Eigen::Vector3d unit = (x - problem.sensor_m[i]).normalized();
    for (int axis = 0; axis < 3; ++axis)
      gsl_matrix_set(jacobian, static_cast<std::size_t>(i), static_cast<std::size_t>(axis), unit[axis]);
  }
  return GSL_SUCCESS;
}

struct GslLm {
  Tolerance tolerance;
  gsl_multifit_nlinear_workspace* work;

  explicit GslLm(Tolerance wanted) : tolerance(wanted) {
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.trs = gsl_multifit_nlinear_trs_lm;
    work = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, kRanges, 3);
    gsl_set_error_handler_off();
  }
  GslLm(const GslLm&) = delete;
  GslLm& operator=(const GslLm&) = delete;
  ~GslLm() { gsl_multifit_nlinear_free(work); }

  int operator()(const RangeProblem& problem, Eigen::Vector3d& x_m) const {
    gsl_multifit_nlinear_fdf functions{};
    functions.f = gsl_residuals;
    functions.df = gsl_jacobian;
    functions.n = kRanges;
    functions.p = 3;
    functions.params = const_cast<RangeProblem*>(&problem);
    const gsl_vector_view start = gsl_vector_view_array(x_m.data(), 3);
    gsl_multifit_nlinear_init(&start.vector, &functions, work);
    int why = 0;
    gsl_multifit_nlinear_driver(kMostIterations, tolerance.rule == 0 ? tolerance.value : 0.0,
                                tolerance.rule == 1 ? tolerance.value : 0.0, 0.0, nullptr, nullptr, &why,
                                work);
    x_m = Eigen::Map<const Eigen::Vector3d>(work->x->data);
    return static_cast<int>(gsl_multifit_nlinear_niter(work));
  }
};

}  // namespace

std::vector<Contestant> minpack_contestants() {
  return {one_at_a_time<EigenLm>("Eigen LevenbergMarquardt", {"ftol", "xtol", "gtol"}),
          one_at_a_time<Cminpack>("cminpack lmder1", {"tol"}),
          one_at_a_time<GslLm>("GSL multifit_nlinear lm", {"xtol", "gtol"})};
}

}  // namespace trilat
