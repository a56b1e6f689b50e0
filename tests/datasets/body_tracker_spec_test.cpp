// SPDX-License-Identifier: MIT
#include "datasets/synthetic/tracker/body_tracker_spec.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/synthetic/simulation_spec.h"
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
  const auto spec = parsed(R"(, "body_tracker": {})");
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
  EXPECT_EQ(declared.size(), 19u);
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

// With intervals where there are some.
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
      {R"(, "body_tracker": {"ray_ratio": 0})", "sim.json /body_tracker/ray_ratio: must lie between 0.01"},
      {R"(, "body_tracker": {"bias_sigma_m": "big"})", "sim.json /body_tracker/bias_sigma_m: must be"},
      {R"(, "body_tracker": {"bias_sigma_m": {"nose": 1}})",
       "sim.json /body_tracker/bias_sigma_m/nose: is an unknown key"},
      {R"(, "body_tracker": {"wander_sigma_m": {"hip": 7}})",
       "sim.json /body_tracker/wander_sigma_m/hip: must lie between 0"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(message_of([m = members] { parsed(m); }), HasSubstr(message)) << members;
}

}  // namespace
}  // namespace trilat
