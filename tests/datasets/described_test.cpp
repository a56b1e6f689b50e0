// SPDX-License-Identifier: MIT
#include "datasets/base/described.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

struct Interval {
  double low = 0.0, high = 0.0;
  static constexpr bool as_list = true;
  TRILAT_FIELDS(low, high)
};

struct Part {
  std::string name;
  std::vector<double> values;
  TRILAT_FIELDS(name, values)
};

struct Whole {
  std::string id;
  bool sure = false;
  std::int64_t shift = 0;
  std::int8_t few = 0;
  std::uint64_t count = 0;
  double mean = 0.0;
  std::array<double, 2> pair{};
  std::map<std::string, std::uint64_t> counts;
  std::vector<Part> parts;
  Interval interval;
  std::optional<Part> extra;
  bool has_truth = false;
  std::uint64_t truth = 0;

  double twice() const { return 2.0 * mean; }
  static void fields(auto& self, auto&& field) {
    field("name", self.id);
    TRILAT_EACH(sure, shift, few, count, mean)
    field("twice", self.twice());
    TRILAT_EACH(pair, counts, parts, interval, extra)
    if (field.has("truth", self.has_truth)) {
      TRILAT_EACH(truth)
    }
  }
  void check(const JsonObject& object) const {
    if (count > 100) object.refuse("count", "is too large");
  }
};

Whole full() {
  return {"w",
          true,
          -3,
          -128,
          7,
          0.1 + 0.2,
          {1.0, 2.0},
          {{"b", 1}, {"a", 2}},
          {{"p", {0.5, std::nan("")}}, {"q", {}}},
          {0.25, std::numeric_limits<double>::infinity()},
          Part{"x", {1.0}},
          true,
          9};
}

constexpr const char* kText =
    R"({"name":"w","sure":true,"shift":-3,"few":-128,"count":7,"mean":0.30000000000000004,"twice":0.6000000000000001,)"
    R"("pair":[1.0,2.0],"counts":{"a":2,"b":1},"parts":[{"name":"p","values":[0.5,null]},{"name":"q","values":[]}],)"
    R"("interval":[0.25,null],"extra":{"name":"x","values":[1.0]},"truth":9})";

Whole read(const Json& json) { return read_as<Whole>(JsonObject(json, "file", "")); }

TEST(Described, IsWrittenInTheOrderOfItsFields) { EXPECT_EQ(json_text(json_of(full()), -1), kText); }

TEST(Described, IsReadAsItWasWritten) {
  const Json json = Json::parse(kText);
  const Whole whole = read(json);
  EXPECT_EQ(json_text(json_of(whole), -1), kText);
  EXPECT_EQ(whole.mean, 0.1 + 0.2);
  EXPECT_TRUE(std::isnan(whole.interval.high));
}

TEST(Described, WhatIsOptionalMayBeMissing) {
  Json json = Json::parse(kText);
  json.erase("extra");
  json.erase("truth");
  const Whole whole = read(json);
  EXPECT_FALSE(whole.extra || whole.has_truth);
  json["truth"] = nullptr;
  EXPECT_THAT(message_of([&] { read(json); }), HasSubstr("/truth: must be an integer"));
}

TEST(Described, WhatDoesNotFitIsRefusedWithItsPlace) {
  const std::pair<const char*, const char*> odd[] = {{"/name", "1"},
                                                     {"/sure", "1"},
                                                     {"/shift", "0.5"},
                                                     {"/shift", "9223372036854775808"},
                                                     {"/few", "128"},
                                                     {"/few", "-129"},
                                                     {"/count", "-1"},
                                                     {"/count", "101"},
                                                     {"/mean", "\"small\""},
                                                     {"/pair", "[1.0]"},
                                                     {"/pair", "7"},
                                                     {"/counts/a", "-1"},
                                                     {"/counts", "[]"},
                                                     {"/parts", "{}"},
                                                     {"/parts/1/name", "7"},
                                                     {"/parts/1/more", "7"},
                                                     {"/parts/0/values", "1"},
                                                     {"/interval", "[1.0]"},
                                                     {"/interval", "[1.0, 2.0, 3.0]"},
                                                     {"/interval/0", "\"x\""},
                                                     {"/extra", "7"},
                                                     {"/more", "1"}};
  for (const auto& [pointer, value] : odd) {
    Json json = Json::parse(kText);
    json[Json::json_pointer(pointer)] = Json::parse(value);
    EXPECT_THAT(message_of([&] { read(json); }), HasSubstr(std::string("file ") + pointer + ": ")) << value;
  }
  Json json = Json::parse(kText);
  json["parts"][0]["values"][1] = "x";
  EXPECT_THAT(message_of([&] { read(json); }), HasSubstr("file /parts/0/values: must be a number or null"));
}

TEST(Described, EveryFieldMustBeThere) {
  const Json whole = Json::parse(kText);
  for (const auto& [key, value] : whole.items()) {
    if (key == "extra" || key == "truth") continue;
    Json json = whole;
    json.erase(key);
    EXPECT_THAT(message_of([&] { read(json); }), HasSubstr("file /" + key + ": is missing"));
  }
}

}  // namespace
}  // namespace trilat
