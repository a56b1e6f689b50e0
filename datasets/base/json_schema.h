// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "datasets/base/strict_json.h"

namespace trilat {

struct JsonFields;

// A key that a reader asked for.
struct JsonField {
  std::string key;
  bool was_asked = false;
  bool required = false;  // by all readers that asked
  bool has_any_size = false;
  Json schema = Json::object();  // of the value, but for the keys of objects
  std::string about = {};
  std::shared_ptr<JsonFields> members = {};  // of an object, or of the objects of a list
};

// All keys that readers asked an object for, in their order; JsonObject notes them.
struct JsonFields {
  std::vector<JsonField> fields;
  bool are_data = false;  // the reader asked which keys there are
  // Where a key decides which others there are: its values, each with the keys that go with it.
  std::vector<std::pair<std::string, std::shared_ptr<JsonFields>>> branches;

  JsonField& of(const std::string& key);
};

// JSON Schema (draft 2020-12) of the documents that `read` reads, from all that it asks of the examples: they
// have to lead it to every key.
Json schema_of(const std::vector<Json>& examples, const std::function<void(const Json& example)>& read);

// The same as Markdown: a table of keys with values, defaults and meanings; more for a list whose entries
// have a key that decides which others there are. What is `told` is not told again.
std::string markdown_of_schema(const Json& schema, const std::string& title, std::set<std::string>& told);

}  // namespace trilat
