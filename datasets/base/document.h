// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "datasets/base/json.h"
#include "datasets/base/words.h"

// A document is described once: a struct has
//
//   static void fields(auto& self, auto&& f) {
//     f("radius_m", self.radius_m, need("of the circle", {0.3, 20.0}));
//     f("centre_m", self.centre_m, opt("where the sensors look"));
//   }
//
// and is read (strictly), written and described by it. In files that only the program writes a field needs no
// meaning, and several stand in one line: f("study", self.study, "rows", self.rows). A struct may have
// `void check(const JsonPlace&) const`, which refuses what one key says against another.
namespace trilat {

// Limits of a number, ends included, in the document's unit.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above = false;  // min itself is not allowed
};
inline constexpr Range kPositive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0.0};

// Description of one field. A field without a meaning belongs to a file that only the program
// writes: there a number that is not finite is null, and a list may hold a text twice.
struct About {
  std::string meaning = {};
  Range range = {};
  double unit = 1.0;  // what one of the document's is in the struct
  bool required = true;
  std::size_t min_items = 0, max_items = std::numeric_limits<std::size_t>::max();
  std::vector<std::string> words = {};  // that a text may be; empty: any

  About items(std::size_t least, std::size_t most = std::numeric_limits<std::size_t>::max()) &&;
  About one_of(std::vector<std::string> known) &&;
};
About need(std::string meaning, Range range = {}, double unit = 1.0);
// Without the key the member keeps the value that it has: the default.
About opt(std::string meaning, Range range = {}, double unit = 1.0);

// A key that may be missing, of a file that only the program writes.
inline const About kMayLack{.required = false};

class Fields;

template <class T>
concept Described = requires(T& value, Fields& f) {
  T::fields(value, f);
};

template <Described T>
void read_document(const Json& json, const JsonPlace& place, T& into);
template <Described T>
T read_as(const Json& json, const JsonPlace& place);
template <Described T>
Json json_of(const T& value);
template <Described T>
Json json_of(const std::vector<T>& values);
// JSON Schema (draft 2020-12) of a document.
template <Described T>
Json schema_of();

// Markdown of a schema: a table of keys with values, defaults and meanings; more for a list whose entries
// have a key that decides which others there are. Branches that are in `described` are referred to, not
// repeated.
std::string markdown_of_schema(const Json& schema, const std::string& title,
                               std::set<std::string>& described);

namespace json_value {

// Operations on a value of one type, given its address.
struct Type {
  void (*read)(const Json& json, const JsonPlace& place, const About& about, void* into);
  Json (*write)(const void* value, const About& about);
  Json (*schema)(const void* value, const About& about);
  bool (*is_absent)(const void* value);  // an empty optional
};
template <class T>
const Type& type_of();

}  // namespace json_value

// Visits the fields of a struct to read, write or describe them.
class Fields {
 public:
  // Reading. `is_list`: the values stand in a list, without their keys.
  Fields(const Json& object, const JsonPlace& place, bool is_list);
  static Fields writer(bool is_list);
  static Fields describer(bool is_list);

  template <class T>
  void operator()(const char* key, T& member, const About& about) {
    visit(key, about, const_cast<std::remove_const_t<T>*>(&member),
          json_value::type_of<std::remove_const_t<T>>());
  }
  template <class T, class... More>
  requires(sizeof...(More) % 2 == 0) void operator()(const char* key, T& member, More&&... more) {
    (*this)(key, member, About{});
    if constexpr (sizeof...(more) > 0) (*this)(more...);
  }
  // A field that is computed from others: it is written, and not read.
  template <class T>
  void written(const char* key, const T& value) {
    if (!reads()) return (*this)(key, value, About{});
    known_.push_back(key);
  }
  // A bool whose two values have names.
  void named(const char* key, bool& value, const std::vector<std::string>& names, About about);
  // A word that decides which other keys there are: its number. Described is the one that it is.
  void tag(const char* key, std::size_t& number, const std::vector<std::string>& words,
           const std::string& meaning);
  // The keys "format" and "version", which must be these.
  void format(const char* name, int version = 1);
  // Refuses a key of earlier versions with what to use instead.
  void removed(const char* key, const std::string& instead) const;
  void removed(const char* key, const std::string& word, const std::string& instead) const;
  void renamed(const char* key, const std::string& now) const;
  // Refuses keys that need the value of another: "is of no use without \"each\"".
  void useless(std::initializer_list<const char*> keys, const std::string& condition) const;
  // The keys of what is read.
  std::set<std::string> keys() const;

  bool writes() const { return mode_ == Mode::write; }
  bool reads() const { return read_ != nullptr; }
  bool describes() const { return mode_ == Mode::describe; }
  // Whether a key is there: in what is read; else `there`, or in the description always.
  bool has(const char* key, bool there) const;
  // For fields that go with a value of another: true in the description.
  bool when(bool condition) const { return describes() || condition; }
  // The fields are only written where this holds.
  bool writes_if(bool condition) const { return mode_ != Mode::write || condition; }
  [[noreturn]] void refuse(const char* key, const std::string& problem) const {
    place_.at(key).refuse(problem);
  }

