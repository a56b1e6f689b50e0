// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker_spec.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/synthetic/simulation_spec.h"
#include "datasets/synthetic/tracker/tracker_truth.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

SimulationSpec parsed(const std::string& members) {
  return parse_simulation(
      parse_json(R"({"format": "trilat.simulation", "version": 1)" + members + "}", "sim.json"), "sim.json",
      {});
}

double value_of(const BodyTrackerSpec::Groups& groups, TrackerGroup group) {
  return groups[static_cast<std::size_t>(group)];
}

TEST(BodyTrackerSpec, IsAsDeclaredUnlessSomethingElseIsAskedFor) {
  EXPECT_EQ(parsed("").body_tracker.bias_sigma_m, default_body_tracker().bias_sigma_m);
  const auto spec = parsed(R"(, "body_tracker": {}, "bystanders": 2)");
  EXPECT_EQ(spec.bystanders, 2u);
  EXPECT_EQ(spec.body_tracker.lag_s, default_body_tracker().lag_s);
  EXPECT_EQ(spec.body_tracker.bias_sigma_m, default_body_tracker().bias_sigma_m);
  EXPECT_GT(value_of(spec.body_tracker.bias_sigma_m, TrackerGroup::hip), 0.02);
}

TEST(BodyTrackerSpec, AnyValueCanBeSetForAllGroupsOrSome) {
  const auto spec = parsed(R"(, "body_tracker": {"lag_s": 0, "jitter_sigma_m": 0,
                                "bias_sigma_m": {"hip": 0.01}})")
                        .body_tracker;
  EXPECT_EQ(spec.lag_s, 0.0);
  EXPECT_THAT(spec.jitter_sigma_m, testing::Each(0.0));
  EXPECT_EQ(value_of(spec.bias_sigma_m, TrackerGroup::hip), 0.01);
  EXPECT_EQ(value_of(spec.bias_sigma_m, TrackerGroup::knee),
            value_of(default_body_tracker().bias_sigma_m, TrackerGroup::knee));
  EXPECT_EQ(spec.exchanged_share, default_body_tracker().exchanged_share);
}

TEST(BodyTrackerSpec, EveryValueIsListedWithUnitAndSource) {
  BodyTrackerSpec spec = default_body_tracker();
  const auto declared = tracker_parameters(spec);
  EXPECT_EQ(declared.size(), 20u);
  for (const DeclaredParameter& parameter : declared) {
    EXPECT_FALSE(parameter.unit.empty()) << parameter.name;
    EXPECT_THAT(parameter.source,
                testing::AnyOf(HasSubstr("arXiv"), HasSubstr("PMC"), HasSubstr("NTU RGB+D"),
                               HasSubstr("assumption: no published figure"), HasSubstr("measured on ")))
        << parameter.name;
  }
  EXPECT_EQ(declared[0].name, "bias_sigma_m");
  EXPECT_THAT(declared[0].value, HasSubstr("trunk 0.0"));
  spec.lag_s = 0.06;
  const auto set = tracker_parameters(spec);
  const auto lag = std::ranges::find_if(set, [](const auto& p) { return p.name == "lag_s"; });
  ASSERT_NE(lag, set.end());
  EXPECT_EQ(lag->value, "0.06");
  EXPECT_EQ(lag->source, "set in the simulation");
  EXPECT_EQ(set[0].source, declared[0].source);
}

TEST(BodyTrackerSpec, DeclaredValuesLieInTheRangesOfTheLiterature) {
  const BodyTrackerSpec& spec = default_body_tracker();
  for (std::size_t g = 0; g < kTrackerGroups; ++g) {
    const double norm_m = std::sqrt(3.0) * std::hypot(spec.bias_sigma_m[g], spec.view_bias_sigma_m[g]);
    EXPECT_TRUE(norm_m >= 0.02 && norm_m <= 0.10) << g;
    EXPECT_TRUE(spec.jitter_sigma_m[g] >= 0.00005 && spec.jitter_sigma_m[g] <= 0.008) << g;
  }
  EXPECT_TRUE(spec.lag_s >= 0.030 && spec.lag_s <= 0.060);
}

// What `trilat measure-tracker` writes is what a simulation reads, with intervals where there are some.
TEST(BodyTrackerSpec, TheDeclaredDocumentIsReadAsATracker) {
  const ScratchFolder folder;
  Json document = declared_body_tracker();
  document["values"]["lag_s"]["value"] = 0.07;
  write_file(folder / "tracker.json", document.dump());
  write_file(folder / "sim.json",
             R"({"format": "trilat.simulation", "version": 1, "body_tracker": "tracker.json"})");
  const SimulationSpec spec = read_simulation(folder / "sim.json");
  EXPECT_EQ(spec.body_tracker.lag_s, 0.07);
  EXPECT_EQ(spec.body_tracker.jitter_sigma_m, default_body_tracker().jitter_sigma_m);
  EXPECT_EQ(spec.body_tracker_file, folder / "tracker.json");
  document["groups"]["jitter_sigma_m"].erase("hip");
  write_file(folder / "tracker.json", document.dump());
  EXPECT_THAT(message_of([&] { read_simulation(folder / "sim.json"); }), HasSubstr("/groups/jitter_sigma_m"));
}

