// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

// Numbers of a JSON object that must lie in a range.
inline double within(JsonObject& object, const std::string& key, double value, double low, double high) {
  object.range(key, low, high);
  if (!(value >= low && value <= high))
    object.refuse(key, "must lie between " + Json(low).dump() + " and " + Json(high).dump());
  return value;
}

inline double number_within(JsonObject& object, const std::string& key, double low, double high) {
  return within(object, key, object.number(key), low, high);
}

inline double number_within(JsonObject& object, const std::string& key, double fallback, double low,
                            double high) {
  return within(object, key, object.number(key, fallback), low, high);
}

inline std::uint64_t within(JsonObject& object, const std::string& key, std::uint64_t count,
                            std::uint64_t least, std::uint64_t most) {
  object.range(key, static_cast<double>(least), static_cast<double>(most));
  if (count < least || count > most)
    object.refuse(key, "must be " + std::to_string(least) + " to " + std::to_string(most) + ", is " +
                           std::to_string(count));
  return count;
}

inline std::uint64_t count_within(JsonObject& object, const std::string& key, std::uint64_t least,
                                  std::uint64_t most) {
  return within(object, key, object.count(key), least, most);
}

inline std::uint64_t count_within(JsonObject& object, const std::string& key, std::uint64_t fallback,
                                  std::uint64_t least, std::uint64_t most) {
  return within(object, key, object.count(key, fallback), least, most);
}

inline double share_within(JsonObject& object, const std::string& key, double fallback) {
  const double value = object.number(key, fallback);
  object.range(key, 0.0, 1.0);
  if (!(value >= 0.0 && value <= 1.0)) object.refuse(key, "must lie between 0 and 1");
  return value;
}

inline double not_negative(JsonObject& object, const std::string& key, double fallback) {
  const double value = object.number(key, fallback);
  object.range(key, 0.0, std::numeric_limits<double>::infinity());
  if (!(value >= 0.0)) object.refuse(key, "must not be negative");
  return value;
}

}  // namespace trilat
