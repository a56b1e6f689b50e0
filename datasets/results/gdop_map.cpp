// SPDX-License-Identifier: MIT
#include "datasets/results/gdop_map.h"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/results_file.h"

namespace trilat {
namespace {

constexpr const char* kMapFormat = "trilat.gdop_map";
constexpr const char* kInfinite = "infinite";
constexpr double kDecimals = 1e4;  // more would make the file long and say nothing

Json json_of(double gdop) {
  if (std::isnan(gdop)) return nullptr;
  if (std::isinf(gdop)) return kInfinite;
  return std::round(gdop * kDecimals) / kDecimals;
}

std::vector<double> read_values(JsonObject& object, std::size_t count) {
  const Json& list = object.value("gdop");
  if (!list.is_array() || list.size() != count)
    object.refuse("gdop", "must have a number for each point of x_m and z_m");
  std::vector<double> values;
  for (const Json& value : list) {
    if (value.is_null())
      values.push_back(std::numeric_limits<double>::quiet_NaN());
    else if (value.is_number())
      values.push_back(value.get<double>());
    else if (value == kInfinite)
      values.push_back(std::numeric_limits<double>::infinity());
    else
      object.refuse("gdop", "must hold numbers, null or \"infinite\"");
  }
  return values;
}

std::vector<double> read_axis(JsonObject& object, const std::string& key) {
  const Json& list = object.value(key);
  if (!list.is_array() || list.empty()) object.refuse(key, "must be an array of numbers");
  return object.numbers(key, list.size());
}

}  // namespace

void write_gdop_map(const std::filesystem::path& folder, const GdopMap& map) {
  Json json{{"format", kMapFormat}, {"version", 1},   {"take", map.take},      {"height_m", map.height_m},
            {"x_m", map.x_m},       {"z_m", map.z_m}, {"gdop", Json::array()}, {"sensors", Json::array()}};
  for (double value : map.gdop) json["gdop"].push_back(json_of(value));
  for (std::size_t s = 0; s < map.sensors.size(); ++s)
    json["sensors"].push_back({{"name", map.sensors[s]}, {"position_m", map.position_m[s]}});
  write_file(folder / "gdop_map.json", json_text(json, -1) + "\n");
}

std::optional<GdopMap> read_gdop_map(const std::filesystem::path& folder) {
  const auto path = folder / "gdop_map.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  const Json json = read_json(path);
  JsonObject object(json, path.string(), "");
  check_format(object, kMapFormat, 1);
  GdopMap map;
  map.take = object.text("take");
  map.height_m = object.number("height_m");
  map.x_m = read_axis(object, "x_m");
  map.z_m = read_axis(object, "z_m");
  map.gdop = read_values(object, map.x_m.size() * map.z_m.size());
  for (JsonObject& sensor : object.objects("sensors")) {
    map.sensors.push_back(sensor.text("name"));
    const std::vector<double> p = sensor.numbers("position_m", 3);
    map.position_m.push_back({p[0], p[1], p[2]});
    sensor.finish();
  }
  object.finish();
  return map;
}

}  // namespace trilat