TEST(BodyTrackerSpec, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const std::pair<const char*, const char*> cases[] = {
      {R"(, "body_tracker": true)", "sim.json /body_tracker: must be an object"},
      {R"(, "body_tracker": {"lag": 1})", "sim.json /body_tracker/lag: is an unknown key"},
      {R"(, "body_tracker": {"lag_s": -1})", "sim.json /body_tracker/lag_s: must lie between 0"},
      {R"(, "body_tracker": {"exchanged_share": 2})",
       "sim.json /body_tracker/exchanged_share: must lie between 0"},
      {R"(, "body_tracker": {"own_bias_share": 0.8})",
       "sim.json /body_tracker/own_bias_share: is not there any more; say \"own_bias_sigma_m\""},
      {R"(, "body_tracker": {"ray_ratio": 0})", "sim.json /body_tracker/ray_ratio: must lie between 0.01"},
      {R"(, "body_tracker": {"bias_sigma_m": "big"})", "sim.json /body_tracker/bias_sigma_m: must be"},
      {R"(, "body_tracker": {"bias_sigma_m": {"nose": 1}})",
       "sim.json /body_tracker/bias_sigma_m/nose: is an unknown key"},
      {R"(, "body_tracker": {"wander_sigma_m": {"hip": 7}})",
       "sim.json /body_tracker/wander_sigma_m/hip: must lie between 0"},
      {R"(, "body_tracker": {}, "bystanders": 3)", "sim.json /bystanders: must be 0 to 2, is 3"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(message_of([m = members] { parsed(m); }), HasSubstr(message)) << members;
}

TEST(TrackerTruthFile, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  std::vector<TrackerTruth> rows;
  for (std::int64_t i = 0; i < 5000; ++i)
    rows.push_back({2 * i, static_cast<std::uint32_t>(i) % (1u << 25), i % 3 == 0, (1ull << 56) + 7});
  TrackerTruthWriter writer(folder / "truth.h5", {"k2", "k1"});
  for (const TrackerTruth& row : rows) writer.append(1, row);
  writer.append(0, {3, 1u << 24, true, 0});
  EXPECT_FALSE(std::filesystem::exists(folder / "truth.h5"));
  writer.finish();
  const TrackerTruthReader reader(folder / "truth.h5");
  EXPECT_THAT(reader.sensors(), testing::ElementsAre("k1", "k2"));
  EXPECT_EQ(reader.frames("k1"), rows.size());
  EXPECT_EQ(reader.read("k1", 0, rows.size()), rows);
  EXPECT_EQ(reader.read("k1", 4990, 10), std::vector<TrackerTruth>(rows.end() - 10, rows.end()));
  EXPECT_EQ(reader.read("k2", 0, 1), (std::vector<TrackerTruth>{{3, 1u << 24, true, 0}}));
  EXPECT_THAT(message_of([&] { reader.frames("k3"); }), HasSubstr("has no sensor \"k3\""));
}

// A file with one sensor of two frames, one of whose values is odd.
std::string refusal_of(const std::filesystem::path& path, const std::string& table, std::uint64_t value,
                       std::size_t rows = 2) {
  H5File file = H5File::create(path);
  file.set_text("format", "trilat.tracker_truth");
  file.set_integer("version", 1);
  H5Node node = file.create_group("sensors").create_group("k1");
  const auto add = [&](const char* name, H5Type type, auto first, auto second) {
    std::vector values{first, second};
    if (table == name) values.back() = static_cast<decltype(first)>(value);
    if (table == name) values.resize(rows);
    node.create_table(name, type, {}, {.chunk_rows = 16}).append(std::span<const decltype(first)>(values));
  };
  add("sequence", H5Type::i64, std::int64_t{4}, std::int64_t{5});
  add("hidden", H5Type::u32, std::uint32_t{0}, std::uint32_t{0});
  add("exchanged", H5Type::u8, std::uint8_t{0}, std::uint8_t{1});
  add("tracking_id", H5Type::u64, std::uint64_t{0}, std::uint64_t{0});
  node = {};
  file.close();
  return message_of([&] { TrackerTruthReader(path).read("k1", 0, 2); });
}

TEST(TrackerTruthFile, ErrorsNameThePlaceInTheFile) {
  const ScratchFolder folder;
  const auto refusal = [&](const std::string& table, std::uint64_t value, std::size_t rows = 2) {
    return refusal_of(folder / "t.h5", table, value, rows);
  };
  EXPECT_EQ(refusal("none", 0), "no error");
  EXPECT_THAT(refusal("sequence", 4), HasSubstr("t.h5:/sensors/k1/sequence: row 1: does not rise"));
  EXPECT_THAT(refusal("hidden", 1u << 25),
              HasSubstr("/sensors/k1/hidden: row 1: has bits that are no joints"));
  EXPECT_THAT(refusal("exchanged", 2), HasSubstr("/sensors/k1/exchanged: row 1: must be 0 or 1"));
  EXPECT_THAT(refusal("hidden", 0, 1), HasSubstr("/sensors/k1/hidden: has 1 rows, but sequence has 2"));
  write_file(folder / "text.h5", "no");
  EXPECT_THAT(message_of([&] { TrackerTruthReader(folder / "text.h5"); }), HasSubstr("text.h5"));
  H5File::create(folder / "other.h5").close();
  EXPECT_THAT(message_of([&] { TrackerTruthReader(folder / "other.h5"); }), HasSubstr("is no tracker truth"));
}

}  // namespace
}  // namespace trilat
