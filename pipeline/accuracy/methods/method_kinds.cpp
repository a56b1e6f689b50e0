// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_kinds.h"

#include <algorithm>
#include <cmath>

#include "datasets/base/error.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

constexpr Range kFactor{1e-3, 1e3};

void range_sigma(Fields& f, double& sigma_m) {
  if (!f.writes()) sigma_m = kUsualRangeSigma_m;
  f("range_sigma_m", sigma_m,
    opt("Standard deviation of a range, which says whether ranges decide the side of the sensors' plane",
        {0.0, 10.0}));
}

void linear_settings(Fields& f, MethodSpec& m) {
  const std::string all_pairs = "all_pairs";
  std::string reference = m.linear.reference == LinearReference::all_pairs ? all_pairs : m.reference;
  f("reference", reference, opt("Sensor whose sphere is subtracted, or all_pairs; empty: the first"));
  if (f.reads()) {
    m.linear.reference = reference == all_pairs ? LinearReference::all_pairs : LinearReference::one_sensor;
    m.reference = reference == all_pairs ? "" : reference;
  }
  range_sigma(f, m.linear.range_sigma_m);
}

void descent_settings(Fields& f, NonlinearOptions& o) {
  f("stop", o.stop,
    opt("Stopping rule. printed: eq. 19 as printed; objective: the change of the objective; step: the length "
        "of the step"));
  f("threshold_cm2", o.threshold_m2, opt("C of eq. 19", kPositive, kSquareMetresPerSquareCentimetre));
  f("step_tolerance_m", o.step_tolerance_m, opt("Length of the last step, for the rule step", kPositive));
  f("max_iterations", o.max_iterations, opt("Largest number of iterations of each descent", {1.0, 1e6}));
  range_sigma(f, o.range_sigma_m);
  f("start", o.start,
    opt("Point at which a descent begins. squared_ranges: the exact minimum of the squared-range problem; "
        "linear: the method linear; guess: the mean of the sensors' own positions"));
  if (const std::string problem = contradiction_in(o); f.reads() && !problem.empty())
    f.refuse("damping", problem);
}

void nonlinear_settings(Fields& f, MethodSpec& m) {
  NonlinearOptions& o = m.nonlinear;
  f("gradient", o.gradient, opt("Gradient: eq. 17 as printed, or corrected"));
  f("damping", o.damping,
    opt("Damping of the step. none: as printed; lm: Levenberg-Marquardt from both sides of the sensors' "
        "plane"));
  f("printed_unit_m", o.printed_unit_m, opt("Unit of length of the printed gradient", kPositive));
  descent_settings(f, o);
}

// Gradient and damping are no choice.
void newton_settings(Fields& f, MethodSpec& m) {
  if (f.reads()) m.nonlinear.curvature = Curvature::newton;
  descent_settings(f, m.nonlinear);
}

void range_bearing_settings(Fields& f, MethodSpec& m) {
  RangeBearingOptions& o = m.range_bearing;
  if (!f.writes()) {
    m.sigma_is_estimated = true;
    o.loss = Loss::cauchy;
  }
  f.named("sigma", m.sigma_is_estimated, kStatedOrEstimated,
          opt("Source of the standard deviations. stated: the next two keys; estimated: the disagreement of "
              "the sensors in the other half of the take, and the stated values of joints for which it gives "
              "none"));
  f("range_sigma_m", o.sigma.range_m,
    opt("Standard deviation of a sensor's position along its ray", {1e-6, 1e3}));
  f("bearing_sigma_m", o.sigma.bearing_m,
    opt("Standard deviation of a sensor's position across its ray, in each of both directions", {1e-6, 1e3}));
  f("inferred_factor", o.sigma.inferred_factor,
    opt("Factor on both for an inferred joint; estimated, too, where sigma is", kFactor));
  f("loss", o.loss, opt("Loss of a sensor's residual in standard deviations"));
  f("loss_scale", o.loss_scale, opt("Scale of Cauchy's loss, in standard deviations", kFactor));
}

