// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/method_spec.h"

#include <nlohmann/json.hpp>

#include "datasets/base/json_ranges.h"
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

double read_range_sigma_m(JsonObject& object) {
  return number_within(object, "range_sigma_m", kUsualRangeSigma_m, 0.0, 10.0);
}

void read_sets(JsonObject& object, MethodSpec& method) {
  method.each = count_within(object, "each", 1, 1, kMaxSensors);
  method.most_sets = count_within(object, "most_sets", method.most_sets, 1, 1000);
  if (method.kind == MethodKind::geometric && method.each != 3)
    object.refuse("each", "must be 3, of which geometric trilateration uses as many");
  if (method.kind == MethodKind::single && method.each != 1)
    object.refuse("each", "must be 1 of kind single");
}

void read_linear(JsonObject& object, MethodSpec& method) {
  method.linear.range_sigma_m = read_range_sigma_m(object);
  method.reference = object.text("reference", "");
  if (method.reference != "all_pairs") return;
  method.linear.reference = LinearReference::all_pairs;
  method.reference.clear();
}

void read_nonlinear(JsonObject& object, MethodSpec& method) {
  NonlinearOptions& o = method.nonlinear;
  if (method.kind == MethodKind::newton) {
    o.curvature = Curvature::newton;
  } else {
    o.gradient = enum_choice(object, "gradient", kGradients, o.gradient);
    o.damping = enum_choice(object, "damping", kDampings, o.damping);
    o.printed_unit_m = object.positive("printed_unit_m", o.printed_unit_m);
  }
  o.stop = enum_choice(object, "stop", kStops, o.stop);
  o.threshold_m2 = object.positive("threshold_cm2", o.threshold_m2 / kSquareMetresPerSquareCentimetre) *
                   kSquareMetresPerSquareCentimetre;
  o.step_tolerance_m = object.positive("step_tolerance_m", o.step_tolerance_m);
  const std::uint64_t limit = object.count("max_iterations", static_cast<std::uint64_t>(o.max_iterations));
  if (limit < 1 || limit > 1'000'000) object.refuse("max_iterations", "must be 1 to 1000000");
  o.max_iterations = static_cast<int>(limit);
  o.range_sigma_m = read_range_sigma_m(object);
  o.start = enum_choice(object, "start", kStarts, o.start);
  o.loss = enum_choice(object, "loss", kLosses, o.loss);
  o.loss_scale_m = object.positive("loss_scale_m", o.loss_scale_m);
  if (const std::string problem = contradiction_in(o); !problem.empty())
    object.refuse(o.loss == Loss::squares ? "damping" : "loss", problem);
}

void read_occlusion(JsonObject& object, MethodSpec& method) {
  method.occlusion = enum_choice(object, "occlusion", occlusion_rule_names(), method.occlusion);
  if (method.occlusion == OcclusionRule::off) return;
  if (method.kind == MethodKind::single)
    object.refuse("occlusion", "leaves a method of one sensor nothing to choose from");
  method.inferred_is_occluded = object.boolean("inferred_is_occluded", method.inferred_is_occluded);
  const std::uint64_t fewest = count_within(object, "fewest_sensors", 1, 1, kMaxSensors);
  method.fewest_sensors = static_cast<int>(fewest);
}

// What the methods over time have in common.
template <class Options>
void read_motion(JsonObject& object, Options& o) {
  o.sigma_m = number_within(object, "sigma_m", o.sigma_m, 1e-6, 10.0);
  o.inferred_factor = number_within(object, "inferred_factor", o.inferred_factor, 1e-3, 1e3);
  o.acceleration_density_m2_s3 =
      number_within(object, "acceleration_density_m2_s3", o.acceleration_density_m2_s3, 1e-9, 1e9);
  o.longest_gap_s = number_within(object, "longest_gap_s", o.longest_gap_s, 1e-3, 3600.0);
}

template <class Options>
void add_motion(const Options& o, Json& entry) {
  entry["sigma_m"] = o.sigma_m;
  entry["inferred_factor"] = o.inferred_factor;
  entry["acceleration_density_m2_s3"] = o.acceleration_density_m2_s3;
  entry["longest_gap_s"] = o.longest_gap_s;
}

void read_fusion(JsonObject& object, MethodSpec& method) {
  if (method.kind == MethodKind::weighted_mean) {
    WeightedMeanOptions& o = method.weighted;
    o.inferred_weight = share_within(object, "inferred_weight", o.inferred_weight);
    o.by_depth_noise = object.boolean("by_depth_noise", o.by_depth_noise);
  }
  if (method.kind == MethodKind::robust_mean)
    method.robust.scale_m = number_within(object, "scale_m", method.robust.scale_m, 1e-6, 10.0);
  if (method.kind == MethodKind::kalman || method.kind == MethodKind::rts) {
    KalmanOptions& o = method.kalman;
    o.smooth = method.kind == MethodKind::rts;
    read_motion(object, o);
    o.gate_sigma = number_within(object, "gate_sigma", o.gate_sigma, 1.0, 1e6);
  }
  if (method.kind == MethodKind::window) {
    BoneWindowOptions& o = method.window;
    read_motion(object, o);
    o.window_s = number_within(object, "window_s", o.window_s, 0.1, 60.0);
    o.bone_sigma_m = number_within(object, "bone_sigma_m", o.bone_sigma_m, 1e-4, 10.0);
    o.loss_scale_m = number_within(object, "loss_scale_m", o.loss_scale_m, 1e-3, 10.0);
  }
}

