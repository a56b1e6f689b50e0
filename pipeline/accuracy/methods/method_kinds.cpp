// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_kinds.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

const std::vector<std::string> kGradients{"printed", "corrected"};
const std::vector<std::string> kDampings{"none", "lm"};
const std::vector<std::string> kStops{"printed", "objective", "step"};
const std::vector<std::string> kStarts{"squared_ranges", "linear", "guess"};
const std::vector<std::string> kLosses{"squares", "cauchy"};

constexpr const char* kRangeSigma =
    "standard deviation of a range: whether ranges decide the side of the sensors' plane";

void range_sigma(Settings& s, double& sigma_m) {
  if (s.reading()) sigma_m = kUsualRangeSigma_m;
  s("range_sigma_m", sigma_m, {0.0, 10.0}, kRangeSigma);
}

void linear_settings(Settings& s, MethodSpec& m) {
  const std::string all_pairs = "all_pairs";
  std::string reference = m.linear.reference == LinearReference::all_pairs ? all_pairs : m.reference;
  s("reference", reference, "the sensor whose sphere is subtracted, or all_pairs; empty: the first");
  if (reference == all_pairs)
    m.linear.reference = LinearReference::all_pairs;
  else
    m.reference = reference;
  range_sigma(s, m.linear.range_sigma_m);
}

void descent_settings(Settings& s, NonlinearOptions& o) {
  s.choice("stop", o.stop, kStops, "the rule: as printed (eq. 19), of the objective, or of the step");
  s.positive("threshold_cm2", o.threshold_m2, "C of eq. 19", kSquareMetresPerSquareCentimetre);
  s.positive("step_tolerance_m", o.step_tolerance_m, "ends with `stop`: `step`");
  s("max_iterations", o.max_iterations, {1, 1'000'000}, "of each descent");
  range_sigma(s, o.range_sigma_m);
  s.choice("start", o.start, kStarts, "of the descent");
  if (const std::string problem = contradiction_in(o); s.reading() && !problem.empty())
    s.reading()->refuse("damping", problem);
}

void nonlinear_settings(Settings& s, MethodSpec& m) {
  NonlinearOptions& o = m.nonlinear;
  s.choice("gradient", o.gradient, kGradients, "as printed (eq. 17) or corrected");
  s.choice("damping", o.damping, kDampings,
           "none, as printed, or Levenberg-Marquardt from both sides of the sensors' plane");
  s.positive("printed_unit_m", o.printed_unit_m, "unit of length of the printed gradient");
  descent_settings(s, o);
}

// Gradient and damping are no choice.
void newton_settings(Settings& s, MethodSpec& m) {
  m.nonlinear.curvature = Curvature::newton;
  descent_settings(s, m.nonlinear);
}

void range_bearing_settings(Settings& s, MethodSpec& m) {
  RangeBearingOptions& o = m.range_bearing;
  if (s.reading()) {
    m.sigma_is_estimated = true;
    o.loss = Loss::cauchy;
  }
  s.choice("sigma", m.sigma_is_estimated, stated_or_estimated(),
           "stated: the next two; estimated: from the disagreement of the sensors in the other half of the "
           "take, and stated where that tells nothing");
  s("range_sigma_m", o.sigma.range_m, {1e-6, 1e3}, "standard deviation of a sensor's position along its ray");
  s("bearing_sigma_m", o.sigma.bearing_m, {1e-6, 1e3}, "and across it, in each of both directions");
  s("inferred_factor", o.sigma.inferred_factor, {1e-3, 1e3},
    "on both, of an inferred joint; where sigma is estimated it is, too");
  s.choice("loss", o.loss, kLosses, "of a sensor's residual in sigmas");
  s("loss_scale", o.loss_scale, {1e-3, 1e3}, "of cauchy, in sigmas");
}

// The settings that methods over time share.
template <class Options>
void motion_settings(Settings& s, Options& o) {
  s("sigma_m", o.sigma_m, {1e-6, 10.0}, "of a position, an axis");
  s("inferred_factor", o.inferred_factor, {1e-3, 1e3}, "on sigma_m, of an inferred joint");
  s("acceleration_density_m2_s3", o.acceleration_density_m2_s3, {1e-9, 1e9},
    "of the white acceleration that drives the motion");
  s("longest_gap_s", o.longest_gap_s, {1e-3, 3600.0}, "nothing is answered across a longer one");
}

void kalman_settings(Settings& s, MethodSpec& m) {
  motion_settings(s, m.kalman);
  s("gate_sigma", m.kalman.gate_sigma, {1.0, 1e6},
    "positions that are less likely than so many standard deviations are left out");
}

void rts_settings(Settings& s, MethodSpec& m) {
  m.kalman.smooth = true;
  kalman_settings(s, m);
}

void window_settings(Settings& s, MethodSpec& m) {
  BoneSmootherOptions& o = m.bones;
  if (s.reading()) s.reading()->removed("window_s", "the whole take is one problem");
  motion_settings(s, o);
  s("bone_sigma_m", o.bone_sigma_m, {1e-4, 10.0},
    "by how much a bone's length differs from its median over the take");
  s("loss_scale_m", o.loss_scale_m, {1e-3, 10.0}, "of Cauchy's loss");
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
       .settings = [](Settings& s, MethodSpec& m) { range_sigma(s, m.ceres.range_sigma_m); },
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
           [](Settings& s, MethodSpec& m) {
             s("outlier_m", m.mean.outlier_m, {0.0, 10.0},
               "the position farthest from the median is left out where it is farther than this; 0: none is");
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
      .over_time = [](const Method&, const SeenInTime&, const OverTimeCalls&, MethodPaths&) {}};
  return kind;
}

const MethodKind& method_kind(std::string_view name) {
  const auto found =
      std::ranges::find_if(method_kinds(), [&](const MethodKind& kind) { return kind.name == name; });
  TRILAT_CHECK(found != method_kinds().end(), "there is a method of that name");
  return *found;
}

}  // namespace trilat
