// SPDX-License-Identifier: MIT
#include "datasets/base/document.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/files.h"
#include "datasets/base/units.h"
#include "datasets/base/words.h"

namespace trilat {
namespace {

// For a refusal: the verb that reads a document of this format.
std::string verb_that_reads(const std::string& format) {
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

// The last key of a pointer that is no index.
std::string key_of(const JsonPlace& place) {
  std::string_view pointer = place.pointer;
  for (;;) {
    const std::size_t slash = pointer.rfind('/');
    if (slash == std::string_view::npos) return std::string(pointer);
    const std::string_view key = pointer.substr(slash + 1);
    if (key.find_first_not_of("0123456789") != std::string_view::npos) return std::string(key);
    pointer = pointer.substr(0, slash);
  }
}

void check_range(const JsonPlace& place, const Json& json, const Range& range, bool is_integer) {
  const auto given = json.get<double>();
  if (given >= range.min && given <= range.max && !(range.above && given == range.min)) return;
  const std::string other_unit = key_of(place).ends_with("_m")
                                     ? in_metres_text(given, range.min, std::min(range.max, 1e9))
                                     : std::string();
  std::string wanted = fmt::format("not be less than {:g}", range.min);
  if (range.above && std::isfinite(range.max))
    wanted = fmt::format("be greater than {:g} and at most {:g}", range.min, range.max);
  else if (range.above)
    wanted = fmt::format("be greater than {:g}", range.min);
  else if (is_integer && std::isfinite(range.max))
    wanted = fmt::format("be {:.0f} to {:.0f}", range.min, range.max);
  else if (std::isfinite(range.max))
    wanted = fmt::format("lie between {:g} and {:g}", range.min, range.max);
  place.refuse(fmt::format("must {}, is {}{}", wanted, json.dump(), other_unit));
}

void want(const JsonPlace& place, const Json& json, bool is_right, std::string_view what) {
  if (!is_right) place.refuse(fmt::format("must be {}, is {}", what, type_of(json)));
}

}  // namespace

About About::items(std::size_t least, std::size_t most) && {
  min_items = least;
  max_items = most;
  return std::move(*this);
}

About About::one_of(std::vector<std::string> known) && {
  words = std::move(known);
  return std::move(*this);
}

About need(std::string meaning, Range range, double unit) {
  return {.meaning = std::move(meaning), .range = range, .unit = unit};
}

About opt(std::string meaning, Range range, double unit) {
  return {.meaning = std::move(meaning), .range = range, .unit = unit, .required = false};
}

Fields::Fields(Mode mode, bool is_list) : mode_(mode), is_list_(is_list) {}

Fields::Fields(const Json& object, const JsonPlace& place, bool is_list)
    : mode_(Mode::read), is_list_(is_list), read_(&object), place_(place) {
  want(place, object, is_list ? object.is_array() : object.is_object(), is_list ? "a list" : "an object");
}

Fields Fields::writer(bool is_list) {
  Fields f(Mode::write, is_list);
  f.json_ = is_list ? Json::array() : Json::object();
  return f;
}

Fields Fields::describer(bool is_list) {
  Fields f(Mode::describe, is_list);
  f.json_ = {{"type", "object"},
             {"properties", Json::object()},
             {"required", Json::array()},
             {"additionalProperties", false}};
  return f;
}

void Fields::renamed(const char* key, const std::string& now) const {
  if (reads() && read_->contains(key)) refuse(key, "is called \"" + now + "\" now");
}

void Fields::useless(std::initializer_list<const char*> keys, const std::string& condition) const {
  if (reads())
    for (const char* key : keys)
      if (read_->contains(key)) refuse(key, "is of no use " + condition);
}

std::set<std::string> Fields::keys() const {
  std::set<std::string> keys;
  if (reads())
    for (const auto& [key, value] : read_->items()) keys.insert(key);
  return keys;
}

bool Fields::has(const char* key, bool there) const {
  return reads() ? read_->contains(key) : describes() || there;
}

void Fields::visit(const char* key, const About& about, void* member, const json_value::Type& type) {
  if (mode_ == Mode::describe) {
    Json schema = type.schema(member, about);
    if (schema.value("default", Json()) == "") schema.erase("default");  // without the key there is no text
    if (!about.meaning.empty()) schema["description"] = about.meaning;
    json_["properties"][key] = std::move(schema);
    if (about.required) json_["required"].push_back(key);
  } else if (mode_ == Mode::write) {
    if (type.is_absent(member)) return;
    (is_list_ ? json_.emplace_back() : json_[key]) = type.write(member, about);
  } else if (is_list_) {
    const std::size_t i = known_.size();
    known_.push_back(key);
    if (i >= read_->size()) place_.refuse(fmt::format("has no {}", key));
    type.read((*read_)[i], place_.at(i), about, member);
  } else {
    known_.push_back(key);
    const auto found = read_->find(key);
    const bool may_lack = !about.required || (about.meaning.empty() && type.is_absent(member));
    if (found != read_->end())
      type.read(*found, place_.at(key), about, member);
    else if (!may_lack)
      place_.at(key).refuse("is missing");
  }
}

void Fields::named(const char* key, bool& value, const std::vector<std::string>& names, About about) {
  std::string word = names.at(value ? 1 : 0);
  (*this)(key, word, std::move(about).one_of(names));
  if (reads()) value = word == names.at(1);
}

void Fields::tag(const char* key, std::size_t& number, const std::vector<std::string>& words,
                 const std::string& meaning) {
  if (reads()) {
    known_.push_back(key);
    if (!read_->contains(key)) refuse(key, "is missing; allowed: " + join_names(words));
    number = json_value::read_word(read_->at(key), place_.at(key), words);
  } else if (describes()) {
    json_["properties"][key] = {{"const", words.at(number)}};
    if (!meaning.empty()) json_["properties"][key]["description"] = meaning;
    json_["required"].push_back(key);
  } else {
    json_[key] = words.at(number);
  }
}

void Fields::format(const char* name, int version) {
  if (describes()) {
    json_["properties"].update({{"format", {{"const", name}}}, {"version", {{"const", version}}}});
    json_["required"].insert(json_["required"].end(), {"format", "version"});
    return;
  }
  std::string format = name;
  std::int64_t number = version;
  if (reads() && !read_->contains("format"))
    refuse("format", fmt::format("is missing; here it must be \"{}\"", name));
  (*this)("format", format, "version", number);
  if (format != name) refuse("format", verb_that_reads(format) + "must be \"" + name + '"');
  if (number != version)
    refuse("version", fmt::format("must be {}, the version that this program reads, is {}", version, number));
}

void Fields::removed(const char* key, const std::string& instead) const {
  if (reads() && read_->contains(key)) refuse(key, "was removed; " + instead);
}

void Fields::removed(const char* key, const std::string& word, const std::string& instead) const {
  if (reads() && read_->contains(key) && read_->at(key) == word)
    refuse(key, '"' + word + "\" was removed; " + instead);
}

void Fields::finish() const {
  if (is_list_) {
    if (read_->size() != known_.size()) place_.refuse(fmt::format("must be a list of {}", known_.size()));
    return;
  }
  for (const auto& [key, value] : read_->items())
    if (std::ranges::find(known_, key) == known_.end() && !(place_.pointer.empty() && key == "$schema"))
      place_.at(key).refuse("is an unknown key; " + known_names(key, known_));
}

namespace json_value {

void read(const Json& json, const JsonPlace& place, const About&, bool& into) {
  want(place, json, json.is_boolean(), "true or false");
  into = json.get<bool>();
}

void read(const Json& json, const JsonPlace& place, const About& about, double& into) {
  const bool may_lack = about.meaning.empty();
  if (may_lack && json.is_null()) {
    into = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  want(place, json, json.is_number(), may_lack ? "a number or null" : "a number");
  if (!std::isfinite(json.get<double>())) place.refuse("must be a finite number");
  check_range(place, json, about.range, false);
  into = json.get<double>() * about.unit;
}

void read(const Json& json, const JsonPlace& place, const About& about, std::string& into) {
  want(place, json, json.is_string(), "a text");
  into = json.get<std::string>();
  if (!about.words.empty()) read_word(json, place, about.words);
}

void read(const Json& json, const JsonPlace& place, const About&, std::filesystem::path& into) {
  want(place, json, json.is_string(), "a text");
  const auto path = json.get<std::string>();
  if (path.empty()) place.refuse("must name a file");
  into = place.folder / path;
  if (is_special_file(into)) place.refuse("\"" + path + "\" is a device, a pipe or a socket");
}

std::int64_t read_integer(const Json& json, const JsonPlace& place, const About& about, std::int64_t min,
                          std::int64_t max) {
  want(place, json, json.is_number_integer(), "an integer");
  const bool fits = json.is_number_unsigned() ? std::cmp_less_equal(json.get<std::uint64_t>(), max)
                                              : json.get<std::int64_t>() >= min;
  if (!fits) place.refuse(fmt::format("must lie between {} and {}, is {}", min, max, json.dump()));
  check_range(place, json, about.range, true);
  return json.get<std::int64_t>();
}

std::uint64_t read_count(const Json& json, const JsonPlace& place, const About& about, std::uint64_t max) {
  const bool is_count =
      json.is_number_unsigned() || (json.is_number_integer() && json.get<std::int64_t>() >= 0);
  want(place, json, is_count, "an integer of 0 or more");
  if (json.get<std::uint64_t>() > max) place.refuse(fmt::format("must be 0 to {}, is {}", max, json.dump()));
  check_range(place, json, about.range, true);
  return json.get<std::uint64_t>();
}

std::size_t read_word(const Json& json, const JsonPlace& place, const std::vector<std::string>& known) {
  want(place, json, json.is_string(), "a text");
  const auto word = json.get<std::string>();
  const auto found = std::ranges::find(known, word);
  if (found == known.end()) place.refuse("unknown value \"" + word + "\"; " + known_names(word, known));
  return static_cast<std::size_t>(found - known.begin());
}

void check_list(const Json& json, const JsonPlace& place, const About& about) {
  want(place, json, json.is_array(), "a list");
  const std::size_t n = json.size();
  if (n < about.min_items && about.min_items == 1) place.refuse("must hold at least one entry");
  if (n < about.min_items || n > about.max_items)
    place.refuse(fmt::format("must hold {} to {} entries, holds {}", about.min_items, about.max_items, n));
}

void check_fixed_list(const Json& json, const JsonPlace& place, std::size_t size) {
  if (!json.is_array() || json.size() != size)
    place.refuse(fmt::format("must be a list of {} numbers", size));
}

void check_differ(const Json& json, const JsonPlace& place) {
  for (auto entry = json.begin(); entry != json.end(); ++entry)
    if (std::find(json.begin(), entry, *entry) != entry)
      place.refuse("has " + json_text(*entry, -1) + " twice");
}

void check_object(const Json& json, const JsonPlace& place) {
  want(place, json, json.is_object(), "an object");
}

Json write(double value, const About& about) {
  if (!std::isfinite(value)) return {};
  if (about.unit == 1.0) return value;
  return std::stod(fmt::format("{:.12g}", value / about.unit));  // a conversion leaves 9.99…e-05
}

Json number_schema(const About& about, bool is_integer, bool is_unsigned) {
  Json schema{{"type", is_integer ? "integer" : "number"}};
  const auto limit = [&](double value) {
    const bool is_whole = std::abs(value) < 1e15 && std::trunc(value) == value;
    return is_integer || is_whole ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  if (about.range.above)
    schema["exclusiveMinimum"] = limit(about.range.min);
  else if (std::isfinite(about.range.min))
    schema["minimum"] = limit(about.range.min);
  else if (is_unsigned)
    schema["minimum"] = 0;
  if (std::isfinite(about.range.max)) schema["maximum"] = limit(about.range.max);
  return schema;
}

Json list_schema(Json items, const About& about) {
  Json schema{{"type", "array"}, {"items", std::move(items)}};
  if (about.min_items > 0) schema["minItems"] = about.min_items;
  if (about.max_items < About{}.max_items) schema["maxItems"] = about.max_items;
  return schema;
}

Json text_schema(const About& about) {
  return about.words.empty() ? Json{{"type", "string"}} : word_schema(about.words);
}

Json word_schema(const std::vector<std::string>& known) { return {{"type", "string"}, {"enum", known}}; }

}  // namespace json_value

}  // namespace trilat
