// SPDX-License-Identifier: MIT
#include "pipeline/study_spec.h"

#include <set>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/units.h"
#include "datasets/skeleton/skeleton.h"

namespace trilat {
namespace {

constexpr const char* kFormat = "trilat.study";

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

// A list of texts, none of which stands there twice.
std::vector<std::string> different_texts(JsonObject& object, const std::string& key) {
  std::vector<std::string> texts = object.texts(key, {});
  if (const std::string twice = first_repeated(texts); !twice.empty())
    object.refuse(key, "has \"" + twice + "\" twice");
  return texts;
}

void read_linear(JsonObject& object, MethodSpec& method) {
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
  o.same_residual_m = object.positive("same_residual_m", o.same_residual_m);
  o.start = enum_choice(object, "start", kStarts, o.start);
  o.loss = enum_choice(object, "loss", kLosses, o.loss);
  o.loss_scale_m = object.positive("loss_scale_m", o.loss_scale_m);
  if (const std::string problem = contradiction_in(o); !problem.empty())
    object.refuse(o.loss == Loss::squares ? "damping" : "loss", problem);
}

MethodSpec read_method(JsonObject& object) {
  MethodSpec method;
  method.kind = static_cast<MethodKind>(object.choice("method", method_kind_names()));
  method.name = object.text("name", method_kind_names()[static_cast<std::size_t>(method.kind)]);
  if (method.name.empty() || method.name.size() > 60) object.refuse("name", "must have 1 to 60 characters");
  method.sensors = different_texts(object, "sensors");
  if (method.kind == MethodKind::linear) read_linear(object, method);
  if (method.kind == MethodKind::nonlinear || method.kind == MethodKind::newton)
    read_nonlinear(object, method);
  if (method.kind == MethodKind::geometric && !method.sensors.empty() && method.sensors.size() != 3)
    object.refuse("sensors", "must name the three sensors that geometric trilateration uses");
  object.finish();
  return method;
}

std::vector<AlignmentKind> read_alignments(JsonObject& object) {
  std::vector<AlignmentKind> result;
  for (const std::string& word : different_texts(object, "alignments")) {
    const auto kind = alignment_from_name(word);
    if (!kind) object.refuse("alignments", "has \"" + word + "\"; known are: none, first, mean, rigid");
    result.push_back(*kind);
  }
  if (result.empty()) object.refuse("alignments", "must name at least one alignment");
  return result;
}

void check_names(JsonObject& object, const StudySpec& spec) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < spec.methods.size(); ++i)
    if (!names.insert(spec.methods[i].name).second)
      object.objects("methods")[i].refuse(
          "name", "is \"" + spec.methods[i].name + "\", which an earlier method has; give each its own name");
  for (const std::string& joint : spec.joints)
    if (!joint_from_name(joint)) object.refuse("joints", "has \"" + joint + "\", which is no joint");
}

}  // namespace

const std::vector<std::string>& method_kind_names() {
  static const std::vector<std::string> names{"linear", "geometric", "nonlinear",    "newton",
                                              "ceres",  "mean",      "tracked_mean", "single"};
  return names;
}

StudyKind study_kind(const Json& json, const std::string& place) {
  return static_cast<StudyKind>(
      JsonObject(json, place, "").choice("kind", {"accuracy", "threshold_sweep", "calibration"}));
}

StudySpec parse_study(const Json& json, const std::string& place, const std::filesystem::path& folder) {
  JsonObject object(json, place, "");
  StudySpec spec;
  if (object.text("format") != kFormat) object.refuse("format", std::string("must be \"") + kFormat + '"');
  if (object.integer("version") != 1) object.refuse("version", "must be 1");
  object.choice("kind", {"accuracy"});
  spec.name = object.text("name");
  if (const std::string campaign = object.text("campaign", ""); !campaign.empty())
    spec.campaign = folder / campaign;
  spec.sensors = different_texts(object, "sensors");
  spec.joints = different_texts(object, "joints");
  if (object.has("alignments")) spec.alignments = read_alignments(object);
  spec.rate_hz = object.positive("rate_hz", spec.rate_hz);
  if (spec.rate_hz > 1000.0) object.refuse("rate_hz", "must not be above 1000");
  spec.sensor_gap_s = object.positive("sensor_gap_s", spec.sensor_gap_s);
  spec.truth_gap_s = object.positive("truth_gap_s", spec.truth_gap_s);
  for (const char* gap : {"sensor_gap_s", "truth_gap_s"})
    if (object.number(gap, 0.0) > 3600.0) object.refuse(gap, "must not be longer than an hour");
  spec.cross_check_limit_m = object.positive("cross_check_limit_m", spec.cross_check_limit_m);
  for (JsonObject& entry : object.objects("methods")) spec.methods.push_back(read_method(entry));
  if (spec.methods.empty()) object.refuse("methods", "must hold at least one method");
  check_names(object, spec);
  object.finish();
  return spec;
}

StudySpec read_study(const std::filesystem::path& path) {
  return parse_study(read_json(path), path.string(), path.parent_path());
}

Json resolved_json(const StudySpec& spec) {
  Json methods = Json::array();
  for (const MethodSpec& m : spec.methods) {
    Json entry{{"method", method_kind_names()[static_cast<std::size_t>(m.kind)]},
               {"name", m.name},
               {"sensors", m.sensors}};
    if (m.kind == MethodKind::linear)
      entry["reference"] = m.linear.reference == LinearReference::all_pairs ? "all_pairs" : m.reference;
    if (m.kind == MethodKind::nonlinear || m.kind == MethodKind::newton) {
      const NonlinearOptions& o = m.nonlinear;
      entry["gradient"] = kGradients[static_cast<std::size_t>(o.gradient)];
      entry["damping"] = kDampings[static_cast<std::size_t>(o.damping)];
      entry["stop"] = kStops[static_cast<std::size_t>(o.stop)];
      entry["threshold_cm2"] = o.threshold_m2 / kSquareMetresPerSquareCentimetre;
      entry["step_tolerance_m"] = o.step_tolerance_m;
      entry["max_iterations"] = o.max_iterations;
      entry["printed_unit_m"] = o.printed_unit_m;
      entry["same_residual_m"] = o.same_residual_m;
      entry["start"] = kStarts[static_cast<std::size_t>(o.start)];
      entry["loss"] = kLosses[static_cast<std::size_t>(o.loss)];
      entry["loss_scale_m"] = o.loss_scale_m;
    }
    methods.push_back(entry);
  }
  Json alignments = Json::array();
  for (AlignmentKind kind : spec.alignments) alignments.push_back(std::string(name_of(kind)));
  return {{"format", kFormat},
          {"version", 1},
          {"kind", "accuracy"},
          {"name", spec.name},
          {"sensors", spec.sensors},
          {"joints", spec.joints},
          {"alignments", alignments},
          {"rate_hz", spec.rate_hz},
          {"sensor_gap_s", spec.sensor_gap_s},
          {"truth_gap_s", spec.truth_gap_s},
          {"cross_check_limit_m", spec.cross_check_limit_m},
          {"methods", methods}};
}

}  // namespace trilat
