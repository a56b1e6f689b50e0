// SPDX-License-Identifier: MIT
// Keys of documents as tables of Markdown, from their schemas.
#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/document.h"

namespace trilat {
namespace {

std::string dumped(const Json& value) { return json_text(value, -1); }

// Whether an object's members are alike in everything, as those by joint are: a row each would say nothing.
bool has_equal_members(const Json& schema) {
  if (!schema.contains("properties") || schema["properties"].size() < 2) return false;
  const Json& first = schema["properties"].front();
  return !first.contains("description") &&
         std::ranges::all_of(schema["properties"], [&](const Json& member) { return member == first; });
}

// "how many of them" of a list.
std::string count_text(const Json& schema) {
  const Json least = schema.value("minItems", Json()), most = schema.value("maxItems", Json());
  if (!most.is_null() && least == most) return fmt::format("; {} of them", most.dump());
  if (!most.is_null())
    return fmt::format("; {} to {} of them", least.is_null() ? "0" : least.dump(), most.dump());
  return least.is_null() ? "" : fmt::format("; at least {}", least.dump());
}

std::string type_text(const Json& type) {
  if (type.is_array()) {
    std::vector<std::string> types;
    for (const Json& one : type) types.push_back(type_text(one));
    return fmt::format("{}", fmt::join(types, " or "));
  }
  return type == "boolean"  ? "true or false"
         : type == "string" ? "text"
         : type == "array"  ? "list"
                            : type.get<std::string>();
}

std::string values_of(const Json& schema) {
  if (schema.contains("const")) return fmt::format("`{}`", dumped(schema["const"]));
  if (schema.contains("enum")) {
    std::vector<std::string> words;
    for (const Json& word : schema["enum"]) words.push_back(fmt::format("`{}`", dumped(word)));
    return fmt::format("{}", fmt::join(words, ", "));
  }
  if (!schema.contains("type")) return "any";
  std::string text = type_text(schema["type"]);
  if (text == "list" && schema.contains("items")) text = "list of: " + values_of(schema["items"]);
  if (text.starts_with("list")) text += count_text(schema);
  if (has_equal_members(schema)) {
    std::vector<std::string> keys;
    for (const auto& [key, member] : schema["properties"].items()) keys.push_back('`' + key + '`');
    text += fmt::format(" of {}", fmt::join(keys, ", "));
    if (!schema.contains("minimum")) text += ", each " + values_of(schema["properties"].front());
  }
  if (schema.contains("exclusiveMinimum")) {
    text += " above " + dumped(schema["exclusiveMinimum"]);
    if (schema.contains("maximum")) text += ", at most " + dumped(schema["maximum"]);
  }
  if (schema.contains("minimum") && schema.contains("maximum"))
    text += fmt::format(", {} to {}", dumped(schema["minimum"]), dumped(schema["maximum"]));
  else if (schema.contains("minimum"))
    text += fmt::format(", at least {}", dumped(schema["minimum"]));
  return text;
}

// Rows of an object and of the objects in it, in the order of their keys; what has branches waits in `later`.
void add_rows(const Json& schema, const std::string& prefix, std::string& rows,
              std::vector<std::pair<std::string, Json>>& later) {
  const Json& required = schema["required"];
  for (const auto& [key, value] : schema["properties"].items()) {
    if (key == "$schema") continue;
    const bool is_list = value.contains("items") && !value.contains("properties");
    const std::string name = prefix + key + (is_list && value["items"].contains("properties") ? "[]" : "");
    const bool needed = std::ranges::find(required, Json(key)) != required.end();
    const Json& members = is_list ? value["items"] : value;
    const bool has_branches = members.contains("oneOf");
    rows +=
        fmt::format("| `{}` | {} | {} | {} |\n", name, has_branches ? "list, see below" : values_of(value),
                    needed                      ? "required"
                    : value.contains("default") ? fmt::format("`{}`", dumped(value["default"]))
                                                : "",
                    value.value("description", ""));
    if (has_branches)
      later.emplace_back(name, members);
    else if (members.contains("properties") && !has_equal_members(members))
      add_rows(members, name + ".", rows, later);
  }
}

constexpr const char* kHead = "| key | value | default | meaning |\n|---|---|---|---|\n";

// The keys of an object for which `is_told` holds, by key and schema.
std::string table_of(const Json& object,
                     const std::function<bool(const std::string&, const Json&)>& is_told) {
  Json some{{"properties", Json::object()}, {"required", object["required"]}};
  for (const auto& [key, value] : object["properties"].items())
    if (is_told(key, value)) some["properties"][key] = value;
  std::string rows;
  std::vector<std::pair<std::string, Json>> deeper;
  add_rows(some, "", rows, deeper);
  return rows.empty() ? "" : kHead + rows;
}

// First the keys that all branches have alike, then those of each.
std::string markdown_of_branches(const Json& branches, const std::string& name) {
  const auto is_in_all = [&](const std::string& key, const Json& value) {
    return std::ranges::all_of(branches, [&](const Json& branch) {
      const auto found = branch["properties"].find(key);
      return found != branch["properties"].end() && *found == value;
    });
  };
  std::string text = fmt::format("\n### {}: keys of all\n\n{}", name, table_of(branches.back(), is_in_all));
  for (const Json& branch : branches) {
    const Json& deciding = branch["properties"].front();
    text += fmt::format("\n### {}: `{}`\n\n{}\n", name, deciding["const"].get<std::string>(),
                        deciding.value("description", ""));
    const std::string own = table_of(branch, [&](const std::string& key, const Json& value) {
      return !value.contains("const") && !is_in_all(key, value);
    });
    if (!own.empty()) text += '\n' + own;
  }
  return text;
}

}  // namespace

std::string markdown_of_schema(const Json& schema, const std::string& title,
                               std::set<std::string>& described) {
  std::string rows;
  std::vector<std::pair<std::string, Json>> later;
  add_rows(schema, "", rows, later);
  std::string text = fmt::format("\n## {}\n\n{}{}", title, kHead, rows);
  for (const auto& [name, members] : later)
    if (described.insert(json_text(members, -1)).second)
      text += markdown_of_branches(members["oneOf"], name);
    else
      text += fmt::format("\n`{}` are as above.\n", name);
  return text;
}

}  // namespace trilat
