// SPDX-License-Identifier: MIT
#include "datasets/base/json.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <vector>

#include <fmt/format.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"

namespace trilat {
namespace {

constexpr int kMaxDepth = 64;

// "LINE:COLUMN", both from 1.
std::string line_and_column(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  return fmt::format("{}:{}", 1 + std::ranges::count(before, '\n'),
                     before.size() - (before.rfind('\n') + 1) + 1);
}

bool parses_without_comments(std::string_view text) {
  return !Json::parse(text, nullptr, false, true).is_discarded();
}

// What people write that JSON does not have, at the place where it cannot be read; else the parser's own
// words.
std::string syntax_problem(std::string_view text, std::size_t at, const std::string& parser_says) {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto expects = [&](const char* what) { return parser_says.find(what) != std::string::npos; };
  const std::string_view rest = text.substr(std::min(at, text.size()));
  const std::size_t last = text.substr(0, at).find_last_not_of(kBlank);
  const char before = last == std::string_view::npos ? '\0' : text[last];
  const auto begins = [&](auto... words) { return (rest.starts_with(words) || ...); };
  if (text.find_first_not_of(kBlank) == std::string_view::npos) return "is empty";
  if (const std::string_view kind = foreign_kind(text); !kind.empty())
    return std::string(kind) + "; a JSON document is wanted";
  if (begins("/") && parses_without_comments(text))
    return "has a comment, which JSON does not have; delete it";
  if (before == ',' && begins("}", "]")) return "has a comma before a closing bracket; delete the comma";
  if (begins("'", "\xe2\x80\x9c", "\xe2\x80\x9d", "\xe2\x80\x98", "\xe2\x80\x99"))
    return "has another quotation mark than \", in which keys and texts stand";
  if (begins("T", "F", "N", "I") && !expects("expected string literal"))
    return "has a word that JSON does not have; it writes true, false and null";
  if (expects("unexpected end of input")) return "ends before its last bracket is closed; is it whole?";
  if (expects("unexpected number literal; expected string literal"))
    return "has a number where a key stands; is it a decimal comma? JSON writes 1.5";
  if (const std::string_view digits = text.substr(text.substr(0, at).find_last_not_of("0123456789") + 1);
      digits.size() > 1 && digits[0] == '0' && std::isdigit(static_cast<unsigned char>(digits[1])) != 0)
    return "has a number that begins with 0";
  if (expects("; expected '}'") || expects("; expected ']'")) return "has no comma between two values";
  if (expects("expected string literal")) return "has a key without quotation marks; write \"key\"";
  return "is not valid JSON: " + parser_says;
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
    const std::size_t at = error.byte == 0 ? 0 : error.byte - 1;
    throw InputError(place + ":" + line_and_column(text, at), syntax_problem(text, at, what));
  } catch (const nlohmann::json::exception& error) {
    throw InputError(place, std::string("is not valid JSON: ") + error.what());
  }
  if (too_deep) throw InputError(place, "nests deeper than " + std::to_string(kMaxDepth) + " levels");
  if (!duplicate.empty()) throw InputError(place, "has the key \"" + duplicate + "\" twice in one object");
  return result;
}

Json read_json(const std::filesystem::path& path) { return parse_json(read_file(path), path.string()); }

std::string utf8_json_text(const Json& json, int indent) {
  try {
    return json.dump(indent);
  } catch (const Json::type_error&) {
    if (json.is_string())
      throw InputError(
          json.dump(-1, ' ', false, Json::error_handler_t::replace),
          "is not UTF-8 text; rename the file or folder, or save the file that holds the name as UTF-8");
    for (const Json& inside : json) utf8_json_text(inside, indent);  // names the text
    throw;
  }
}

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string type_of(const Json& value) {
  if (value.is_number_float()) return "the number " + value.dump();
  if (value.is_number()) return "the integer " + value.dump();
  if (value.is_string()) return "the text " + json_text(value, -1);
  return value.is_null()     ? "null"
         : value.is_object() ? "an object"
         : value.is_array()  ? "a list"
                             : value.dump();
}

JsonPlace JsonPlace::at(std::string_view key) const {
  JsonPlace place = *this;
  place.pointer += '/';
  for (const char c : key) place.pointer += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return place;
}

void JsonPlace::refuse(const std::string& problem) const { throw InputError(text(), problem); }

}  // namespace trilat
