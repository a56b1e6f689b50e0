// SPDX-License-Identifier: MIT
#include "datasets/base/strict_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "datasets/base/json_schema.h"
#include "datasets/base/known_names.h"

namespace trilat {
namespace {

constexpr int kMaxDepth = 64;

// The document that is noted, of the thread that reads it.
thread_local const Json* noted_document = nullptr;
thread_local std::shared_ptr<JsonFields> noted_fields;

// "LINE:COLUMN", both from 1.
std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  return fmt::format("{}:{}", 1 + std::ranges::count(before, '\n'),
                     before.size() - (before.rfind('\n') + 1) + 1);
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
    throw InputError(place + ":" + line_and_column(text, error.byte == 0 ? 0 : error.byte - 1),
                     "is not valid JSON: " + what);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(place, std::string("is not valid JSON: ") + error.what());
  }
  if (too_deep) throw InputError(place, "nests deeper than " + std::to_string(kMaxDepth) + " levels");
  if (!duplicate.empty()) throw InputError(place, "has the key \"" + duplicate + "\" twice in one object");
  return result;
}

Json read_json(const std::filesystem::path& path) { return parse_json(read_file(path), path.string()); }

std::string exact_json_text(const Json& json, int indent) {
  try {
    return json.dump(indent);
  } catch (const Json::type_error&) {
    if (json.is_string())
      throw InputError(
          json.dump(-1, ' ', false, Json::error_handler_t::replace),
          "is not UTF-8 text; rename the file or folder, or save the file that holds the name as UTF-8");
    for (const Json& inside : json) exact_json_text(inside, indent);  // names the text
    throw;
  }
}

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string first_repeated(const std::vector<std::string>& texts) {
  std::set<std::string> seen;
  for (const std::string& text : texts)
    if (!seen.insert(text).second) return text;
  return {};
}

JsonNotes::JsonNotes(const Json& document, std::shared_ptr<JsonFields> fields) {
  noted_document = &document;
  noted_fields = std::move(fields);
}

JsonNotes::~JsonNotes() {
  noted_document = nullptr;
  noted_fields.reset();
}

JsonObject::JsonObject(const Json& value, std::string place, std::string pointer)
    : value_(&value), place_(std::move(place)), pointer_(std::move(pointer)) {
  if (!value.is_object())
    throw InputError(place_ + " " + (pointer_.empty() ? "/" : pointer_),
                     "must be an object, is " + type_of(value));
  if (&value == noted_document) fields_ = noted_fields;
}

JsonField* JsonObject::noted(const std::string& key) { return fields_ ? &fields_->of(key) : nullptr; }

void JsonObject::note_type(const std::string& key, const char* type) {
  JsonField* field = noted(key);
  if (!field) return;
  Json& known = field->schema["type"];
  if (known.is_string() && known != type) known = Json::array({known, type});
  if (known.is_null()) known = type;
}

template <class Value>
void JsonObject::note_default(const std::string& key, const Value& value) {
  JsonField* field = noted(key);
  if (!field || field->schema.contains("default")) return;
  if constexpr (std::is_floating_point_v<Value>)
    field->schema["default"] =
        std::stod(fmt::format("{:.12g}", value));  // a unit's conversion leaves 9.99…e-05
  else
    field->schema["default"] = value;
}

void JsonObject::note_list(const std::string& key, const char* type, std::size_t size) {
  JsonField* field = noted(key);
  if (!field) return;
  field->schema.update({{"type", "array"}, {"items", {{"type", type}}}});
  if (!field->has_any_size) field->schema.update({{"minItems", size}, {"maxItems", size}});
}

