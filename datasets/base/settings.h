// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "datasets/base/strict_json.h"

namespace trilat {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Where a number must lie, both ends included.
template <class Number>
struct Limits {
  Number low, high;
};

// One setting that a person writes: reads it where it is given, and says what it means in the schema.
// InputError with the pointer when it is of another type or out of its limits.
inline void setting(JsonObject& object, const char* key, double& value, Limits<double> limits,
                    const char* meaning) {
  value = object.number(key, value);
  object.range(key, limits.low, limits.high);
  object.about({{key, meaning}});
  if (value >= limits.low && value <= limits.high) return;
  if (limits.high == kUnlimited) object.refuse(key, fmt::format("must not be less than {:g}", limits.low));
  object.refuse(key, fmt::format("must lie between {:g} and {:g}", limits.low, limits.high));
}

template <std::unsigned_integral Count>
void setting(JsonObject& object, const char* key, Count& value, Limits<std::uint64_t> limits,
             const char* meaning) {
  value = static_cast<Count>(
      within(object, key, object.count(key, static_cast<std::uint64_t>(value)), limits.low, limits.high));
  object.about({{key, meaning}});
}

inline void setting(JsonObject& object, const char* key, std::uint64_t& value, const char* meaning) {
  value = object.count(key, value);
  object.about({{key, meaning}});
}

inline void setting(JsonObject& object, const char* key, bool& value, const char* meaning) {
  value = object.boolean(key, value);
  object.about({{key, meaning}});
}

inline void setting(JsonObject& object, const char* key, std::string& value, const char* meaning) {
  value = object.text(key, value);
  object.about({{key, meaning}});
}

}  // namespace trilat
