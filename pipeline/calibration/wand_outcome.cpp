// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_outcome.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace trilat {
namespace {

// JSON has no numbers but the finite: null stands for all others.
template <class Numbers>
void add_numbers(Json& array, const Numbers& numbers) {
  for (const double number : numbers) array.push_back(std::isfinite(number) ? Json(number) : Json());
}

const Json& array_of(JsonObject& object, const std::string& key, std::size_t size) {
  const Json& array = object.value(key);
  if (!array.is_array() || array.size() != size)
    object.refuse(key, "must be an array of " + std::to_string(size) + " numbers");
  return array;
}

std::vector<double> numbers_of(JsonObject& object, const std::string& key, std::size_t size) {
  std::vector<double> numbers;
  for (const Json& value : array_of(object, key, size)) {
    if (!value.is_number() && !value.is_null()) object.refuse(key, "must hold numbers, or null for none");
    numbers.push_back(value.is_null() ? std::nan("") : value.get<double>());
  }
  return numbers;
}

std::vector<std::int64_t> integers_of(JsonObject& object, const std::string& key, std::size_t size) {
  std::vector<std::int64_t> integers;
  for (const Json& value : array_of(object, key, size)) {
    if (!value.is_number_integer()) object.refuse(key, "must hold integers");
    integers.push_back(value.get<std::int64_t>());
  }
  return integers;
}

std::size_t length_of(JsonObject& object, const std::string& key) {
  const Json& array = object.value(key);
  if (!array.is_array()) object.refuse(key, "must be an array of integers");
  return array.size();
}

Eigen::Vector3d vector_of(const std::vector<double>& numbers, std::size_t index) {
  return Eigen::Vector3d::Map(numbers.data() + 3 * index);
}

}  // namespace

Json json_of(const SensorSearch& search) {
  Json statuses = Json::object();
  for (const auto& [status, count] : search.statuses) statuses[status] = count;
  Json times = Json::array(), centres = Json::array(), covariances = Json::array(), rms = Json::array(),
       pixels = Json::array();
  for (const auto& [time, sighting] : search.found) {
    times.push_back(time.ns);
    add_numbers(centres, sighting.centre_in_sensor_m);
    add_numbers(covariances, sighting.covariance_m2.reshaped());
    add_numbers(rms, std::span(&sighting.rms_m, 1));
    pixels.push_back(sighting.pixels);
  }
  return {{"statuses", statuses},         {"time_ns", times}, {"centre_in_sensor_m", centres},
          {"covariance_m2", covariances}, {"rms_m", rms},     {"pixels", pixels}};
}

SensorSearch read_sensor_search(const Json& json, const std::string& place, const std::string& pointer) {
  JsonObject object(json, place, pointer);
  SensorSearch search;
  JsonObject statuses = object.object("statuses");
  for (const std::string& status : statuses.keys())
    search.frames += search.statuses[status] = statuses.count(status);
  const std::size_t found = length_of(object, "time_ns");
  const auto times = integers_of(object, "time_ns", found), pixels = integers_of(object, "pixels", found);
  const auto centres = numbers_of(object, "centre_in_sensor_m", 3 * found);
  const auto covariances = numbers_of(object, "covariance_m2", 9 * found);
  const auto rms = numbers_of(object, "rms_m", found);
  object.finish();
  for (std::size_t i = 0; i < found; ++i)
    search.found.push_back(
        {HostTime{times[i]},
         {WandStatus::found, vector_of(centres, i), Eigen::Matrix3d::Map(covariances.data() + 9 * i), rms[i],
          static_cast<int>(pixels[i])}});
  return search;
}

Json json_of(const WandTrack& track) {
  Json times = Json::array(), positions = Json::array();
  for (const MocapTime time : track.times) times.push_back(time.ns);
  for (const Eigen::Vector3d& position_m : track.position_m) add_numbers(positions, position_m);
  return {{"time_ns", times}, {"position_m", positions}};
}

WandTrack read_wand_track(const Json& json, const std::string& place, const std::string& pointer) {
  JsonObject object(json, place, pointer);
  WandTrack track;
  const std::size_t samples = length_of(object, "time_ns");
  const auto positions = numbers_of(object, "position_m", 3 * samples);
  for (const std::int64_t time : integers_of(object, "time_ns", samples)) track.times.push_back({time});
  object.finish();
  for (std::size_t i = 0; i < samples; ++i) track.position_m.push_back(vector_of(positions, i));
  return track;
}

}  // namespace trilat
