// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>

namespace trilat {

// Keys keep the order in which they were written.
using Json = nlohmann::ordered_json;

// Parses text and refuses what plain JSON parsers let pass: duplicate keys, NaN, trailing text, nesting
// beyond 64. `place` is the file name; errors read `place:line:column: …`.
Json parse_json(std::string_view text, const std::string& place);
Json read_json(const std::filesystem::path& path);

// The document as text. Names from outside need not be UTF-8: bytes that are not become U+FFFD.
std::string json_text(const Json& json, int indent);
// Text of JSON that has to name files and assets exactly: InputError with the text in it that is not UTF-8.
std::string utf8_json_text(const Json& json, int indent);

// "the number 1.5", "an object": a value as a refusal names it.
std::string type_of(const Json& value);

// Place of a value in a document, as errors name it: the file and the JSON pointer (RFC 6901).
struct JsonPlace {
  JsonPlace(std::filesystem::path document) : file(document.string()), folder(document.parent_path()) {}
  // `beside`: where relative paths of the document begin.
  JsonPlace(std::string document, std::filesystem::path beside)
      : file(std::move(document)), folder(std::move(beside)) {}

  JsonPlace at(std::string_view key) const;
  JsonPlace at(std::size_t index) const { return at(std::to_string(index)); }
  std::string text() const { return file + " " + (pointer.empty() ? "/" : pointer); }
  [[noreturn]] void refuse(const std::string& problem) const;

  std::string file;
  std::filesystem::path folder;
  std::string pointer = {};
};

}  // namespace trilat