void JsonObject::range(const std::string& key, double low, double high) {
  JsonField* field = noted(key);
  if (!field) return;
  const bool is_integer = field->schema["type"] == "integer";
  const auto limit = [&](double value) {
    return is_integer ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  field->schema["minimum"] = limit(low);
  if (std::isfinite(high)) field->schema["maximum"] = limit(high);
}

void JsonObject::words(const std::string& key, const std::vector<std::string>& known) {
  JsonField* field = noted(key);
  if (!field) return;
  Json& schema = field->schema.contains("items") ? field->schema["items"] : field->schema;
  schema["enum"] = known;
}

void JsonObject::shape(const std::string& key, const char* schema) {
  if (JsonField* field = noted(key)) field->schema.update(Json::parse(schema));
}

void JsonObject::about(std::initializer_list<std::pair<const char*, const char*>> meanings) {
  for (const auto& [key, meaning] : meanings)
    if (fields_ && known_.contains(key)) noted(key)->about = meaning;
}

std::string JsonObject::place_of(const std::string& key) const {
  return place_ + " " + pointer_ + "/" + escaped(key);
}

void JsonObject::refuse(const std::string& key, const std::string& problem) const {
  throw InputError(place_of(key), problem);
}

const Json* JsonObject::find(const std::string& key, bool required) {
  if (known_.insert(key).second && fields_) {
    JsonField& field = fields_->of(key);
    field.required = required && (field.required || !field.was_asked);
    field.was_asked = true;
  }
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

const Json& JsonObject::need(const std::string& key) {
  const Json* found = find(key, true);
  if (!found) refuse(key, "is missing");
  return *found;
}

namespace {

// What takes a document, for whoever gave it to something else.
std::string taker_of(const std::string& format) {
  constexpr std::pair<std::string_view, const char*> kTakers[] = {
      {"trilat.study", "`trilat run` takes"},
      {"trilat.simulation", "`trilat simulate` takes"},
      {"trilat.campaign", "`trilat run STUDY.json --campaign` takes"},
      {"trilat.calibration", "`trilat run --calibration` and `trilat fuse` take"},
      {"trilat.mapping", "a take of a campaign names"},
      {"trilat.results", "`trilat report` and `trilat gate` take"}};
  for (const auto& [known, taker] : kTakers)
    if (known == format) return "is \"" + format + "\", which " + taker + "; here it ";
  return {};
}

}  // namespace

void JsonObject::format(const std::string& name, std::int64_t version) {
  if (const std::string given = text("format"); given != name)
    refuse("format", taker_of(given) + "must be \"" + name + '"');
  if (integer("version") != version)
    refuse("version", "must be " + std::to_string(version) + ", the version that this program reads");
  if (!fields_) return;
  noted("format")->schema = {{"const", name}};
  noted("version")->schema = {{"const", version}};
}

void JsonObject::removed(const std::string& key, const std::string& instead) const {
  if (value_->contains(key)) refuse(key, "was removed; " + instead);
}

void JsonObject::refuse_below(const std::string& path, const std::string& problem) const {
  throw InputError(place_ + " " + pointer_ + "/" + path, problem);
}

bool JsonObject::has(const std::string& key) { return find(key) != nullptr; }

double JsonObject::as_number(const std::string& key, const Json& value) const {
  if (!value.is_number()) refuse(key, "must be a number, is " + type_of(value));
  const double number = value.get<double>();
  if (!std::isfinite(number)) refuse(key, "must be a finite number");
  return number;
}

double JsonObject::number(const std::string& key) {
  const Json& value = need(key);
  note_type(key, "number");
  return as_number(key, value);
}

double JsonObject::number(const std::string& key, double fallback) {
  const Json* found = find(key);
  note_type(key, "number");
  note_default(key, fallback);
  return found ? as_number(key, *found) : fallback;
}

double JsonObject::positive(const std::string& key) {
  const double number = this->number(key);
  if (JsonField* field = noted(key)) field->schema["exclusiveMinimum"] = 0;
  if (!(number > 0.0)) refuse(key, "must be greater than 0, is " + need(key).dump());
  return number;
}

double JsonObject::positive(const std::string& key, double fallback) {
  const bool is_there = has(key);
  note_type(key, "number");
  note_default(key, fallback);
  if (JsonField* field = noted(key)) field->schema["exclusiveMinimum"] = 0;
  return is_there ? positive(key) : fallback;
}

std::int64_t JsonObject::integer(const std::string& key) {
  const Json& value = need(key);
  note_type(key, "integer");
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
  note_type(key, "integer");
  range(key, 0.0, std::numeric_limits<double>::infinity());
  if (!value.is_number_unsigned()) refuse(key, "must be an integer of 0 or more, is " + type_of(value));
  return value.get<std::uint64_t>();
}

std::uint64_t JsonObject::count(const std::string& key, std::uint64_t fallback) {
  const bool is_there = has(key);
  note_type(key, "integer");
  note_default(key, fallback);
  range(key, 0.0, std::numeric_limits<double>::infinity());
  return is_there ? count(key) : fallback;
}

bool JsonObject::boolean(const std::string& key, bool fallback) {
  const Json* found = find(key);
  note_type(key, "boolean");
  note_default(key, fallback);
  if (!found) return fallback;
  if (!found->is_boolean()) refuse(key, "must be true or false, is " + type_of(*found));
  return found->get<bool>();
}

std::string JsonObject::text(const std::string& key) {
  const Json& value = need(key);
  note_type(key, "string");
  if (!value.is_string()) refuse(key, "must be a text, is " + type_of(value));
  return value.get<std::string>();
}

std::string JsonObject::text(const std::string& key, std::string fallback) {
  const bool is_there = has(key);
  note_type(key, "string");
  note_default(key, fallback);
  return is_there ? text(key) : std::move(fallback);
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& known) {
  const std::string word = text(key);
  words(key, known);
  const auto found = std::ranges::find(known, word);
  if (found == known.end()) refuse(key, "is \"" + word + "\", which is unknown; " + known_names(word, known));
  return static_cast<std::size_t>(found - known.begin());
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& known,
                               std::size_t fallback) {
  const bool is_there = has(key);
  note_type(key, "string");
  words(key, known);
  note_default(key, known[fallback]);
  return is_there ? choice(key, known) : fallback;
}

std::size_t JsonObject::branch(const std::string& key, const std::vector<std::string>& known) {
  const std::size_t chosen = choice(key, known);
  if (!fields_) return chosen;
  auto& branches = fields_->branches;
  auto found =
      std::ranges::find(branches, known[chosen], &std::pair<std::string, std::shared_ptr<JsonFields>>::first);
  if (found == branches.end())
    found = branches.insert(branches.end(), {known[chosen], std::make_shared<JsonFields>()});
  fields_ = found->second;
  JsonField& field = fields_->of(key);
  field.required = true;
  field.schema = {{"const", known[chosen]}};
  return chosen;
}

const Json& JsonObject::need_array(const std::string& key, std::size_t size, const char* what) {
  const Json& value = need(key);
  if (!value.is_array() || value.size() != size)
    refuse(key, "must be an array of " + std::to_string(size) + ' ' + what);
  return value;
}

std::vector<double> JsonObject::numbers(const std::string& key, std::size_t size) {
  std::vector<double> result;
  note_list(key, "number", size);
  for (const Json& element : need_array(key, size, "numbers")) result.push_back(as_number(key, element));
  return result;
}

std::vector<std::string> JsonObject::texts(const std::string& key) {
  const Json& value = need(key);
  if (JsonField* field = noted(key)) field->has_any_size = true;
  note_list(key, "string", 0);
  if (!value.is_array()) refuse(key, "must be an array of texts, is " + type_of(value));
  std::vector<std::string> result;
  for (const Json& element : value) {
    if (!element.is_string()) refuse(key, "must hold texts only, has " + type_of(element));
    result.push_back(element.get<std::string>());
  }
  return result;
}

std::vector<std::string> JsonObject::texts(const std::string& key, std::vector<std::string> fallback) {
  const bool is_there = has(key);
  if (JsonField* field = noted(key)) field->has_any_size = true;
  note_list(key, "string", 0);
  note_default(key, fallback);
  return is_there ? texts(key) : std::move(fallback);
}

JsonObject JsonObject::object(const std::string& key) {
  JsonObject member(need(key), place_, pointer_ + "/" + escaped(key));
  note_type(key, "object");
  member.fields_ = members_of(key);
  return member;
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) {
  const Json& value = need(key);
  if (!value.is_array()) refuse(key, "must be an array of objects, is " + type_of(value));
  note_type(key, "array");
  if (JsonField* field = noted(key)) field->schema["items"] = Json::object();
  std::vector<JsonObject> result;
  for (std::size_t i = 0; i < value.size(); ++i) {
    result.emplace_back(value[i], place_, pointer_ + "/" + escaped(key) + "/" + std::to_string(i));
    result.back().fields_ = members_of(key);
  }
  return result;
}

std::shared_ptr<JsonFields> JsonObject::members_of(const std::string& key) {
  JsonField* field = noted(key);
  if (!field) return nullptr;
  if (!field->members) field->members = std::make_shared<JsonFields>();
  return field->members;
}

const Json& JsonObject::value(const std::string& key) {
  const Json& value = need(key);
  if (JsonField* field = noted(key)) field->has_any_size = true;
  return value;
}

std::vector<std::string> JsonObject::keys() const {
  if (fields_) fields_->are_data = true;
  std::vector<std::string> result;
  for (const auto& item : value_->items()) result.push_back(item.key());
  return result;
}

void JsonObject::finish() {
  for (const auto& item : value_->items())
    if (!known_.contains(item.key()) && !(pointer_.empty() && item.key() == "$schema"))
      refuse(item.key(), "is an unknown key; " + known_names(item.key(), {known_.begin(), known_.end()}));
}

}  // namespace trilat
