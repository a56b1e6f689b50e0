// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_kinds.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/settings.h"
#include "datasets/base/strict_json.h"
#include "datasets/base/units.h"

namespace trilat {
namespace {

const std::vector<std::string> kGradients{"printed", "corrected"};
const std::vector<std::string> kDampings{"none", "lm"};
const std::vector<std::string> kStops{"printed", "objective", "step"};
const std::vector<std::string> kStarts{"squared_ranges", "linear", "hint"};
const std::vector<std::string> kLosses{"squares", "huber", "cauchy"};

template <class Enum>
Enum enum_choice(JsonObject& object, const std::string& key, const std::vector<std::string>& names,
                 Enum fallback) {
  return static_cast<Enum>(object.choice(key, names, static_cast<std::size_t>(fallback)));
}

template <class Enum>
const std::string& word_of(const std::vector<std::string>& names, Enum choice) {
  return names[static_cast<std::size_t>(choice)];
}

double read_range_sigma_m(JsonObject& object) {
  const double sigma_m = number_within(object, "range_sigma_m", kUsualRangeSigma_m, 0.0, 10.0);
  object.about({{"range_sigma_m",
                 "standard deviation of a range: whether ranges decide the side of the sensors' plane"}});
  return sigma_m;
}

void read_linear(JsonObject& object, MethodSpec& method) {
  method.linear.range_sigma_m = read_range_sigma_m(object);
  method.reference = object.text("reference", "");
  object.about({{"reference", "the sensor whose sphere is subtracted, or all_pairs; empty: the first"}});
  if (method.reference != "all_pairs") return;
  method.linear.reference = LinearReference::all_pairs;
  method.reference.clear();
}

void write_linear(const MethodSpec& m, Json& entry) {
  entry["reference"] = m.linear.reference == LinearReference::all_pairs ? "all_pairs" : m.reference;
  entry["range_sigma_m"] = m.linear.range_sigma_m;
}

void read_descent(JsonObject& object, NonlinearOptions& o) {
  o.stop = enum_choice(object, "stop", kStops, o.stop);
  o.threshold_m2 = object.positive("threshold_cm2", o.threshold_m2 / kSquareMetresPerSquareCentimetre) *
                   kSquareMetresPerSquareCentimetre;
  o.step_tolerance_m = object.positive("step_tolerance_m", o.step_tolerance_m);
  o.max_iterations = static_cast<int>(
      count_within(object, "max_iterations", static_cast<std::uint64_t>(o.max_iterations), 1, 1'000'000));
  o.range_sigma_m = read_range_sigma_m(object);
  o.start = enum_choice(object, "start", kStarts, o.start);
  o.loss = enum_choice(object, "loss", kLosses, o.loss);
  o.loss_scale_m = object.positive("loss_scale_m", o.loss_scale_m);
  object.about({{"stop", "the rule: as printed (eq. 18), of the objective, or of the step"},
                {"threshold_cm2", "C of eq. 18"},
                {"step_tolerance_m", "ends with `stop`: `step`"},
                {"max_iterations", "of each descent"},
                {"start", "of the descent"},
                {"loss", "of the residuals"},
                {"loss_scale_m", "of huber and cauchy"}});
  if (const std::string problem = contradiction_in(o); !problem.empty())
    object.refuse(o.loss == Loss::squares ? "damping" : "loss", problem);
}

void write_descent(const NonlinearOptions& o, Json& entry) {
  entry["stop"] = word_of(kStops, o.stop);
  entry["threshold_cm2"] = o.threshold_m2 / kSquareMetresPerSquareCentimetre;
  entry["step_tolerance_m"] = o.step_tolerance_m;
  entry["max_iterations"] = o.max_iterations;
  entry["range_sigma_m"] = o.range_sigma_m;
  entry["start"] = word_of(kStarts, o.start);
  entry["loss"] = word_of(kLosses, o.loss);
  entry["loss_scale_m"] = o.loss_scale_m;
}

void read_nonlinear(JsonObject& object, MethodSpec& method) {
  NonlinearOptions& o = method.nonlinear;
  o.gradient = enum_choice(object, "gradient", kGradients, o.gradient);
  o.damping = enum_choice(object, "damping", kDampings, o.damping);
  o.printed_unit_m = object.positive("printed_unit_m", o.printed_unit_m);
  object.about({{"gradient", "as printed (eq. 12) or corrected"},
                {"damping", "none, as printed, or Levenberg-Marquardt from both sides of the sensors' plane"},
                {"printed_unit_m", "unit of length of the printed gradient"}});
  read_descent(object, o);
}

void write_nonlinear(const MethodSpec& m, Json& entry) {
  entry["gradient"] = word_of(kGradients, m.nonlinear.gradient);
  entry["damping"] = word_of(kDampings, m.nonlinear.damping);
  entry["printed_unit_m"] = m.nonlinear.printed_unit_m;
  write_descent(m.nonlinear, entry);
}

// Gradient and damping are no choice.
void read_newton(JsonObject& object, MethodSpec& method) {
  method.nonlinear.curvature = Curvature::newton;
  read_descent(object, method.nonlinear);
}

void write_newton(const MethodSpec& m, Json& entry) { write_descent(m.nonlinear, entry); }

void read_range_bearing(JsonObject& object, MethodSpec& method) {
  RangeBearingOptions& o = method.range_bearing;
  method.sigma_is_estimated = object.choice("sigma", stated_or_estimated(), 1) == 1;
  setting(object, "range_sigma_m", o.sigma.range_m, {1e-6, 1e3},
          "standard deviation of a sensor's position along its ray");
  setting(object, "bearing_sigma_m", o.sigma.bearing_m, {1e-6, 1e3},
          "and across it, in each of both directions");
  setting(object, "inferred_factor", o.sigma.inferred_factor, {1e-3, 1e3},
          "on both, of an inferred joint; where sigma is estimated it is, too");
  o.loss = enum_choice(object, "loss", kLosses, Loss::cauchy);
  setting(object, "loss_scale", o.loss_scale, {1e-3, 1e3}, "of huber and cauchy, in sigmas");
  object.about({{"sigma",
                 "stated: the next two; estimated: from the disagreement of the sensors in the other half of "
                 "the take, and stated where that tells nothing"},
                {"loss", "of a sensor's residual in sigmas"}});
}

void write_range_bearing(const MethodSpec& m, Json& entry) {
  const RangeBearingOptions& o = m.range_bearing;
  entry["sigma"] = stated_or_estimated()[m.sigma_is_estimated ? 1 : 0];
  entry["range_sigma_m"] = o.sigma.range_m;
  entry["bearing_sigma_m"] = o.sigma.bearing_m;
  entry["inferred_factor"] = o.sigma.inferred_factor;
  entry["loss"] = word_of(kLosses, o.loss);
  entry["loss_scale"] = o.loss_scale;
}

void read_weighted_mean(JsonObject& object, MethodSpec& method) {
  WeightedMeanOptions& o = method.weighted;
  setting(object, "inferred_weight", o.inferred_weight, {0.0, 1.0},
          "of an inferred joint, where a tracked one has 1");
  setting(object, "by_depth_noise", o.by_depth_noise,
          "weights are also inverse to the variance of depth at the joint's range");
}

void write_weighted_mean(const MethodSpec& m, Json& entry) {
  entry["inferred_weight"] = m.weighted.inferred_weight;
  entry["by_depth_noise"] = m.weighted.by_depth_noise;
}

// What the methods over time have in common.
template <class Options>
void read_motion(JsonObject& object, Options& o) {
  setting(object, "sigma_m", o.sigma_m, {1e-6, 10.0}, "of a position, an axis");
  setting(object, "inferred_factor", o.inferred_factor, {1e-3, 1e3}, "on sigma_m, of an inferred joint");
  setting(object, "acceleration_density_m2_s3", o.acceleration_density_m2_s3, {1e-9, 1e9},
          "of the white acceleration that drives the motion");
  setting(object, "longest_gap_s", o.longest_gap_s, {1e-3, 3600.0},
          "nothing is answered across a longer one");
}

template <class Options>
void write_motion(const Options& o, Json& entry) {
  entry["sigma_m"] = o.sigma_m;
  entry["inferred_factor"] = o.inferred_factor;
  entry["acceleration_density_m2_s3"] = o.acceleration_density_m2_s3;
  entry["longest_gap_s"] = o.longest_gap_s;
}

void read_kalman(JsonObject& object, MethodSpec& method) {
  read_motion(object, method.kalman);
  setting(object, "gate_sigma", method.kalman.gate_sigma, {1.0, 1e6},
          "positions farther from the prediction are left out");
}

void read_rts(JsonObject& object, MethodSpec& method) {
  method.kalman.smooth = true;
  read_kalman(object, method);
}

void write_kalman(const MethodSpec& m, Json& entry) {
  write_motion(m.kalman, entry);
  entry["gate_sigma"] = m.kalman.gate_sigma;
}

void read_window(JsonObject& object, MethodSpec& method) {
  BoneWindowOptions& o = method.window;
  read_motion(object, o);
  setting(object, "window_s", o.window_s, {0.1, 60.0}, "length of a window; windows overlap by half");
  setting(object, "bone_sigma_m", o.bone_sigma_m, {1e-4, 10.0},
          "by how much a bone's length differs from its median over the take");
  setting(object, "loss_scale_m", o.loss_scale_m, {1e-3, 10.0}, "of Cauchy's loss");
}

void write_window(const MethodSpec& m, Json& entry) {
  write_motion(m.window, entry);
  entry["window_s"] = m.window.window_s;
  entry["bone_sigma_m"] = m.window.bone_sigma_m;
  entry["loss_scale_m"] = m.window.loss_scale_m;
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
       .read = read_linear,
       .write = write_linear,
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
       .read = read_nonlinear,
       .write = write_nonlinear,
       .evaluate = evaluate_nonlinear,
       .evaluate_many = evaluate_nonlinear},
      {.name = "newton",
       .what = "the same minimum with the full Hessian",
       .source = "eq. 10; Nocedal and Wright, Numerical Optimization, chapter 10",
       .needs_ranges = true,
       .read = read_newton,
       .write = write_newton,
       .evaluate = evaluate_nonlinear,
       .evaluate_many = evaluate_nonlinear},
      {.name = "ceres",
       .what = "the same minimum by Ceres: a second opinion",
       .source = "eq. 10; Agarwal and Mierle, Ceres Solver",
       .needs_ranges = true,
       .read = [](JsonObject& object,
                  MethodSpec& method) { method.ceres.range_sigma_m = read_range_sigma_m(object); },
       .write = [](const MethodSpec& m, Json& entry) { entry["range_sigma_m"] = m.ceres.range_sigma_m; },
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_ceres(ranges_from(instant, sensors), m.spec.ceres);
           }},
      {.name = "range_bearing",
       .what = "the most likely place when both the distance from a sensor and the direction are known, each "
               "as well as its sigma says: nonlinear, triangulation and the mean are its limits",
       .source = "maximum likelihood; eq. 10 without its second term",
       .needs_ranges = true,
       .calibrates = true,
       .read = read_range_bearing,
       .write = write_range_bearing,
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
       .evaluate = [](const Method&, const JointInstant& instant,
                      SensorMask sensors) { return solve_mean(instant.observations, {.allowed = sensors}); }},
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
      {.name = "weighted_mean",
       .what = "the mean with weights by tracking state and depth noise",
       .source = "Fankhauser et al. 2015",
       .needs_ranges = false,
       .read = read_weighted_mean,
       .write = write_weighted_mean,
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_weighted_mean(instant.observations, among(m.spec.weighted, sensors));
           }},
      {.name = "median",
       .what = "the point from which the distances to the sensors' positions sum to the least",
       .source = "Vardi and Zhang 2000",
       .needs_ranges = false,
       .evaluate =
           [](const Method&, const JointInstant& instant, SensorMask sensors) {
             return solve_median(instant.observations, {.allowed = sensors});
           }},
      {.name = "robust_mean",
       .what = "M-estimate with Cauchy's loss, started from the median",
       .source = "Huber and Ronchetti, Robust Statistics",
       .needs_ranges = false,
       .read =
           [](JsonObject& object, MethodSpec& method) {
             setting(object, "scale_m", method.robust.scale_m, {1e-6, 10.0}, "of Cauchy's loss");
           },
       .write = [](const MethodSpec& m, Json& entry) { entry["scale_m"] = m.robust.scale_m; },
       .evaluate =
           [](const Method& m, const JointInstant& instant, SensorMask sensors) {
             return solve_robust_mean(instant.observations, among(m.spec.robust, sensors));
           }},
      {.name = "kalman",
       .what = "each joint's path by itself, filtered",
       .source = "Kalman 1960",
       .needs_ranges = false,
       .read = read_kalman,
       .write = write_kalman,
       .over_time = solve_joints},
      {.name = "rts",
       .what = "each joint's path by itself, smoothed",
       .source = "Rauch, Tung and Striebel 1965",
       .needs_ranges = false,
       .read = read_rts,
       .write = write_kalman,
       .over_time = solve_joints},
      {.name = "window",
       .what = "all joints together over a window of time, with bones of constant length",
       .source = "the motion of rts with Cauchy's loss, by Ceres",
       .needs_ranges = false,
       .read = read_window,
       .write = write_window,
       .over_time = solve_windows}};
  return kinds;
}

const MethodKind& method_kind(std::string_view name) {
  const auto found =
      std::ranges::find_if(method_kinds(), [&](const MethodKind& kind) { return kind.name == name; });
  TRILAT_CHECK(found != method_kinds().end(), "there is a method of that name");
  return *found;
}

}  // namespace trilat
