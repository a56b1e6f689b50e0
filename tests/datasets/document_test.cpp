// SPDX-License-Identifier: MIT
#include "datasets/base/document.h"

#include <cmath>
#include <tuple>

#include <Eigen/Core>
#include <gmock/gmock.h>

#include "datasets/base/words.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

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

TEST(StrictJson, ASyntaxErrorNamesLineColumnAndWhatAPersonMeant) {
  const std::pair<std::string, const char*> texts[] = {
      {"{\"a\": 1,\n \"b\": 2 \"c\": 3}", "a.json:2:11: has no comma between two values"},
      {"{\"a\": [1 2]}", "a.json:1:10: has no comma"},
      {"", "a.json:1:1: is empty"},
      {" \r\n", "is empty"},
      {"{\"a\": 1} // why", "a.json:1:10: has a comment, which JSON does not have; delete it"},
      {"{/* why */ \"a\": 1}", "a.json:1:2: has a comment"},
      {"{\"a\": 1,\n}", "a.json:2:1: has a comma before a closing bracket"},
      {"[1, 2, ]", "has a comma before a closing bracket"},
      {"{'a': 1}", "a.json:1:2: has another quotation mark"},
      {"{\u201ca\u201d: 1}", "has another quotation mark"},
      {"{\"a\": True}", "a.json:1:7: has a word that JSON does not have; it writes true"},
      {"{\"a\": None}", "has a word that JSON does not have"},
      {"{\"a\": NaN}", "has a word that JSON does not have"},
      {"{Name: 1}", "a.json:1:2: has a key without quotation marks"},
      {"{name: 1}", "has a key without quotation marks"},
      {"{\"a\": 1,5}", "a.json:1:9: has a number where a key stands; is it a decimal comma?"},
      {"{\"a\": {\"b\": 1}", "ends before its last bracket is closed"},
      {std::string("\xff\xfe{\0", 4), "is text in UTF-16"},
      {"\x89HDF\r\n", "is HDF5, as sessions"},
      {"version https://git-lfs.github.com/spec/v1\n", "a.json:1:1: is a pointer of Git LFS; `git lfs pull`"},
      {"<!DOCTYPE html><html>", "is a web page"},
      {"PK\x03\x04", "is a spreadsheet or an archive"},
      {"{\"a\": 01}", "has a number that begins with 0"},
      {"{\"a\": 0012}", "has a number that begins with 0"},
      {"{\"a\": /}", "is not valid JSON"}};
  for (const auto& [text, problem] : texts)
    EXPECT_THAT(message_of([&] { parse_json(text, "a.json"); }), HasSubstr(problem)) << text;
}

