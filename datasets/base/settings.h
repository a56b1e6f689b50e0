// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Where a number must lie, both ends included.
template <class Number>
struct Limits {
  Number low, high;
};

// One setting that a person writes: reads it where it is given, and says what it means in the schema.
// InputError with the pointer when it is of another type or out of its limits. `unit`: what one of the
// document's is in the struct.
inline void setting(JsonObject& object, const char* key, double& value, Limits<double> limits,
                    const char* meaning, double unit = 1.0) {
  const double given = object.number(key, value / unit);
  value = given * unit;
  object.range(key, limits.low, limits.high);
  object.about({{key, meaning}});
  if (given >= limits.low && given <= limits.high) return;
  if (limits.high == kUnlimited) object.refuse(key, fmt::format("must not be less than {:g}", limits.low));
  object.refuse(key, fmt::format("must lie between {:g} and {:g}", limits.low, limits.high));
}

template <std::integral Count>
void setting(JsonObject& object, const char* key, Count& value, Limits<std::uint64_t> limits,
             const char* meaning) {
  const std::uint64_t count = object.count(key, static_cast<std::uint64_t>(value));
  object.range(key, static_cast<double>(limits.low), static_cast<double>(limits.high));
  object.about({{key, meaning}});
  if (count < limits.low || count > limits.high)
    object.refuse(key, fmt::format("must be {} to {}, is {}", limits.low, limits.high, count));
  value = static_cast<Count>(count);
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

// A list of texts that differ; empty without the key.
inline std::vector<std::string> different_texts(JsonObject& object, const std::string& key) {
  std::vector<std::string> texts = object.texts(key, {});
  if (const std::string twice = first_repeated(texts); !twice.empty())
    object.refuse(key, "has \"" + twice + "\" twice");
  return texts;
}

// The settings of a struct, each told once: read from a document where it gives them, with what they mean for
// the schema; or all written, in the order in which they are told.
class Settings {
 public:
  explicit Settings(JsonObject& read) : read_(&read) {}
  explicit Settings(Json& written) : written_(&written) {}

  // The document that is read, for what is checked or read by itself; null when settings are written.
  JsonObject* reading() const { return read_; }

  void operator()(const char* key, double& value, Limits<double> limits, const char* meaning) {
    read_ ? setting(*read_, key, value, limits, meaning) : write(key, value);
  }
  template <std::integral Count>
  void operator()(const char* key, Count& value, Limits<std::uint64_t> limits, const char* meaning) {
    read_ ? setting(*read_, key, value, limits, meaning) : write(key, value);
  }
  template <class Value>
  void operator()(const char* key, Value& value, const char* meaning) {
    read_ ? setting(*read_, key, value, meaning) : write(key, value);
  }
  // Greater than 0; `unit`: what one of the document's is in the struct.
  void positive(const char* key, double& value, const char* meaning, double unit = 1.0) {
    if (!read_) return write(key, value / unit);
    value = read_->positive(key, value / unit) * unit;
    read_->about({{key, meaning}});
  }
  // One of the words, by its number.
  template <class Choice>
  void choice(const char* key, Choice& value, const std::vector<std::string>& words, const char* meaning) {
    const auto number = static_cast<std::size_t>(value);
    if (!read_) return write(key, words.at(number));
    value = static_cast<Choice>(read_->choice(key, words, number));
    read_->about({{key, meaning}});
  }
  void texts(const char* key, std::vector<std::string>& value, const char* meaning) {
    if (!read_) return write(key, value);
    value = different_texts(*read_, key);
    read_->about({{key, meaning}});
  }
  // An object of its own, that a document need not have.
  template <class Tell>
  void part(const char* key, const char* meaning, const Tell& tell) {
    if (!read_) {
      Settings written((*written_)[key] = Json::object());
      return tell(written);
    }
    if (!read_->has(key)) return;
    JsonObject object = read_->object(key);
    read_->about({{key, meaning}});
    Settings read(object);
    tell(read);
    object.finish();
  }
  void write(const char* key, Json value) {
    if (written_) (*written_)[key] = std::move(value);
  }

 private:
  JsonObject* read_ = nullptr;
  Json* written_ = nullptr;
};

}  // namespace trilat
