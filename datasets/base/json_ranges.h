// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

// Numbers of a JSON object that must lie in a range.
inline double number_within(JsonObject& object, const std::string& key, double fallback, double low,
                            double high) {
  const double value = object.number(key, fallback);
  if (!(value >= low && value <= high))
    object.refuse(key, "must lie between " + Json(low).dump() + " and " + Json(high).dump());
  return value;
}

inline std::uint64_t count_within(JsonObject& object, const std::string& key, std::uint64_t fallback,
                                  std::uint64_t least, std::uint64_t most) {
  const std::uint64_t count = object.count(key, fallback);
  if (count < least || count > most)
    object.refuse(key, "must be " + std::to_string(least) + " to " + std::to_string(most) + ", is " +
                           std::to_string(count));
  return count;
}

inline double share_within(JsonObject& object, const std::string& key, double fallback) {
  const double value = object.number(key, fallback);
  if (!(value >= 0.0 && value <= 1.0)) object.refuse(key, "must lie between 0 and 1");
  return value;
}

inline double not_negative(JsonObject& object, const std::string& key, double fallback) {
  const double value = object.number(key, fallback);
  if (!(value >= 0.0)) object.refuse(key, "must not be negative");
  return value;
}

}  // namespace trilat