TEST(StrictJson, TheNearestNameIsSuggestedAndAFarOneIsNot) {
  const std::vector<std::string> verbs{"run", "merge", "report", "record"};
  EXPECT_EQ(nearest_name("rn", verbs), "run");
  EXPECT_EQ(nearest_name("rnu", verbs), "run");  // exchanged letters count once
  EXPECT_EQ(nearest_name("Merge", verbs), "merge");
  EXPECT_EQ(nearest_name(std::string(100, 'a'), {std::string(99, 'a')}), std::string(99, 'a'));
  EXPECT_EQ(nearest_name(std::string(101, 'a'), {std::string(100, 'a')}), "");  // no word
  EXPECT_EQ(nearest_name("reocrd", verbs), "record");
  EXPECT_EQ(nearest_name("levitate", verbs), "");
  EXPECT_EQ(nearest_name("", verbs), "");
  EXPECT_EQ(nearest_name(std::string(100'000, 'r'), verbs), "");
  EXPECT_EQ(known_names("x", verbs), "allowed: run, merge, report, record");
}

struct Small {
  std::int64_t number = 0;
  std::uint64_t count = 0;
  static void fields(auto& self, auto&& f) { f("number", self.number, "count", self.count); }
};

TEST(StrictJson, IntegersBeyondWhatIsHeldNameTheLimits) {
  const auto refused = [](const char* text) {
    return message_of([&] { read_as<Small>(parse_json(text, "a.json"), {"a.json", {}}); });
  };
  EXPECT_EQ(refused(R"({"number": 9223372036854775808, "count": 0})"),
            "a.json /number: must lie between -9223372036854775808 and 9223372036854775807, is "
            "9223372036854775808");
  EXPECT_EQ(refused(R"({"number": 0, "count": -1})"),
            "a.json /count: must be an integer of 0 or more, is the integer -1");
  EXPECT_EQ(refused(R"({"number": 1.5, "count": 0})"),
            "a.json /number: must be an integer, is the number 1.5");
}

enum class Shade : std::uint8_t { light, dark };

// A struct for what is not said with one number alone.
struct Disc {
  double radius_m = 1.0, turn_rad = 0.0;
  std::uint64_t holes = 0;

  static void fields(auto& self, auto&& f) {
    f("radius_m", self.radius_m, need("of the disc", {0.5, 2.0}));
    f("turn_deg", self.turn_rad, opt("about its axis", {-180.0, 180.0}, 0.017453292519943295));
    f("holes", self.holes, opt("in it", {0.0, 8.0}));
  }
  void check(const JsonPlace& place) const {
    if (holes > 4 && radius_m < 1.0) place.at("holes").refuse("are too many for so small a disc");
  }
};

// One of two kinds, each with keys of its own.
struct Shape {
  std::size_t kind = 0;
  double side_m = 1.0;
  std::vector<double> corner_m{};

  static void fields(auto& self, auto&& f) {
    f.tag("kind", self.kind, {"square", "polygon"}, "what it is");
    if (self.kind == 0) f("side_m", self.side_m, opt("of the square", kPositive));
    if (self.kind == 1) f("corner_m", self.corner_m, need("of the polygon").items(3, 5));
  }
  static std::vector<Shape> alternatives() { return {{.kind = 0}, {.kind = 1}}; }
};

struct Drawing {
  std::string name = "drawing";
  Shade shade = Shade::light;
  bool is_hidden = false;
  std::vector<std::string> layers;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  std::optional<Disc> disc;
  std::vector<Shape> shapes;
  std::map<std::string, double> weights;

  static void fields(auto& self, auto&& f) {
    f.format("trilat.drawing");
    f("name", self.name, need("of the drawing"));
    f("shade", self.shade, opt("of the paper"));
    f.named("is_hidden", self.is_hidden, {"shown", "hidden"}, opt("whether it is seen"));
    f("layers", self.layers, opt("from below").one_of({"ground", "walls", "roof"}));
    f("centre_m", self.centre_m, opt("in the world"));
    f("disc", self.disc, opt("in the middle"));
    f("shapes", self.shapes, opt("about it").items(1));
    f("weights", self.weights, opt("by name", kNotNegative));
    f.removed("colour", "state \"shade\"");
  }
};

}  // namespace
template <>
inline constexpr std::array words<Shade>{"light", "dark"};
namespace {

constexpr const char* kDrawing = R"({"format": "trilat.drawing", "version": 1, "name": "a", "shade": "dark",
    "is_hidden": "hidden", "layers": ["walls", "ground"], "centre_m": [1.0, 2.0, 3.5],
    "disc": {"radius_m": 1.5, "turn_deg": 90.0, "holes": 3},
    "shapes": [{"kind": "polygon", "corner_m": [1.0, 2.0, 3.0]}, {"kind": "square", "side_m": 2.0}],
    "weights": {"b": 1.0, "a": 0.5}})";

// What is refused of the drawing with another value at a pointer; null takes the key out.
std::string refusal(const char* pointer, const Json& value) {
  Json json = Json::parse(kDrawing);
  const Json::json_pointer place(pointer);
  if (value.is_null())
    json.at(place.parent_pointer()).erase(place.back());
  else
    json[place] = value;
  return message_of([&] { read_as<Drawing>(json, {"a.json"}); });
}

TEST(Document, IsReadAndWrittenByItsFields) {
  const Json json = Json::parse(kDrawing);
  const auto drawing = read_as<Drawing>(json, {"a.json"});
  EXPECT_EQ(drawing.shade, Shade::dark);
  EXPECT_TRUE(drawing.is_hidden);
  EXPECT_EQ(drawing.centre_m.z(), 3.5);
  EXPECT_NEAR(drawing.disc->turn_rad, 1.5707963267948966, 1e-15);
  EXPECT_EQ(drawing.shapes[0].corner_m.size(), 3u);
  EXPECT_EQ(drawing.weights.at("a"), 0.5);
  Json sorted = json;  // a map is written in the order of its keys
  sorted["weights"] = {{"a", 0.5}, {"b", 1.0}};
  EXPECT_EQ(json_text(json_of(drawing), 1), json_text(sorted, 1));
  EXPECT_EQ(json_of(read_as<Drawing>(Json{{"format", "trilat.drawing"}, {"version", 1}, {"name", "a"}}, {""}))
                .contains("disc"),
            false);
}

TEST(Document, RefusesWithThePlaceAndWhatWouldBeRight) {
  const std::vector<std::tuple<const char*, Json, const char*>> cases{
      {"/name", nullptr, "a.json /name: is missing"},
      {"/name", 7, "a.json /name: must be a text, is the integer 7"},
      {"/shade", "drak",
       "a.json /shade: unknown value \"drak\"; allowed: light, dark; did you mean "
       "\"dark\"?"},
      {"/is_hidden", true, "a.json /is_hidden: must be a text, is true"},
      {"/layers/1", "celar", "a.json /layers/1: unknown value \"celar\"; allowed: ground"},
      {"/layers/1", "walls", "a.json /layers: has \"walls\" twice"},
      {"/layers", "walls", "a.json /layers: must be a list, is the text \"walls\""},
      {"/centre_m", {1, 2}, "a.json /centre_m: must be a list of 3 numbers"},
      {"/centre_m/1", "x", "a.json /centre_m/1: must be a number, is the text \"x\""},
      {"/disc/radius_m", 2.5, "a.json /disc/radius_m: must lie between 0.5 and 2, is 2.5"},
      {"/disc/radius_m", 1500, "must lie between 0.5 and 2, is 1500; as millimetres it would be 1.5"},
      {"/disc/radius_m", 150, "must lie between 0.5 and 2, is 150; as centimetres it would be 1.5"},
      {"/disc/radius_m", nullptr, "a.json /disc/radius_m: is missing"},
      {"/disc/turn_deg", 270, "must lie between -180 and 180, is 270"},
      {"/disc/holes", -1, "a.json /disc/holes: must be an integer of 0 or more, is the integer -1"},
      {"/disc/holes", 1.5, "must be an integer of 0 or more, is the number 1.5"},
      {"/disc/holes", 9, "a.json /disc/holes: must be 0 to 8, is 9"},
      {"/disc/hole", 1,
       "a.json /disc/hole: is an unknown key; allowed: radius_m, turn_deg, holes; did you "
       "mean \"holes\"?"},
      {"/disc/$schema", "x", "a.json /disc/$schema: is an unknown key"},
      {"/disc", 3, "a.json /disc: must be an object, is the integer 3"},
      {"/shapes", Json::array(), "a.json /shapes: must hold at least one entry"},
      {"/shapes/0/kind", "circle", "a.json /shapes/0/kind: unknown value \"circle\""},
      {"/shapes/0/kind", nullptr, "a.json /shapes/0/kind: is missing; allowed: "},
      {"/shapes/0/side_m", 1, "a.json /shapes/0/side_m: is an unknown key; allowed: kind, corner_m"},
      {"/shapes/0/corner_m", {1, 2}, "must hold 3 to 5 entries, holds 2"},
      {"/shapes/1/side_m", 0, "a.json /shapes/1/side_m: must be greater than 0, is 0"},
      {"/weights/b", -2, "a.json /weights/b: must not be less than 0, is -2"},
      {"/colour", "red", "a.json /colour: was removed; state \"shade\""},
      {"/format", "trilat.study",
       "a.json /format: is \"trilat.study\", which `trilat run` takes; here it must be \"trilat.drawing\""},
      {"/format", nullptr, "a.json /format: is missing; here it must be \"trilat.drawing\""},
      {"/version", 2, "a.json /version: must be 1, the version that this program reads, is 2"}};
  for (const auto& [pointer, value, message] : cases)
    EXPECT_THAT(refusal(pointer, value), HasSubstr(message)) << pointer;
  EXPECT_EQ(refusal("/$schema", "drawing.schema.json"), "no error");
  Json many = Json::parse(kDrawing);
  many["disc"] = {{"radius_m", 0.5}, {"holes", 5}};
  EXPECT_EQ(message_of([&] { read_as<Drawing>(many, {"a.json"}); }),
            "a.json /disc/holes: are too many for so small a disc");
}

// In files that only the program writes.
struct Row {
  double value = 0.0;
  std::optional<double> limit;
  std::int32_t step = 0;
  std::vector<std::string> words;

  static constexpr bool kIsList = true;
  static void fields(auto& self, auto&& f) {
    f("value", self.value, "limit", self.limit, "step", self.step, "words", self.words);
  }
};

TEST(Document, OfTheProgramMayHoldNullsAndIsAListWhereItSaysSo) {
  const auto row = read_as<Row>(Json::parse(R"([null, null, -3, ["a", "a"]])"), {"r.json"});
  EXPECT_TRUE(std::isnan(row.value));
  EXPECT_TRUE(std::isnan(row.limit.value()));  // as a number in a table: it is there, and none
  EXPECT_EQ(row.step, -3);
  EXPECT_EQ(row.words.size(), 2u);
  const auto refused = [](const char* text) {
    return message_of([&] { read_as<Row>(Json::parse(text), {"r.json"}); });
  };
  EXPECT_EQ(refused("[1, 2, 3]"), "r.json /: has no words");
  EXPECT_EQ(refused("[1, 2, 3, [], 5]"), "r.json /: must be a list of 4");
  EXPECT_THAT(refused("[1, 2, 3000000000, []]"), HasSubstr("r.json /2: must lie between"));
  EXPECT_THAT(refused("[1, 2, -3000000000, []]"), HasSubstr("r.json /2: must lie between"));
  EXPECT_EQ(refused("{}"), "r.json /: must be a list, is an object");
}

TEST(Document, IsDescribedByItsFields) {
  const Json expected = parse_json(R"({
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "properties": {
      "format": {"const": "trilat.drawing"},
      "version": {"const": 1},
      "name": {"type": "string", "description": "of the drawing"},
      "shade": {"type": "string", "enum": ["light", "dark"], "default": "light", "description": "of the paper"},
      "is_hidden": {"type": "string", "enum": ["shown", "hidden"], "default": "shown",
                    "description": "whether it is seen"},
      "layers": {"type": "array", "items": {"type": "string", "enum": ["ground", "walls", "roof"]},
                 "default": [], "description": "from below"},
      "centre_m": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3,
                   "description": "in the world"},
      "disc": {"type": "object", "properties": {
          "radius_m": {"type": "number", "minimum": 0.5, "maximum": 2, "description": "of the disc"},
          "turn_deg": {"type": "number", "minimum": -180, "maximum": 180, "default": 0.0,
                       "description": "about its axis"},
          "holes": {"type": "integer", "minimum": 0, "maximum": 8, "default": 0, "description": "in it"}},
        "required": ["radius_m"], "additionalProperties": false, "description": "in the middle"},
      "shapes": {"type": "array", "items": {"oneOf": [
          {"type": "object", "properties": {
             "kind": {"const": "square", "description": "what it is"},
             "side_m": {"type": "number", "exclusiveMinimum": 0, "default": 1.0,
                        "description": "of the square"}},
           "required": ["kind"], "additionalProperties": false},
          {"type": "object", "properties": {
             "kind": {"const": "polygon", "description": "what it is"},
             "corner_m": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 5,
                          "description": "of the polygon"}},
           "required": ["kind", "corner_m"], "additionalProperties": false}]},
        "minItems": 1, "description": "about it"},
      "weights": {"type": "object", "additionalProperties": {"type": "number", "minimum": 0},
                  "description": "by name"},
      "$schema": {"type": "string", "description": "for editors; not read"}},
    "required": ["format", "version", "name"], "additionalProperties": false})",
                                   "");
  EXPECT_EQ(json_text(schema_of<Drawing>(), 1), json_text(expected, 1));
  std::set<std::string> described;
  const std::string text = markdown_of_schema(schema_of<Drawing>(), "drawing.json", described);
  for (const char* line :
       {"| `name` | text | required | of the drawing |", "| `disc.holes` | integer, 0 to 8 | `0` | in it |",
        "| `shapes` | list, see below |  | about it |", "### shapes: `polygon`",
        "| `corner_m` | list of: number; 3 to 5 of them | required | of the polygon |"})
    EXPECT_THAT(text, HasSubstr(line));
}

}  // namespace
}  // namespace trilat
