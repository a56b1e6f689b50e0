// SPDX-License-Identifier: MIT
#include "datasets/base/strict_json.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/json_schema.h"
#include "datasets/base/known_names.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

JsonObject reader_of(const Json& json) { return {json, "a.json", "/methods/0"}; }

TEST(StrictJson, RefusesDuplicateKeys) {
  EXPECT_THAT(message_of([] { parse_json(R"({"a": {"b": 1, "b": 2}})", "a.json"); }),
              AllOf(HasSubstr("a.json"), HasSubstr("\"b\" twice")));
  EXPECT_EQ(message_of([] { parse_json(R"([{"b": 1}, {"b": 2}])", "a.json"); }), "no error");
}

TEST(StrictJson, NamesTheLineOfASyntaxError) {
  EXPECT_THAT(message_of([] { parse_json("{\n\"a\": 1,\n]", "a.json"); }), HasSubstr("a.json:3"));
  EXPECT_THAT(message_of([] { parse_json("", "a.json"); }), HasSubstr("a.json:1"));
  EXPECT_THAT(message_of([] { parse_json(R"({"a": NaN})", "a.json"); }), HasSubstr("a.json:1"));
  EXPECT_THAT(message_of([] { parse_json(R"({"a": 1e999})", "a.json"); }), HasSubstr("overflow"));
  EXPECT_THAT(message_of([] { parse_json("{} x", "a.json"); }), HasSubstr("a.json:1"));
}

TEST(StrictJson, RefusesEndlessNesting) {
  EXPECT_THAT(message_of([] { parse_json(std::string(5000, '['), "a.json"); }), HasSubstr("a.json"));
  EXPECT_THAT(message_of([] { parse_json(std::string(5000, '[') + std::string(5000, ']'), "a.json"); }),
              HasSubstr("nests deeper"));
}

TEST(StrictJson, ASyntaxErrorNamesLineAndColumn) {
  EXPECT_THAT(message_of([] { parse_json("{\"a\": 1,\n \"b\": 2 \"c\": 3}", "a.json"); }),
              HasSubstr("a.json:2:11: is not valid JSON"));
  EXPECT_THAT(message_of([] { parse_json("", "a.json"); }), HasSubstr("a.json:1:1: "));
}

TEST(StrictJson, TheNearestNameIsSuggestedAndAFarOneIsNot) {
  const std::vector<std::string> verbs{"run", "merge", "report", "record"};
  EXPECT_EQ(nearest_name("rn", verbs), "run");
  EXPECT_EQ(nearest_name("rnu", verbs), "run");  // exchanged letters count once
  EXPECT_EQ(nearest_name("Merge", verbs), "merge");
  EXPECT_EQ(nearest_name("reocrd", verbs), "record");
  EXPECT_EQ(nearest_name("levitate", verbs), "");
  EXPECT_EQ(nearest_name("", verbs), "");
  EXPECT_EQ(nearest_name(std::string(100'000, 'r'), verbs), "");
  EXPECT_EQ(known_names("x", verbs), "known are: run, merge, report, record");
}

TEST(StrictJson, ChoicesListWhatIsKnown) {
  const Json json = parse_json(R"({"damping": "lw"})", "a.json");
  JsonObject object = reader_of(json);
  EXPECT_THAT(message_of([&] {
                object.choice("damping", {"none", "lm"});
              }),
              HasSubstr("is \"lw\", which is unknown; known are: none, lm"));
}

TEST(StrictJson, OnlyADocumentMayNameItsSchema) {
  const Json json = parse_json(R"({"$schema": "study.schema.json", "rig": {"$schema": "x"}})", "a.json");
  EXPECT_THAT(message_of([&] {
                JsonObject document(json, "a.json", "");
                JsonObject rig = document.object("rig");
                document.finish();
                rig.finish();
              }),
              HasSubstr("/rig/$schema: is an unknown key"));
}

// Reads what each of the two shapes has, and more when there is more.
void read_shape(const Json& json) {
  JsonObject object(json, "a.json", "");
  object.format("shapes");
  for (JsonObject& shape : object.objects("shapes")) {
    if (shape.branch("kind", {"circle", "box"}) == 0)
      number_within(shape, "radius_m", 1.0, 0.5, 2.0);
    else
      shape.numbers("corner_m", 3);
    shape.about({{"radius_m", "of the circle"}, {"corner_m", "of the box"}});
    shape.finish();
  }
  if (object.has("more")) object.object("more").count("seed", 7);
  object.finish();
}

TEST(JsonSchema, SaysWhatAReaderAsksFor) {
  const Json first = parse_json(R"({"format": "shapes", "version": 1, "shapes": [{"kind": "circle"}]})", "");
  const Json second = parse_json(R"({"format": "shapes", "version": 1, "more": {},
      "shapes": [{"kind": "box", "corner_m": [1, 2, 3]}]})",
                                 "");
  const Json expected = parse_json(R"({
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "properties": {
      "format": {"const": "shapes"},
      "version": {"const": 1},
      "shapes": {"type": "array", "items": {"oneOf": [
        {"type": "object", "properties": {
           "kind": {"const": "circle"},
           "radius_m": {"type": "number", "default": 1.0, "minimum": 0.5, "maximum": 2.0,
                        "description": "of the circle"}},
         "required": ["kind"], "additionalProperties": false},
        {"type": "object", "properties": {
           "kind": {"const": "box"},
           "corner_m": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3,
                        "description": "of the box"}},
         "required": ["kind", "corner_m"], "additionalProperties": false}]}},
      "more": {"type": "object", "properties": {"seed": {"type": "integer", "default": 7, "minimum": 0}},
               "required": [], "additionalProperties": false},
      "$schema": {"type": "string", "description": "for editors; not read"}},
    "required": ["format", "version", "shapes"], "additionalProperties": false})",
                                   "");
  EXPECT_EQ(json_text(schema_of({first, second}, read_shape), 1), json_text(expected, 1));
}

}  // namespace
}  // namespace trilat
