// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/settings.h"
#include "pipeline/accuracy/methods/method_kinds.h"

namespace trilat {
namespace {

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const MethodKind& kind : method_kinds()) names.emplace_back(kind.name);
  return names;
}

}  // namespace

const std::vector<std::string>& occlusion_rule_names() {
  static const std::vector<std::string> names{"off", "printed", "corrected", "inferred", "hidden"};
  return names;
}

const std::vector<std::string>& stated_or_estimated() {
  static const std::vector<std::string> names{"stated", "estimated"};
  return names;
}

namespace {

// The settings that methods of all kinds have. Kind and name are known before.
void tell(Settings& s, MethodSpec& m) {
  JsonObject* object = s.reading();
  s.texts("sensors", m.sensors, "those it may use; empty: all");
  if (object ? object->has("each") : m.each > 0) {
    if (object) {
      m.each = object->count("each");  // without a default: setting() would tell one
      object->range("each", 1, kMaxSensors);
      object->about({{"each", "one method for each set of so many sensors"}});
      if (m.each < 1 || m.each > kMaxSensors)
        object->refuse("each", fmt::format("must be 1 to {}, is {}", kMaxSensors, m.each));
    }
    s.write("each", m.each);
    s("most_sets", m.most_sets, {1, 1000}, "at most so many sets");
    if (const std::size_t used = m.kind->sensors; object && used > 0 && m.each != used)
      object->refuse("each", fmt::format("must be {}: {} uses so many sensors", used, m.kind->name));
  }
  if (m.kind->settings) m.kind->settings(s, m);
  s.choice("calibration", m.calibration_is_estimated, stated_or_estimated(),
           "stated: as calibration.json has it; estimated: each sensor's turn, shift and range offset, found "
           "from the bodies of the take without truth, are taken away first");
  s.choice("occlusion", m.occlusion, occlusion_rule_names(),
           "how sensors are found that see the joint occluded, which are then left out: by crossing limbs as "
           "printed (eq. 8) or in the image, where the joint is inferred, or, in simulations alone, where it "
           "is truly hidden");
  if (m.occlusion == OcclusionRule::off) return;
  if (object && m.kind->sensors == 1)
    object->refuse("occlusion", "leaves a method of one sensor nothing to choose from");
  if (m.occlusion == OcclusionRule::hidden) m.inferred_is_occluded = false;
  if (m.occlusion != OcclusionRule::inferred)
    s("inferred_is_occluded", m.inferred_is_occluded, "an inferred joint counts as one crossing more");
  s("fewest_sensors", m.fewest_sensors, {1, kMaxSensors},
    "those with the fewest crossings come back until there are so many");
}

}  // namespace

MethodSpec read_method(JsonObject& object) {
  MethodSpec method;
  method.kind = &method_kinds()[object.branch("method", kind_names())];
  method.calibration_is_estimated = method.kind->calibrates;
  if (object.has("name")) method.name = object.text("name");
  object.about(
      {{"method", fmt::format("{}; {}", method.kind->what, method.kind->source).c_str()},
       {"name", "of its rows; unique in the study; without it the kind and the sensors that are named"}});
  Settings settings(object);
  tell(settings, method);
  if (!object.has("name"))
    method.name = method.sensors.empty() || method.each > 0
                      ? std::string(method.kind->name)
                      : fmt::format("{} {}", method.kind->name, fmt::join(method.sensors, "+"));
  if (method.name.empty() || method.name.size() > 60) object.refuse("name", "must have 1 to 60 characters");
  const std::size_t used = method.kind->sensors;
  if (used > 1 && method.each == 0 && !method.sensors.empty() && method.sensors.size() != used)
    object.refuse("sensors", fmt::format("must name the {} sensors that {} uses", used, method.kind->name));
  object.finish();
  return method;
}

Json resolved_json(MethodSpec m) {
  Json entry{{"method", m.kind->name}, {"name", m.name}};
  Settings settings(entry);
  tell(settings, m);
  return entry;
}

}  // namespace trilat
