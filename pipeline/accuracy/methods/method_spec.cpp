// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "pipeline/accuracy/methods/method_kinds.h"

namespace trilat {
namespace {

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const MethodKind& kind : method_kinds()) names.emplace_back(kind.name);
  return names;
}

MethodSpec method_of(const MethodKind& kind) {
  MethodSpec method;
  method.kind = &kind;
  method.calibration_is_estimated = kind.calibrates;
  return method;
}

void visit_sets(Fields& f, MethodSpec& m) {
  std::optional<std::uint64_t> each;
  if (m.each > 0) each = m.each;
  f("each", each,
    opt("Number of sensors in a set: the entry becomes one method for each set of so many of its sensors, "
        "called NAME k1+k2+k3 and so on",
        {1.0, kMaxSensors}));
  if (f.reads()) m.each = each.value_or(0);
  if (const std::size_t used = m.kind->sensors; m.each > 0 && used > 0 && m.each != used)
    f.refuse("each", fmt::format("must be {}: {} uses so many sensors", used, m.kind->name));
  if (f.when(m.each > 0))
    f("most_sets", m.most_sets,
      opt("Largest number of such sets; of more, so many stand for all: the first sensors of random orders "
          "that are the same for every size",
          {1.0, 1000.0}));
  else
    f.useless({"most_sets"}, "without \"each\"");
}

void visit_occlusion(Fields& f, MethodSpec& m) {
  f("occlusion", m.occlusion,
    opt("Rule for views in which the joint is occluded, which are then left out. printed: another bone "
        "crosses in front by eq. 8 as printed; corrected: it crosses in the perspective image; inferred: the "
        "sensor infers the joint; hidden, in simulations alone: it is truly hidden"));
  const bool is_off = m.occlusion == OcclusionRule::off, uses_one = m.kind->sensors == 1;
  if (!is_off && uses_one) f.refuse("occlusion", "leaves a method of one sensor nothing to choose from");
  if (uses_one) return;
  if (!f.when(!is_off)) return f.useless({"inferred_is_occluded", "fewest_sensors"}, "without \"occlusion\"");
  if (f.reads() && m.occlusion == OcclusionRule::hidden) m.inferred_is_occluded = false;
  if (m.occlusion != OcclusionRule::inferred)
    f("inferred_is_occluded", m.inferred_is_occluded,
      opt("Whether an inferred joint counts as one crossing more"));
  else
    f.useless({"inferred_is_occluded"}, "with \"occlusion\": \"inferred\"");
  f("fewest_sensors", m.fewest_sensors,
    opt("Number of sensors up to which those with the next fewest crossings come back, all that have equally "
        "many",
        {1.0, kMaxSensors}));
}

}  // namespace

void MethodSpec::fields(MethodSpec& m, Fields& f) {
  std::size_t kind = m.kind ? static_cast<std::size_t>(m.kind - method_kinds().data()) : 0;
  f.tag("method", kind, kind_names(), m.kind ? fmt::format("{}; {}", m.kind->what, m.kind->source) : "");
  if (f.reads()) m = method_of(method_kinds()[kind]);
  f("name", m.name,
    opt("Name of its rows, unique in the study; without it the kind and the sensors that are named"));
  f("sensors", m.sensors, opt("Sensors that it may use; empty: all"));
  visit_sets(f, m);
  if (m.kind->settings) m.kind->settings(f, m);
  f.named("calibration", m.calibration_is_estimated, kStatedOrEstimated,
          opt("Calibration that it uses. stated: calibration.json as it is; estimated: less each sensor's "
              "turn, shift and range offset, found from the bodies of the take without truth"));
  visit_occlusion(f, m);
  if (f.reads() && !f.has("name", true))
    m.name = m.sensors.empty() || m.each > 0 ? std::string(m.kind->name)
                                             : fmt::format("{} {}", m.kind->name, fmt::join(m.sensors, "+"));
}

void MethodSpec::check(const JsonPlace& place) const {
  if (name.empty() || name.size() > 60) place.at("name").refuse("must have 1 to 60 characters");
  if (kind->sensors > 1 && each == 0 && !sensors.empty() && sensors.size() != kind->sensors)
    place.at("sensors").refuse(
        fmt::format("must name the {} sensors that {} uses", kind->sensors, kind->name));
}

std::vector<MethodSpec> MethodSpec::alternatives() {
  std::vector<MethodSpec> methods;
  for (const MethodKind& kind : method_kinds()) methods.push_back(method_of(kind));
  return methods;
}

}  // namespace trilat
