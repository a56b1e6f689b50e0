// SPDX-License-Identifier: MIT
#include "pipeline/calibration/wand_outcome.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace trilat {
namespace {

void add(std::vector<double>& numbers, const auto& more) {
  numbers.insert(numbers.end(), more.begin(), more.end());
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
  Json times = Json::array(), pixels = Json::array();
  std::vector<double> centres, covariances, rms;
  for (const auto& [time, sighting] : search.found) {
    times.push_back(time.ns);
    add(centres, sighting.centre_in_sensor_m);
    add(covariances, sighting.covariance_m2.reshaped());
    rms.push_back(sighting.rms_m);
    pixels.push_back(sighting.pixels);
  }
  return {{"statuses", statuses},
          {"time_ns", times},
          {"centre_in_sensor_m", numbers_json(centres)},
          {"covariance_m2", numbers_json(covariances)},
          {"rms_m", numbers_json(rms)},
          {"pixels", pixels}};
}

SensorSearch read_sensor_search(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  SensorSearch search;
  JsonObject statuses = object.object("statuses");
  for (const std::string& status : statuses.keys())
    search.frames += search.statuses[status] = statuses.count(status);
  const std::size_t found = length_of(object, "time_ns");
  const auto times = object.integers("time_ns", found), pixels = object.integers("pixels", found);
  const auto centres = object.numbers_or_none("centre_in_sensor_m", 3 * found);
  const auto covariances = object.numbers_or_none("covariance_m2", 9 * found);
  const auto rms = object.numbers_or_none("rms_m", found);
  object.finish();
  for (std::size_t i = 0; i < found; ++i)
    search.found.push_back(
        {HostTime{times[i]},
         {WandStatus::found, vector_of(centres, i), Eigen::Matrix3d::Map(covariances.data() + 9 * i), rms[i],
          static_cast<int>(pixels[i])}});
  return search;
}

Json json_of(const WandTrack& track) {
  Json times = Json::array();
  std::vector<double> positions;
  for (const MocapTime time : track.times) times.push_back(time.ns);
  for (const Eigen::Vector3d& position_m : track.position_m) add(positions, position_m);
  return {{"time_ns", times}, {"position_m", numbers_json(positions)}};
}

WandTrack wand_track_of(const Json& json, const std::string& place) {
  JsonObject object(json, place, "");
  WandTrack track;
  const std::size_t samples = length_of(object, "time_ns");
  const auto positions = object.numbers_or_none("position_m", 3 * samples);
  for (const std::int64_t time : object.integers("time_ns", samples)) track.times.push_back({time});
  object.finish();
  for (std::size_t i = 0; i < samples; ++i) track.position_m.push_back(vector_of(positions, i));
  return track;
}

}  // namespace trilat