// The settings that methods over time share.
template <class Options>
void motion_settings(Fields& f, Options& o) {
  f("sigma_m", o.sigma_m, opt("Standard deviation of a sensor's position, an axis", {1e-6, 10.0}));
  f("inferred_factor", o.inferred_factor, opt("Factor on sigma_m for an inferred joint", kFactor));
  f("acceleration_density_m2_s3", o.acceleration_density_m2_s3,
    opt("Spectral density of the white acceleration that drives the motion", {1e-9, 1e9}));
  f("longest_gap_s", o.longest_gap_s, opt("Longest gap across which there are answers", {1e-3, 3600.0}));
}

void kalman_settings(Fields& f, MethodSpec& m) {
  motion_settings(f, m.kalman);
  f("gate_sigma", m.kalman.gate_sigma,
    opt("Distance in standard deviations beyond which a position is left out", {1.0, 1e6}));
}

void rts_settings(Fields& f, MethodSpec& m) {
  if (f.reads()) m.kalman.smooth = true;
  kalman_settings(f, m);
}

void window_settings(Fields& f, MethodSpec& m) {
  BoneSmootherOptions& o = m.bones;
  f.removed("window_s", "the whole take is one problem");
  motion_settings(f, o);
  f("bone_sigma_m", o.bone_sigma_m,
    opt("Standard deviation of a bone's length from its median over the take", {1e-4, 10.0}));
  f("loss_scale_m", o.loss_scale_m, opt("Scale of Cauchy's loss", {1e-3, 10.0}));
}

RangeProblem ranges_from(const JointInstant& instant, SensorMask sensors) {
  if (sensors == kAllSensors) return instant.ranges;
  return ranges_of(instant.observations, instant.world_from_sensor, sensors);
}

PointEstimate evaluate_nonlinear(const Method& m, const JointInstant& instant, SensorMask sensors) {
  return solve_nonlinear(ranges_from(instant, sensors), m.spec.nonlinear);
}

void evaluate_nonlinear(const Method& method, std::span<const JointInstant> instants,
                        std::span<PointEstimate> estimates) {
  std::vector<RangeProblem> problems;
  problems.reserve(instants.size());
  for (const JointInstant& instant : instants)
    problems.push_back(ranges_from(instant, sensors_of(method, instant)));
  solve_nonlinear(problems, method.spec.nonlinear, estimates);
}

template <class Options>
Options among(Options options, SensorMask sensors) {
  options.allowed = sensors;
  return options;
}

}  // namespace

