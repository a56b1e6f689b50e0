// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/methods/study_spec.h"

#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "pipeline/accuracy/methods/method.h"
#include "pipeline/accuracy/methods/method_kinds.h"
#include "tests/pipeline/campaigns.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

std::vector<std::string> names_on(const std::vector<std::string>& rig, const std::string& methods) {
  std::vector<std::string> names;
  for (const Method& m : resolve_methods(study_of(R"("methods": [{)" + methods + "}]"), rig))
    names.push_back(m.spec.name);
  return names;
}

TEST(Study, AnEntryOfSetsBecomesOneMethodForEachSetOfSensors) {
  const std::vector<std::string> rig{"k1", "k2", "k3", "k4"};
  EXPECT_THAT(names_on(rig, R"("method": "geometric", "each": 3)"),
              testing::ElementsAre("geometric k1+k2+k3", "geometric k1+k2+k4", "geometric k1+k3+k4",
                                   "geometric k2+k3+k4"));
  EXPECT_THAT(names_on(rig, R"("method": "single", "name": "one")"),
              testing::ElementsAre("one k1", "one k2", "one k3", "one k4"));
  EXPECT_THAT(names_on(rig, R"("method": "mean", "each": 2, "sensors": ["k4", "k2"])"),  // of one set
              testing::ElementsAre("mean"));
  const auto methods =
      resolve_methods(study_of(R"("methods": [{"method": "geometric", "each": 3, "name": "triples"}])"), rig);
  EXPECT_EQ(methods[3].sensors, (std::vector{1, 2, 3}));
  EXPECT_EQ(methods[3].spec.family, "triples");
}

TEST(Study, OfManySetsADeclaredNumberStandsForAllAndSmallerOnesLieWithinLargerOnes) {
  for (std::size_t size = 2; size < 8; ++size) {
    const auto sets = sensor_sets(8, size, 9), larger = sensor_sets(8, size + 1, 9);
    EXPECT_EQ(sets.size(), size == 7 ? 8u : 9u);
    EXPECT_EQ(std::set(sets.begin(), sets.end()).size(), sets.size());
    std::size_t nested = 0;
    for (const auto& set : sets)
      nested += std::ranges::any_of(larger, [&](const auto& whole) {
        return std::includes(whole.begin(), whole.end(), set.begin(), set.end());
      });
    EXPECT_GE(nested, size < 6 ? 7u : 8u) << size;  // a set that came twice has another in its place
  }
}

TEST(Study, EveryKindOfMethodIsAWholeRow) {
  std::set<std::string_view> names;
  for (const MethodKind& kind : method_kinds()) {
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
    EXPECT_EQ(&method_kind(kind.name), &kind);
    EXPECT_FALSE(kind.what.empty() || kind.source.empty()) << kind.name;
    EXPECT_NE(kind.evaluate == nullptr, kind.over_time == nullptr) << kind.name;
  }
}

// Four sensors see a joint: the second infers it, and equation 8 finds a bone before the third.
TEST(Study, RulesOfOcclusionLeaveTheirOwnSensorsOut) {
  std::vector<JointObservation> seen(4);
  for (JointObservation& o : seen) {
    o.seen = true;
    o.state = TrackingState::tracked;
  }
  seen[1].state = TrackingState::inferred;
  JointInstant instant;
  instant.observations = seen;
  instant.occlusions[static_cast<std::size_t>(OcclusionRule::printed)][2] = 1;
  const auto used = [&](const std::string& rule) {
    const StudySpec study = study_of(R"("methods": [{"method": "nonlinear", "occlusion": )" + rule + "}]");
    return sensors_of(resolve_methods(study, {"k1", "k2", "k3", "k4"}).front(), instant).to_ulong() & 0b1111;
  };
  EXPECT_EQ(used(R"("off")"), 0b1111U);
  EXPECT_EQ(used(R"("inferred")"), 0b1101U);
  EXPECT_EQ(used(R"("printed")"), 0b1001U);
  instant.occlusions[static_cast<std::size_t>(OcclusionRule::hidden)][3] = 1;
  EXPECT_EQ(used(R"("hidden")"), 0b0111U);
  EXPECT_EQ(used(R"("printed", "inferred_is_occluded": false)"), 0b1011U);
  EXPECT_EQ(used(R"("inferred", "fewest_sensors": 4)"), 0b1111U);
}

TEST(Study, WhatIsWrittenOutIsReadAsTheSameForEveryKindOfMethod) {
  std::string methods;
  for (const MethodKind& row : method_kinds())
    for (const char* more : {"", R"(, "occlusion": "corrected", "fewest_sensors": 2)"})
      if (row.sensors != 1 || *more == '\0')
        methods +=
            (methods.empty() ? "" : ", ") + fmt::format(R"({{"method": "{}", "name": "{}{}"{}}})", row.name,
                                                        row.name, *more == '\0' ? "" : " occluded", more);
  methods += R"(, {"method": "nonlinear", "name": "paper", "gradient": "printed", "damping": "none",
      "threshold_cm2": 0.3, "max_iterations": 7, "start": "linear", "printed_unit_m": 0.01},
      {"method": "linear", "name": "pairs", "reference": "all_pairs"},
      {"method": "mean", "name": "threes", "each": 3, "most_sets": 2})";
  const Json once = json_of(study_of(R"("alignments": ["held_out", "none"], "methods": [)" + methods + "]"));
  const Json twice = json_of(parse_study(parse_json(json_text(once, -1), "study.json"), "study.json", {}));
  EXPECT_EQ(json_text(once, -1), json_text(twice, -1));
}

}  // namespace
}  // namespace trilat
