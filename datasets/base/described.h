// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

// Calls field("name", self.name) for each name.
#define TRILAT_EACH(...) __VA_OPT__(TRILAT_EXPAND(TRILAT_EACH_(__VA_ARGS__)))
#define TRILAT_EACH_(name, ...) \
  field(#name, self.name);      \
  __VA_OPT__(TRILAT_AGAIN TRILAT_PARENTHESES(__VA_ARGS__))
#define TRILAT_AGAIN() TRILAT_EACH_
#define TRILAT_PARENTHESES ()
#define TRILAT_EXPAND(...) TRILAT_EXPAND_1(TRILAT_EXPAND_1(TRILAT_EXPAND_1(__VA_ARGS__)))
#define TRILAT_EXPAND_1(...) TRILAT_EXPAND_2(TRILAT_EXPAND_2(TRILAT_EXPAND_2(__VA_ARGS__)))
#define TRILAT_EXPAND_2(...) TRILAT_EXPAND_3(TRILAT_EXPAND_3(TRILAT_EXPAND_3(__VA_ARGS__)))
#define TRILAT_EXPAND_3(...) __VA_ARGS__
#define TRILAT_FIELDS(...) \
  static void fields(auto& self, auto&& field) { TRILAT_EACH(__VA_ARGS__) }

// A struct that says once what it holds, for writing and reading it as JSON: TRILAT_FIELDS(take, method), or
// where the key is another name
//   static void fields(auto& self, auto&& field) { field("take", self.id); TRILAT_EACH(method) }
// The order is that of the file. A field that is computed from others is written, and not read. Members that
// are there only together follow `if (field.has("hidden", self.truth_known))`, whose key is one of them. A
// struct with `static constexpr bool as_list = true;` is the list of its values. A struct may have
// `void check(const JsonObject& object) const`, which refuses what its users could not bear.
template <class T>
concept Described = requires(T& value) {
  T::fields(value, [](auto&&...) {});
};

// Numbers that are not finite are null, an empty optional is left out.
template <Described T>
Json json_of(const T& value);
template <Described T>
Json json_of(const std::vector<T>& values);

// Strict: every key and no other, of the type that the member has. InputError with the pointer.
template <Described T>
T read_as(JsonObject object);
template <Described T>
std::vector<T> read_list(JsonObject& object, const std::string& key);
// Of an object whose head has been read.
template <Described T>
void read_fields(JsonObject& object, T& value);

// Number of values of an enum that is stored as a number, from 0 on. Each one that is read has its own.
template <class T>
inline constexpr int kEnumValues = 0;

namespace described {

template <class T>
concept AsList = Described<T> && T::as_list;

template <class T>
Json written(const T& value) {
  if constexpr (AsList<T>) {
    Json json = Json::array();
    T::fields(value, [&](const char*, const auto& member) { json.push_back(written(member)); });
    return json;
  } else if constexpr (Described<T>) {
    return json_of(value);
  } else if constexpr (std::is_enum_v<T>) {
    return static_cast<std::underlying_type_t<T>>(value);
  } else if constexpr (std::is_same_v<T, Json> || std::is_arithmetic_v<T> ||
                       std::convertible_to<T, std::string>) {
    return value;
  } else if constexpr (requires { typename T::mapped_type; }) {
    Json json = Json::object();
    for (const auto& [key, entry] : value) json[key] = written(entry);
    return json;
  } else {
    Json json = Json::array();
    for (const auto& entry : value) json.push_back(written(entry));
    return json;
  }
}

struct Writer {
  Json json = Json::object();

  bool has(const char*, bool there) const { return there; }
  template <class T>
  void operator()(const char* key, const T& member) {
    json[key] = written(member);
  }
  template <class T>
  void operator()(const char* key, const std::optional<T>& member) {
    if (member) json[key] = written(*member);
  }
};

struct Reader {
  JsonObject& object;

  bool has(const char* key, bool& there) const { return there = object.has(key); }
  template <class T>
  void operator()(const char* key, T&& member) const {
    if constexpr (std::is_const_v<std::remove_reference_t<T>> || !std::is_lvalue_reference_v<T&&>)
      object.value(key);
    else
      get(object.value(key), key, member);
  }
  template <class T>
  void operator()(const char* key, std::optional<T>& member) const {
    member.reset();
    if (object.has(key)) get(object.value(key), key, member.emplace());
  }

 private:
  // `path`: from the object to the value.
  template <class T>
  void get(const Json& json, const std::string& path, T& into) const {
    const auto want = [&](bool right, const char* what) {
      if (!right) object.refuse_below(path, fmt::format("must be {}", what));
    };
    if constexpr (AsList<T>) {
      want(json.is_array(), "a list");
      std::size_t i = 0;
      T::fields(into, [&](const char* name, auto& member) {
        if (i == json.size()) object.refuse_below(path, fmt::format("has no {}", name));
        get(json[i], fmt::format("{}/{}", path, i), member);
        ++i;
      });
      if (i < json.size()) object.refuse_below(path, fmt::format("must be a list of {}", i));
    } else if constexpr (Described<T>) {
      want(json.is_object(), "an object");
      into = read_as<T>(object.below(path, json));
    } else if constexpr (std::is_same_v<T, Json>) {
      into = json;
    } else if constexpr (std::is_same_v<T, double>) {
      want(json.is_number() || json.is_null(), "a number or null");
      into = json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
    } else if constexpr (std::is_same_v<T, bool>) {
      want(json.is_boolean(), "true or false");
      into = json.get<bool>();
    } else if constexpr (std::is_integral_v<T>) {
      if constexpr (std::is_unsigned_v<T>)
        want(json.is_number_unsigned(), "an integer of 0 or more");
      else
        want(json.is_number_integer(), "an integer");
      using Limits = std::numeric_limits<T>;
      const bool fits = json.is_number_unsigned() ? std::in_range<T>(json.get<std::uint64_t>())
                                                  : std::in_range<T>(json.get<std::int64_t>());
      if (!fits)
        object.refuse_below(path, fmt::format("must lie between {} and {}", Limits::min(), Limits::max()));
      into = json.get<T>();
    } else if constexpr (std::is_enum_v<T>) {
      std::underlying_type_t<T> number{};
      get(json, path, number);
      static_assert(kEnumValues<T> > 0, "how many values are there?");
      if (number >= kEnumValues<T>)
        object.refuse_below(path, fmt::format("must lie between 0 and {}", kEnumValues<T> - 1));
      into = static_cast<T>(number);
    } else if constexpr (std::is_same_v<T, std::string>) {
      want(json.is_string(), "a text");
      into = json.get<std::string>();
    } else if constexpr (requires { typename T::mapped_type; }) {
      want(json.is_object(), "an object");
      for (const auto& [key, entry] : json.items()) get(entry, fmt::format("{}/{}", path, key), into[key]);
    } else {
      want(json.is_array(), "a list");
      if constexpr (requires { into.resize(0); }) into.resize(json.size());
      if (json.size() != into.size())
        object.refuse_below(path, fmt::format("must be a list of {}", into.size()));
      constexpr bool is_plain = std::is_arithmetic_v<typename T::value_type>;
      for (std::size_t i = 0; i < into.size(); ++i)
        get(json[i], is_plain ? path : fmt::format("{}/{}", path, i), into[i]);
    }
  }
};

}  // namespace described

template <Described T>
Json json_of(const T& value) {
  described::Writer writer;
  T::fields(value, writer);
  return std::move(writer.json);
}

template <Described T>
Json json_of(const std::vector<T>& values) {
  return described::written(values);
}

template <Described T>
void read_fields(JsonObject& object, T& value) {
  T::fields(value, described::Reader{object});
  object.finish();
  if constexpr (requires { value.check(object); }) value.check(object);
}

template <Described T>
T read_as(JsonObject object) {
  T value;
  read_fields(object, value);
  return value;
}

template <Described T>
std::vector<T> read_list(JsonObject& object, const std::string& key) {
  std::vector<T> values;
  for (JsonObject& entry : object.objects(key)) values.push_back(read_as<T>(std::move(entry)));
  return values;
}

}  // namespace trilat
