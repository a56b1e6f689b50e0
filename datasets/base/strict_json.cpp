// SPDX-License-Identifier: MIT
#include "datasets/base/strict_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr int kMaxDepth = 64;

std::string join(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::size_t line_at(std::string_view text, std::size_t byte) {
  return 1 +
         static_cast<std::size_t>(std::count(
             text.begin(), text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size())), '\n'));
}

// Escapes a key for a JSON pointer (RFC 6901).
std::string escaped(const std::string& key) {
  std::string text;
  for (char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

std::string type_of(const Json& value) {
  if (value.is_number_float()) return "the number " + value.dump();
  if (value.is_number()) return "the integer " + value.dump();
  if (value.is_string()) return "the text " + value.dump();
  return value.is_null()     ? "null"
         : value.is_object() ? "an object"
         : value.is_array()  ? "an array"
                             : value.dump();
}

}  // namespace

Json parse_json(std::string_view text, const std::string& place) {
  std::vector<std::set<std::string>> keys_at_depth;
  std::string duplicate;
  bool too_deep = false;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (depth > kMaxDepth) too_deep = true;
    if (event == Json::parse_event_t::object_start) {
      keys_at_depth.emplace_back();
    } else if (event == Json::parse_event_t::object_end) {
      keys_at_depth.pop_back();
    } else if (event == Json::parse_event_t::key && !keys_at_depth.empty()) {
      const auto key = parsed.get<std::string>();
      if (!keys_at_depth.back().insert(key).second && duplicate.empty()) duplicate = key;
    }
    return !too_deep;
  };
  Json result;
  try {
    result = Json::parse(text, watch);
  } catch (const nlohmann::json::parse_error& error) {
    std::string what = error.what();
    const auto colon = what.find("column");
    what = colon == std::string::npos ? what : what.substr(what.find(": ", colon) + 2);
    throw InputError(place + ":" + std::to_string(line_at(text, error.byte == 0 ? 0 : error.byte - 1)),
                     "is not valid JSON: " + what);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(place, std::string("is not valid JSON: ") + error.what());
  }
  if (too_deep) throw InputError(place, "nests deeper than " + std::to_string(kMaxDepth) + " levels");
  if (!duplicate.empty()) throw InputError(place, "has the key \"" + duplicate + "\" twice in one object");
  return result;
}

Json read_json(const std::filesystem::path& path) { return parse_json(read_file(path), path.string()); }

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

Json numbers_json(std::span<const double> numbers) {
  Json array = Json::array();
  for (const double number : numbers) array.push_back(std::isfinite(number) ? Json(number) : Json());
  return array;
}

std::string first_repeated(const std::vector<std::string>& texts) {
  std::set<std::string> seen;
  for (const std::string& text : texts)
    if (!seen.insert(text).second) return text;
  return {};
}

JsonObject::JsonObject(const Json& value, std::string place, std::string pointer)
    : value_(&value), place_(std::move(place)), pointer_(std::move(pointer)) {
  if (!value.is_object())
    throw InputError(place_ + " " + (pointer_.empty() ? "/" : pointer_),
                     "must be an object, is " + type_of(value));
}

std::string JsonObject::place_of(const std::string& key) const {
  return place_ + " " + pointer_ + "/" + escaped(key);
}

void JsonObject::refuse(const std::string& key, const std::string& problem) const {
  throw InputError(place_of(key), problem);
}

const Json* JsonObject::find(const std::string& key) {
  known_.insert(key);
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

const Json& JsonObject::need(const std::string& key) {
  const Json* found = find(key);
  if (!found) refuse(key, "is missing");
  return *found;
}

bool JsonObject::has(const std::string& key) { return find(key) != nullptr; }

double JsonObject::as_number(const std::string& key, const Json& value) const {
  if (!value.is_number()) refuse(key, "must be a number, is " + type_of(value));
  const double number = value.get<double>();
  if (!std::isfinite(number)) refuse(key, "must be a finite number");
  return number;
}

double JsonObject::number(const std::string& key) { return as_number(key, need(key)); }

double JsonObject::number(const std::string& key, double fallback) {
  const Json* found = find(key);
  return found ? as_number(key, *found) : fallback;
}

double JsonObject::positive(const std::string& key) {
  const double number = this->number(key);
  if (!(number > 0.0)) refuse(key, "must be greater than 0, is " + need(key).dump());
  return number;
}

double JsonObject::positive(const std::string& key, double fallback) {
  return has(key) ? positive(key) : fallback;
}

std::int64_t JsonObject::integer(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_number_integer()) refuse(key, "must be an integer, is " + type_of(value));
  if (value.is_number_unsigned() &&
      value.get<std::uint64_t>() > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    refuse(key, "is too large");
  return value.get<std::int64_t>();
}

std::int64_t JsonObject::integer(const std::string& key, std::int64_t fallback) {
  return has(key) ? integer(key) : fallback;
}

std::uint64_t JsonObject::count(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_number_unsigned()) refuse(key, "must be an integer of 0 or more, is " + type_of(value));
  return value.get<std::uint64_t>();
}