  // After all fields: refuses keys that none of them has.
  void finish() const;
  Json take() { return std::move(json_); }

 private:
  enum class Mode : std::uint8_t { read, write, describe };
  Fields(Mode mode, bool is_list);
  void visit(const char* key, const About& about, void* member, const json_value::Type& type);

  Mode mode_;
  bool is_list_;
  const Json* read_ = nullptr;
  JsonPlace place_{"", {}};
  Json json_;  // what is written, or the schema
  std::vector<std::string> known_;
};

namespace json_value {

// ---- values without parts
void read(const Json&, const JsonPlace&, const About&, bool&);
void read(const Json&, const JsonPlace&, const About&, double&);
void read(const Json&, const JsonPlace&, const About&, std::string&);
// Relative to the document's folder. Refused when it is empty or names a device, a pipe or a socket.
void read(const Json&, const JsonPlace&, const About&, std::filesystem::path&);
std::int64_t read_integer(const Json&, const JsonPlace&, const About&, std::int64_t min, std::int64_t max);
std::uint64_t read_count(const Json&, const JsonPlace&, const About&, std::uint64_t max);
std::size_t read_word(const Json&, const JsonPlace&, const std::vector<std::string>& known);
Json write(double, const About&);
Json number_schema(const About&, bool is_integer, bool is_unsigned);
Json list_schema(Json items, const About&);
Json text_schema(const About&);
Json word_schema(const std::vector<std::string>& known);
// Refuses anything but a list of so many.
void check_list(const Json&, const JsonPlace&, const About&);
void check_fixed_list(const Json&, const JsonPlace&, std::size_t size);
void check_differ(const Json&, const JsonPlace&);
void check_object(const Json&, const JsonPlace&);

template <class T>
concept Optional = requires(T& value) {
  value.has_value();
  value.emplace();
};
template <class T>
concept Map = requires {
  typename T::mapped_type;
};
template <class T>
concept FixedList = requires {
  std::tuple_size<T>::value;
}
|| requires { requires static_cast<int>(T::SizeAtCompileTime) > 0; };
template <class T>
concept List = requires(T& value) {
  value.begin();
  value.resize(2);
  typename T::value_type;
}
&&!std::is_same_v<T, std::string>;
// A value of more than one shape, that says itself how it is read, written and described.
template <class T>
concept Own = requires(T& value, const Json& json, const JsonPlace& place, const About& about) {
  value.read(json, place, about);
  value.schema(about);
};

template <class T>
constexpr bool is_list() {
  if constexpr (requires { T::kIsList; }) return T::kIsList;
  return false;
}
template <class T>
void read_value(const Json& json, const JsonPlace& place, const About& about, T& into) {
  if constexpr (std::is_same_v<T, Json>) {
    into = json;
  } else if constexpr (Own<T>) {
    into.read(json, place, about);
  } else if constexpr (Described<T>) {
    read_document(json, place, into);
  } else if constexpr (Optional<T>) {
    // A number that is not finite was written as null: null is NaN, not an empty optional.
    const bool is_empty =
        json.is_null() && about.meaning.empty() && !std::is_same_v<T, std::optional<double>>;
    into.reset();
    if (!is_empty) read_value(json, place, about, into.emplace());
  } else if constexpr (Map<T>) {
    check_object(json, place);
    into.clear();
    for (const auto& [key, value] : json.items()) read_value(value, place.at(key), about, into[key]);
  } else if constexpr (std::is_enum_v<T>) {
    static_assert(words<T>.size() > 0, "which names do its values have?");
    into = static_cast<T>(read_word(json, place, words_of<T>()));
  } else if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, double> ||
                       std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>) {
    read(json, place, about, into);
  } else if constexpr (std::is_unsigned_v<T>) {
    into = static_cast<T>(read_count(json, place, about, std::numeric_limits<T>::max()));
  } else if constexpr (std::is_integral_v<T>) {
    into = static_cast<T>(
        read_integer(json, place, about, std::numeric_limits<T>::min(), std::numeric_limits<T>::max()));
  } else if constexpr (FixedList<T>) {
    check_fixed_list(json, place, static_cast<std::size_t>(into.size()));
    std::size_t i = 0;
    for (auto& entry : into) read_value(json[i], place.at(i), about, entry), ++i;
  } else {
    static_assert(List<T>);
    check_list(json, place, about);
    into.clear();
    into.resize(json.size());
    for (std::size_t i = 0; i < json.size(); ++i) read_value(json[i], place.at(i), about, into[i]);
    using Entry = typename T::value_type;
    if constexpr (std::is_same_v<Entry, std::string> || std::is_enum_v<Entry>)
      if (!about.meaning.empty()) check_differ(json, place);
  }
}