const std::vector<MethodKind>& method_kinds() {
  static const std::vector<MethodKind> kinds{
      {.name = "linear",
       .what = "least squares on differences of spheres",
       .source = "compared system 1 of the paper",
       .needs_ranges = true,
       .settings = linear_settings,
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_linear(ranges_from(instant, sensors), m.spec.linear);
           }},
      {.name = "geometric",
       .what = "three spheres in closed form; of both solutions the one near the sensors' own positions",
       .source = "compared system 2 of the paper",
       .needs_ranges = true,
       .sensors = 3,
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_geometric(ranges_from(instant, sensors),
                                    {{m.sensors[0], m.sensors[1], m.sensors[2]}});
           }},
      {.name = "nonlinear",
       .what = "least squares on ranges by Gauss-Newton",
       .source = "eq. 9 to 19, errata E7, E8, E10; Beck, Stoica and Li 2008",
       .needs_ranges = true,
       .settings = nonlinear_settings,
       .evaluate = evaluate_nonlinear,
       .evaluate_many = evaluate_nonlinear},
      {.name = "newton",
       .what = "the same minimum with the full Hessian",
       .source = "eq. 10; Nocedal and Wright, Numerical Optimization, chapter 10",
       .needs_ranges = true,
       .settings = newton_settings,
       .evaluate = evaluate_nonlinear,
       .evaluate_many = evaluate_nonlinear},
      {.name = "ceres",
       .what = "the same minimum by Ceres: a second opinion",
       .source = "eq. 10; Agarwal and Mierle, Ceres Solver",
       .needs_ranges = true,
       .settings = [](Fields& f, MethodSpec& m) { range_sigma(f, m.ceres.range_sigma_m); },
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_ceres(ranges_from(instant, sensors), m.spec.ceres);
           }},
      {.name = "range_bearing",
       .what =
           "the most likely point, given each sensor's distance and direction with an uncertainty of its own "
           "for each of both",
       .source = "maximum likelihood; eq. 10 without its second term",
       .needs_ranges = true,
       .calibrates = true,
       .settings = range_bearing_settings,
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             RangeBearingOptions options = among(m.spec.range_bearing, sensors);
             if (m.spec.sigma_is_estimated && std::isfinite(instant.sigma.range_m))
               options.sigma = instant.sigma;
             return solve_range_bearing(instant.observations, instant.world_from_sensor, options);
           }},
      {.name = "mean",
       .what = "the mean of the sensors' positions of the joint",
       .source = "baseline",
       .needs_ranges = false,
       .settings =
           [](Fields& f, MethodSpec& m) {
             f("outlier_m", m.mean.outlier_m,
               opt("Distance from the median beyond which the farthest position is left out; 0: none is",
                   {0.0, 10.0}));
           },
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_mean(instant.observations, among(m.spec.mean, sensors));
           }},
      {.name = "tracked_mean",
       .what = "the mean of those that are tracked, where any is",
       .source = "baseline",
       .needs_ranges = false,
       .evaluate =
           [](const Method&, const JointInstant& instant, SensorMask sensors) {
             return solve_mean(instant.observations, {.allowed = sensors, .prefer_tracked = true});
           }},
      {.name = "single",
       .what = "one sensor alone",
       .source = "baseline",
       .needs_ranges = false,
       .sensors = 1,
       .evaluate = [](const Method& m, const JointInstant& instant,
                      SensorMask) { return solve_single_sensor(instant.observations, {m.sensors[0]}); }},
      {.name = "median",
       .what = "the point from which the distances to the sensors' positions sum to the least",
       .source = "Vardi and Zhang 2000",
       .needs_ranges = false,
       .evaluate =
           [](const Method&, const JointInstant& instant, SensorMask sensors) {
             return solve_median(instant.observations, {.allowed = sensors});
           }},
      {.name = "kalman",
       .what = "each joint's path by itself, filtered as it comes",
       .source = "Kalman 1960",
       .needs_ranges = false,
       .settings = kalman_settings,
       .over_time = solve_joints},
      {.name = "rts",
       .what = "each joint's path by itself, smoothed forwards and backwards",
       .source = "Rauch, Tung and Striebel 1965",
       .needs_ranges = false,
       .settings = rts_settings,
       .over_time = solve_joints},
      {.name = "window",
       .what = "all joints together, smoothed forwards and backwards with bones of constant length",
       .source = "the motion of rts with Cauchy's loss",
       .needs_ranges = false,
       .settings = window_settings,
       .over_time = solve_bones}};
  return kinds;
}

const MethodKind& external_kind() {
  static const MethodKind kind{
      .name = "external",
      .what = "joints that another method or system gave",
      .source = "the take's file",
      .needs_ranges = false,
      .over_time = [](const Method&, const TrajectoryInput&, const OverTimeCalls&, MethodTrajectories&) {}};
  return kind;
}

const MethodKind& method_kind(std::string_view name) {
  const auto found =
      std::ranges::find_if(method_kinds(), [&](const MethodKind& kind) { return kind.name == name; });
  TRILAT_CHECK(found != method_kinds().end(), "there is a method of that name");
  return *found;
}

}  // namespace trilat
