// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/method_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"
#include "pipeline/accuracy/methods/method_kinds.h"

namespace trilat {
namespace {

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const MethodKind& kind : method_kinds()) names.emplace_back(kind.name);
  return names;
}

void read_sets(JsonObject& object, MethodSpec& method) {
  method.each = count_within(object, "each", 1, kMaxSensors);
  method.most_sets = count_within(object, "most_sets", method.most_sets, 1, 1000);
  if (const std::size_t used = method.kind->sensors; used > 0 && method.each != used)
    object.refuse("each", fmt::format("must be {}: {} uses so many sensors", used, method.kind->name));
}

void read_occlusion(JsonObject& object, MethodSpec& method) {
  method.occlusion = static_cast<OcclusionRule>(
      object.choice("occlusion", occlusion_rule_names(), static_cast<std::size_t>(method.occlusion)));
  if (method.occlusion == OcclusionRule::off) return;
  if (method.kind->sensors == 1)
    object.refuse("occlusion", "leaves a method of one sensor nothing to choose from");
  method.inferred_is_occluded = object.boolean("inferred_is_occluded", method.inferred_is_occluded);
  method.fewest_sensors = static_cast<int>(count_within(object, "fewest_sensors", 1, 1, kMaxSensors));
}

}  // namespace

const std::vector<std::string>& occlusion_rule_names() {
  static const std::vector<std::string> names{"off", "printed", "corrected", "depth"};
  return names;
}

const std::vector<std::string>& stated_or_estimated() {
  static const std::vector<std::string> names{"stated", "estimated"};
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
  method.kind = &method_kinds()[object.branch("method", kind_names())];
  const std::size_t used = method.kind->sensors;
  method.sensors = different_texts(object, "sensors");
  if (object.has("each")) read_sets(object, method);
  if (object.has("name"))
    method.name = object.text("name");
  else if (method.sensors.empty() || method.each > 0)
    method.name = method.kind->name;
  else
    method.name = fmt::format("{} {}", method.kind->name, fmt::join(method.sensors, "+"));
  if (method.name.empty() || method.name.size() > 60) object.refuse("name", "must have 1 to 60 characters");
  if (used > 1 && method.each == 0 && !method.sensors.empty() && method.sensors.size() != used)
    object.refuse("sensors", fmt::format("must name the {} sensors that {} uses", used, method.kind->name));
  if (method.kind->read) method.kind->read(object, method);
  method.calibration_is_estimated =
      object.choice("calibration", stated_or_estimated(), method.kind->calibrates ? 1 : 0) == 1;
  read_occlusion(object, method);
  object.about(
      {{"method", fmt::format("{}; {}", method.kind->what, method.kind->source).c_str()},
       {"name", "of its rows; unique in the study; without it the kind and the sensors that are named"},
       {"sensors", "those it may use; empty: all"},
       {"calibration",
        "stated: as calibration.json has it; estimated: each sensor's turn, shift and range offset, found "
        "from the bodies of the take without truth, are taken away first"},
       {"each", "one method for each set of so many sensors"},
       {"most_sets", "at most so many sets"},
       {"occlusion",
        "how sensors are found that see the joint occluded, which are then left out: by crossing "
        "limbs as printed (eq. 8) or in the image, or by depth"},
       {"inferred_is_occluded", "an inferred joint counts as one crossing more"},
       {"fewest_sensors", "those with the fewest crossings come back until there are so many"}});
  object.finish();
  return method;
}

Json resolved_json(const MethodSpec& m) {
  Json entry{{"method", m.kind->name}, {"name", m.name}, {"sensors", m.sensors}};
  if (m.each > 0) entry.update({{"each", m.each}, {"most_sets", m.most_sets}});
  if (m.kind->write) m.kind->write(m, entry);
  entry["calibration"] = stated_or_estimated()[m.calibration_is_estimated ? 1 : 0];
  entry["occlusion"] = occlusion_rule_names()[static_cast<std::size_t>(m.occlusion)];
  if (m.occlusion != OcclusionRule::off) {
    entry["inferred_is_occluded"] = m.inferred_is_occluded;
    entry["fewest_sensors"] = m.fewest_sensors;
  }
  return entry;
}

}  // namespace trilat