std::uint64_t JsonObject::count(const std::string& key, std::uint64_t fallback) {
  return has(key) ? count(key) : fallback;
}

bool JsonObject::boolean(const std::string& key, bool fallback) {
  const Json* found = find(key);
  if (!found) return fallback;
  if (!found->is_boolean()) refuse(key, "must be true or false, is " + type_of(*found));
  return found->get<bool>();
}

std::string JsonObject::text(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_string()) refuse(key, "must be a text, is " + type_of(value));
  return value.get<std::string>();
}

std::string JsonObject::text(const std::string& key, std::string fallback) {
  return has(key) ? text(key) : std::move(fallback);
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& known) {
  const std::string word = text(key);
  const auto found = std::find(known.begin(), known.end(), word);
  if (found == known.end()) refuse(key, "is \"" + word + "\", which is unknown; known are: " + join(known));
  return static_cast<std::size_t>(found - known.begin());
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& known,
                               std::size_t fallback) {
  return has(key) ? choice(key, known) : fallback;
}

const Json& JsonObject::need_array(const std::string& key, std::size_t size, const char* what) {
  const Json& value = need(key);
  if (!value.is_array() || value.size() != size)
    refuse(key, "must be an array of " + std::to_string(size) + ' ' + what);
  return value;
}

std::vector<double> JsonObject::numbers(const std::string& key, std::size_t size) {
  std::vector<double> result;
  for (const Json& element : need_array(key, size, "numbers")) result.push_back(as_number(key, element));
  return result;
}

std::vector<double> JsonObject::numbers_or_none(const std::string& key, std::size_t size) {
  std::vector<double> result;
  for (const Json& element : need_array(key, size, "numbers or null"))
    result.push_back(element.is_null() ? std::numeric_limits<double>::quiet_NaN() : as_number(key, element));
  return result;
}

std::vector<std::int64_t> JsonObject::integers(const std::string& key, std::size_t size) {
  std::vector<std::int64_t> result;
  for (const Json& element : need_array(key, size, "integers")) {
    if (!element.is_number_integer() ||
        (element.is_number_unsigned() &&
         element.get<std::uint64_t>() > std::numeric_limits<std::int64_t>::max()))
      refuse(key, "must hold integers below 2^63, has " + type_of(element));
    result.push_back(element.get<std::int64_t>());
  }
  return result;
}

std::vector<std::uint64_t> JsonObject::counts(const std::string& key, std::size_t size) {
  std::vector<std::uint64_t> result;
  for (const Json& element : need_array(key, size, "counts")) {
    if (!element.is_number_unsigned()) refuse(key, "must hold integers >= 0, has " + type_of(element));
    result.push_back(element.get<std::uint64_t>());
  }
  return result;
}

std::vector<std::string> JsonObject::texts(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_array()) refuse(key, "must be an array of texts, is " + type_of(value));
  std::vector<std::string> result;
  for (const Json& element : value) {
    if (!element.is_string()) refuse(key, "must hold texts only, has " + type_of(element));
    result.push_back(element.get<std::string>());
  }
  return result;
}

std::vector<std::string> JsonObject::texts(const std::string& key, std::vector<std::string> fallback) {
  return has(key) ? texts(key) : std::move(fallback);
}

JsonObject JsonObject::object(const std::string& key) {
  return JsonObject(need(key), place_, pointer_ + "/" + escaped(key));
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_array()) refuse(key, "must be an array of objects, is " + type_of(value));
  std::vector<JsonObject> result;
  for (std::size_t i = 0; i < value.size(); ++i)
    result.emplace_back(value[i], place_, pointer_ + "/" + escaped(key) + "/" + std::to_string(i));
  return result;
}

const Json& JsonObject::value(const std::string& key) { return need(key); }

std::vector<std::string> JsonObject::keys() const {
  std::vector<std::string> result;
  for (const auto& item : value_->items()) result.push_back(item.key());
  return result;
}

void JsonObject::finish() {
  for (const auto& item : value_->items())
    if (!known_.contains(item.key()))
      refuse(item.key(),
             "is an unknown key; known are: " + join(std::vector<std::string>(known_.begin(), known_.end())));
}

}  // namespace trilat
