// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "evaluators/solvers/sensor_plane.h"

namespace trilat {
namespace {

constexpr std::size_t kLeastSensors = 3;
constexpr double kSamePlace_m = 1e-3;
constexpr double kFarthest_m = 1e4;

std::array<double, 3> on_circle(std::size_t i, std::size_t count, double radius_m, double height_m) {
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
  return {radius_m * std::cos(angle), height_m, radius_m * std::sin(angle)};
}

std::vector<std::array<double, 3>> read_circle(JsonObject& object) {
  const Json& value = object.value("heights_m");
  if (!value.is_array()) object.refuse("heights_m", "must be an array of heights");
  const std::vector<double> heights_m = object.numbers("heights_m", value.size());
  const double radius_m = object.positive("radius_m", 2.0);
  std::vector<std::array<double, 3>> sensors_m;
  for (std::size_t i = 0; i < heights_m.size(); ++i)
    sensors_m.push_back(on_circle(i, heights_m.size(), radius_m, heights_m[i]));
  return sensors_m;
}

std::vector<std::array<double, 3>> read_positions(JsonObject& object) {
  const Json& value = object.value("sensors_m");
  object.shape("sensors_m", R"({"type": "array", "items": {"type": "array", "items": {"type": "number"},
      "minItems": 3, "maxItems": 3}})");
  if (!value.is_array()) object.refuse("sensors_m", "must be an array of positions [x, y, z]");
  std::vector<std::array<double, 3>> sensors_m;
  for (const Json& position : value) {
    if (!position.is_array() || position.size() != 3 || !position[0].is_number() ||
        !position[1].is_number() || !position[2].is_number())
      throw InputError(fmt::format("{}/{}", object.place_of("sensors_m"), sensors_m.size()),
                       "must be a position [x, y, z] in metres");
    sensors_m.push_back({position[0].get<double>(), position[1].get<double>(), position[2].get<double>()});
  }
  return sensors_m;
}

RangeProblem problem_at(const std::vector<std::array<double, 3>>& sensors_m) {
  RangeProblem problem;
  problem.count = static_cast<int>(sensors_m.size());
  for (std::size_t i = 0; i < sensors_m.size(); ++i)
    problem.sensor_m[i] = {sensors_m[i][0], sensors_m[i][1], sensors_m[i][2]};
  return problem;
}

void check_sensors(const JsonObject& object, const std::string& key,
                   const std::vector<std::array<double, 3>>& sensors_m) {
  if (sensors_m.size() < kLeastSensors || sensors_m.size() > RangeTrialModel::kMaxSensors)
    object.refuse(key, fmt::format("must place {} to {} sensors, places {}", kLeastSensors,
                                   RangeTrialModel::kMaxSensors, sensors_m.size()));
  for (const auto& sensor_m : sensors_m)
    for (const double coordinate_m : sensor_m)
      if (!(std::abs(coordinate_m) <= kFarthest_m))
        object.refuse(key, fmt::format("must stay within {} m of the origin", kFarthest_m));
  const RangeProblem problem = problem_at(sensors_m);
  for (int i = 0; i < problem.count; ++i)
    for (int j = 0; j < i; ++j)
      if ((problem.sensor_m[i] - problem.sensor_m[j]).norm() < kSamePlace_m)
        object.refuse(key, fmt::format("has sensors {} and {} in one place", j, i));
  if (plane_of(problem).collinear)
    object.refuse(key, "has all sensors on one line, so a whole circle of positions has the same ranges");
}

SweepRig read_rig(JsonObject& object) {
  SweepRig rig;
  rig.name = object.text("name");
  if (!is_plain_name(rig.name) || rig.name.find('/') != std::string::npos)
    object.refuse("name", "must have 1 to 60 printable characters, none of them '/' or '|'");
  const bool circle = object.has("heights_m");
  if (circle == object.has("sensors_m"))
    object.refuse(circle ? "sensors_m" : "heights_m",
                  "a rig has either heights_m on a circle or sensors_m, and one of them");
  rig.sensors_m = circle ? read_circle(object) : read_positions(object);
  check_sensors(object, circle ? "heights_m" : "sensors_m", rig.sensors_m);
  object.about({{"name", "of the rig"},
                {"heights_m", "of sensors on a circle, spread evenly"},
                {"radius_m", "of that circle"},
                {"sensors_m", "positions, instead of heights"}});
  object.finish();
  return rig;
}

}  // namespace

bool is_plain_name(const std::string& name) {
  const auto is_odd = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '|' || c == 127; };
  return !name.empty() && name.size() <= 60 && std::none_of(name.begin(), name.end(), is_odd);
}

std::vector<SweepRig> read_rigs(JsonObject& object, const std::string& key) {
  std::vector<SweepRig> rigs;
  std::vector<JsonObject> entries = object.objects(key);
  if (entries.empty()) object.refuse(key, "must hold at least one rig");
  for (JsonObject& entry : entries) {
    rigs.push_back(read_rig(entry));
    for (std::size_t before = 0; before + 1 < rigs.size(); ++before) {
      if (rigs[before].name == rigs.back().name)
        entry.refuse("name", "is \"" + rigs.back().name + "\", which an earlier rig has");
      if (rigs[before].sensors_m == rigs.back().sensors_m)
        entry.refuse("name", "names the same sensors as \"" + rigs[before].name + '"');
    }
  }
  return rigs;
}

}  // namespace trilat