void add_fusion(const MethodSpec& m, Json& entry) {
  if (m.kind == MethodKind::weighted_mean) {
    entry["inferred_weight"] = m.weighted.inferred_weight;
    entry["by_depth_noise"] = m.weighted.by_depth_noise;
  }
  if (m.kind == MethodKind::robust_mean) entry["scale_m"] = m.robust.scale_m;
  if (m.kind == MethodKind::kalman || m.kind == MethodKind::rts) {
    add_motion(m.kalman, entry);
    entry["gate_sigma"] = m.kalman.gate_sigma;
  }
  if (m.kind == MethodKind::window) {
    add_motion(m.window, entry);
    entry["window_s"] = m.window.window_s;
    entry["bone_sigma_m"] = m.window.bone_sigma_m;
    entry["loss_scale_m"] = m.window.loss_scale_m;
  }
}

}  // namespace

const std::vector<std::string>& method_kind_names() {
  static const std::vector<std::string> names{
      "linear", "geometric",     "nonlinear", "newton",      "ceres",  "mean", "tracked_mean",
      "single", "weighted_mean", "median",    "robust_mean", "kalman", "rts",  "window"};
  return names;
}

const std::vector<std::string>& occlusion_rule_names() {
  static const std::vector<std::string> names{"off", "printed", "corrected", "depth"};
  return names;
}

std::vector<std::string> different_texts(JsonObject& object, const std::string& key) {
  std::vector<std::string> texts = object.texts(key, {});
  if (const std::string twice = first_repeated(texts); !twice.empty())
    object.refuse(key, "has \"" + twice + "\" twice");
  return texts;
}

MethodSpec read_method(JsonObject& object) {
  MethodSpec method;
  method.kind = static_cast<MethodKind>(object.choice("method", method_kind_names()));
  method.name = object.text("name", method_kind_names()[static_cast<std::size_t>(method.kind)]);
  if (method.name.empty() || method.name.size() > 60) object.refuse("name", "must have 1 to 60 characters");
  method.sensors = different_texts(object, "sensors");
  if (object.has("each")) read_sets(object, method);
  if (method.kind == MethodKind::linear) read_linear(object, method);
  if (method.kind == MethodKind::nonlinear || method.kind == MethodKind::newton)
    read_nonlinear(object, method);
  if (method.kind == MethodKind::ceres) method.ceres.range_sigma_m = read_range_sigma_m(object);
  if (method.kind == MethodKind::geometric && method.each == 0 && !method.sensors.empty() &&
      method.sensors.size() != 3)
    object.refuse("sensors", "must name the three sensors that geometric trilateration uses");
  read_fusion(object, method);
  read_occlusion(object, method);
  object.finish();
  return method;
}

Json resolved_json(const MethodSpec& m) {
  Json entry{{"method", method_kind_names()[static_cast<std::size_t>(m.kind)]},
             {"name", m.name},
             {"sensors", m.sensors}};
  if (m.each > 0) entry.update({{"each", m.each}, {"most_sets", m.most_sets}});
  if (m.kind == MethodKind::linear) {
    entry["reference"] = m.linear.reference == LinearReference::all_pairs ? "all_pairs" : m.reference;
    entry["range_sigma_m"] = m.linear.range_sigma_m;
  }
  if (m.kind == MethodKind::ceres) entry["range_sigma_m"] = m.ceres.range_sigma_m;
  if (m.kind == MethodKind::nonlinear || m.kind == MethodKind::newton) {
    const NonlinearOptions& o = m.nonlinear;
    if (m.kind == MethodKind::nonlinear) {  // of newton they are no choice
      entry["gradient"] = kGradients[static_cast<std::size_t>(o.gradient)];
      entry["damping"] = kDampings[static_cast<std::size_t>(o.damping)];
      entry["printed_unit_m"] = o.printed_unit_m;
    }
    entry["stop"] = kStops[static_cast<std::size_t>(o.stop)];
    entry["threshold_cm2"] = o.threshold_m2 / kSquareMetresPerSquareCentimetre;
    entry["step_tolerance_m"] = o.step_tolerance_m;
    entry["max_iterations"] = o.max_iterations;
    entry["range_sigma_m"] = o.range_sigma_m;
    entry["start"] = kStarts[static_cast<std::size_t>(o.start)];
    entry["loss"] = kLosses[static_cast<std::size_t>(o.loss)];
    entry["loss_scale_m"] = o.loss_scale_m;
  }
  add_fusion(m, entry);
  entry["occlusion"] = occlusion_rule_names()[static_cast<std::size_t>(m.occlusion)];
  if (m.occlusion != OcclusionRule::off) {
    entry["inferred_is_occluded"] = m.inferred_is_occluded;
    entry["fewest_sensors"] = m.fewest_sensors;
  }
  return entry;
}

}  // namespace trilat
