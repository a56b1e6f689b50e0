// SPDX-License-Identifier: MIT
#include "datasets/base/json_schema.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "datasets/base/error.h"

namespace trilat {
namespace {

Json schema_of(const JsonFields& fields);

Json schema_of(const JsonField& field) {
  Json schema = field.schema;
  if (field.members) {
    const Json members = schema_of(*field.members);
    if (schema.contains("items"))
      schema["items"] = members;
    else
      schema.update(members);
    if (field.schema.contains("type")) schema["type"] = field.schema["type"];
  }
  if (!field.about.empty()) schema["description"] = field.about;
  return schema;
}

Json schema_of(const JsonFields& fields) {
  if (!fields.branches.empty()) {
    Json branches = Json::array();
    for (const auto& [value, branch] : fields.branches) branches.push_back(schema_of(*branch));
    return {{"oneOf", branches}};
  }
  Json properties = Json::object(), required = Json::array();
  for (const JsonField& field : fields.fields) {
    properties[field.key] = schema_of(field);
    if (field.required && !fields.are_data) required.push_back(field.key);
  }
  return {{"type", "object"},
          {"properties", properties},
          {"required", required},
          {"additionalProperties", false}};
}

std::string dumped(const Json& value) { return json_text(value, -1); }

std::string values_of(const Json& schema) {
  if (schema.contains("const")) return fmt::format("`{}`", dumped(schema["const"]));
  if (schema.contains("enum")) {
    std::vector<std::string> words;
    for (const Json& word : schema["enum"]) words.push_back(fmt::format("`{}`", dumped(word)));
    return fmt::format("{}", fmt::join(words, ", "));
  }
  if (!schema.contains("type")) return "any";
  const auto is_one = [&](const char* type) {
    return std::ranges::find(schema["type"], type) != schema["type"].end();
  };
  std::string text = !schema["type"].is_array() ? schema["type"].get<std::string>()
                     : is_one("string")         ? "object or text"
                                                : "number or object";
  if (text == "boolean") text = "true or false";
  if (text == "string") text = "text";
  if (text == "array") {
    text = schema.contains("items") ? "list of: " + values_of(schema["items"]) : "list";
    if (schema.contains("minItems") && schema.contains("maxItems"))
      text += fmt::format("; {} of them", dumped(schema["minItems"]));
  }
  if (schema.contains("exclusiveMinimum")) text += " above " + dumped(schema["exclusiveMinimum"]);
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
    const bool is_list = value.contains("items");
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
    else if (members.contains("properties"))
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

JsonField& JsonFields::of(const std::string& key) {
  const auto found = std::ranges::find(fields, key, &JsonField::key);
  return found != fields.end() ? *found : fields.emplace_back(JsonField{.key = key});
}

Json schema_of(const std::vector<Json>& examples, const std::function<void(const Json&)>& read) {
  const auto fields = std::make_shared<JsonFields>();
  for (const Json& example : examples) {
    const JsonNotes notes(example, fields);
    read(example);
  }
  Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}};
  schema.update(schema_of(*fields));
  schema["properties"]["$schema"] = {{"type", "string"}, {"description", "for editors; not read"}};
  return schema;
}

std::string markdown_of_schema(const Json& schema, const std::string& title, std::set<std::string>& told) {
  std::string rows;
  std::vector<std::pair<std::string, Json>> later;
  add_rows(schema, "", rows, later);
  std::string text = fmt::format("\n## {}\n\n{}{}", title, kHead, rows);
  for (const auto& [name, members] : later)
    if (told.insert(json_text(members, -1)).second)
      text += markdown_of_branches(members["oneOf"], name);
    else
      text += fmt::format("\n`{}` are as above.\n", name);
  return text;
}

}  // namespace trilat
