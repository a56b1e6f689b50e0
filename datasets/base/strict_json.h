// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>

namespace trilat {

// Keys keep the order in which they were written.
using Json = nlohmann::ordered_json;

// Parses text and refuses what plain JSON parsers let pass: duplicate keys, NaN, trailing text, nesting
// beyond 64. `place` is the file name; errors read `place:line: …` or `place /pointer: …`.
Json parse_json(std::string_view text, const std::string& place);
Json read_json(const std::filesystem::path& path);

// The document as text. Names from outside need not be UTF-8: bytes that are not become U+FFFD.
std::string json_text(const Json& json, int indent);
// The same for what has to name files and assets exactly: InputError with the text in it that is not UTF-8.
std::string exact_json_text(const Json& json, int indent);

// The first text that an earlier one equals; empty when all differ.
std::string first_repeated(const std::vector<std::string>& texts);

struct JsonField;
struct JsonFields;

// While it lives, what readers ask the document for is noted in `fields`; see json_schema.h.
class JsonNotes {
 public:
  JsonNotes(const Json& document, std::shared_ptr<JsonFields> fields);
  ~JsonNotes();
  JsonNotes(const JsonNotes&) = delete;
  JsonNotes& operator=(const JsonNotes&) = delete;
};

// Walks one JSON object strictly: every key has to be asked for, of the right type, or finish() names it and
// lists the known ones; but a document may name its "$schema". A number 1.7 is no integer, -1 is not
// unsigned, infinity is not a number.
class JsonObject {
 public:
  // `place` and `pointer` say where `value` stands; it must outlive the reader.
  JsonObject(const Json& value, std::string place, std::string pointer);

  // The keys "format" and "version", which must be these.
  void format(const std::string& name, std::int64_t version = 1);
  bool has(const std::string& key);
  double number(const std::string& key);
  double number(const std::string& key, double fallback);
  double positive(const std::string& key);
  double positive(const std::string& key, double fallback);
  std::int64_t integer(const std::string& key);
  std::int64_t integer(const std::string& key, std::int64_t fallback);
  std::uint64_t count(const std::string& key);
  std::uint64_t count(const std::string& key, std::uint64_t fallback);
  bool boolean(const std::string& key, bool fallback);
  std::string text(const std::string& key);
  std::string text(const std::string& key, std::string fallback);
  // The position of the text under `key` in `known`; an unknown word is refused with the list.
  std::size_t choice(const std::string& key, const std::vector<std::string>& known);
  std::size_t choice(const std::string& key, const std::vector<std::string>& known, std::size_t fallback);
  // The same for a word that decides which other keys there are.
  std::size_t branch(const std::string& key, const std::vector<std::string>& known);
  std::vector<double> numbers(const std::string& key, std::size_t size);
  std::vector<std::string> texts(const std::string& key);
  std::vector<std::string> texts(const std::string& key, std::vector<std::string> fallback);
  JsonObject object(const std::string& key);
  std::vector<JsonObject> objects(const std::string& key);
  // The value itself, for what has more than one shape.
  const Json& value(const std::string& key);
  std::vector<std::string> keys() const;

  // What a schema says of a key that was asked for, beside what the asking told: in which range or of which
  // words its reader wants it, what it looks like (as JSON Schema), what keys mean.
  void range(const std::string& key, double low, double high);
  void words(const std::string& key, const std::vector<std::string>& known);
  void shape(const std::string& key, const char* schema);
  void about(std::initializer_list<std::pair<const char*, const char*>> meanings);

  // Refuses a key of earlier versions with what to use instead.
  void removed(const std::string& key, const std::string& instead) const;
  // Refuses keys nobody asked for.
  void finish();

  // An error at `key` of this object.
  [[noreturn]] void refuse(const std::string& key, const std::string& problem) const;
  std::string place_of(const std::string& key) const;
  // An error, and a reader of `value`, at `path` below this object: keys with '/' between them.
  [[noreturn]] void refuse_below(const std::string& path, const std::string& problem) const;
  JsonObject below(const std::string& path, const Json& value) const {
    return {value, place_, pointer_ + "/" + path};
  }
  const std::string& file() const { return place_; }

 private:
  const Json* find(const std::string& key, bool required = false);
  const Json& need(const std::string& key);
  const Json& need_array(const std::string& key, std::size_t size, const char* what);
  double as_number(const std::string& key, const Json& value) const;
  // The field of a key that was asked for; null when nothing is noted.
  JsonField* noted(const std::string& key);
  void note_type(const std::string& key, const char* type);
  template <class Value>
  void note_default(const std::string& key, const Value& value);
  std::shared_ptr<JsonFields> members_of(const std::string& key);
  void note_list(const std::string& key, const char* type, std::size_t size);

  const Json* value_;
  std::string place_;
  std::string pointer_;
  std::set<std::string> known_;
  std::shared_ptr<JsonFields> fields_;
};

// A number that must lie in a range, and be there without a fallback.
inline double number_within(JsonObject& object, const std::string& key, std::optional<double> fallback,
                            double low, double high) {
  const double value = fallback ? object.number(key, *fallback) : object.number(key);
  object.range(key, low, high);
  if (!(value >= low && value <= high))
    object.refuse(key, "must lie between " + Json(low).dump() + " and " + Json(high).dump());
  return value;
}

}  // namespace trilat