template <class T>
Json written(const T& value, const About& about) {
  if constexpr (std::is_same_v<T, Json>) {
    return value;
  } else if constexpr (requires { value.json(); }) {
    return value.json();
  } else if constexpr (Own<T>) {
    return {};  // it is only read
  } else if constexpr (Described<T>) {
    return json_of(value);
  } else if constexpr (Optional<T>) {
    return value ? written(*value, about) : Json();
  } else if constexpr (Map<T>) {
    Json json = Json::object();
    for (const auto& [key, entry] : value) json[key] = written(entry, about);
    return json;
  } else if constexpr (std::is_enum_v<T>) {
    return word_of(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    return write(value, about);
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return value.generic_string();
  } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else {
    Json json = Json::array();
    for (const auto& entry : value) json.push_back(written(entry, about));
    return json;
  }
}

template <Described T>
Json struct_schema(const T& value) {
  Fields f = Fields::describer(is_list<T>());
  T::fields(const_cast<T&>(value), f);  // changed when it is read, not here
  return f.take();
}

template <class T>
Json schema(const T& value, const About& about) {
  if constexpr (std::is_same_v<T, Json>) {
    return Json::object();
  } else if constexpr (Own<T>) {
    return value.schema(about);
  } else if constexpr (requires { T::alternatives(); }) {
    Json branches = Json::array();
    for (const T& one : T::alternatives()) branches.push_back(struct_schema(one));
    return {{"oneOf", branches}};
  } else if constexpr (Described<T>) {
    return struct_schema(value);
  } else if constexpr (Optional<T>) {
    return schema(typename T::value_type{}, about);
  } else if constexpr (Map<T>) {
    return {{"type", "object"}, {"additionalProperties", schema(typename T::mapped_type{}, about)}};
  } else if constexpr (std::is_enum_v<T>) {
    return word_schema(words_of<T>());
  } else if constexpr (std::is_same_v<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::is_arithmetic_v<T>) {
    return number_schema(about, std::is_integral_v<T>, std::is_unsigned_v<T>);
  } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>) {
    return text_schema(about);
  } else {
    About entries = about;
    if constexpr (FixedList<T>)
      entries.min_items = entries.max_items = static_cast<std::size_t>(value.size());
    const std::remove_cvref_t<decltype(*value.begin())> entry{};
    return list_schema(schema(entry, about), entries);
  }
}

// Whether a schema states the value that a field has without its key.
template <class T>
constexpr bool kHasDefault = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string> ||
                             std::is_same_v<T, std::vector<std::string>>;

template <class T>
const Type& type_of() {
  static constexpr Type type{
      [](const Json& json, const JsonPlace& place, const About& about, void* into) {
        read_value(json, place, about, *static_cast<T*>(into));
      },
      [](const void* value, const About& about) { return written(*static_cast<const T*>(value), about); },
      [](const void* value, const About& about) {
        const T& of = *static_cast<const T*>(value);
        Json json = schema(of, about);
        if constexpr (kHasDefault<T>)
          if (!about.required && about.min_items == 0) json["default"] = written(of, about);
        return json;
      },
      [](const void* value) {
        if constexpr (Optional<T>) return !static_cast<const T*>(value)->has_value();
        return false;
      }};
  return type;
}

}  // namespace json_value

template <Described T>
void read_document(const Json& json, const JsonPlace& place, T& into) {
  Fields f(json, place, json_value::is_list<T>());
  T::fields(into, f);
  if constexpr (!requires { T::kHasMore; }) f.finish();  // else other keys are for other readers
  if constexpr (requires { into.check(place); }) into.check(place);
}

template <Described T>
T read_as(const Json& json, const JsonPlace& place) {
  T value{};
  read_document(json, place, value);
  return value;
}

template <Described T>
Json json_of(const T& value) {
  Fields f = Fields::writer(json_value::is_list<T>());
  T::fields(const_cast<T&>(value), f);  // changed when it is read, not here
  return f.take();
}

template <Described T>
Json json_of(const std::vector<T>& values) {
  return json_value::written(values, {});
}

template <Described T>
Json schema_of() {
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}};
  schema.update(json_value::schema(T{}, {}));
  schema["properties"]["$schema"] = {{"type", "string"}, {"description", "for editors; not read"}};
  return schema;
}

// Visits each field of a struct whose fields have no meaning, by its key.
template <class Visit>
struct EachField {
  Visit visit;
  template <class T, class... More>
  void operator()(const char* key, T& member, More&&... more) {
    visit(key, member);
    if constexpr (sizeof...(more) > 0) (*this)(more...);
  }
};
template <class Visit>
EachField(Visit) -> EachField<Visit>;

}  // namespace trilat
