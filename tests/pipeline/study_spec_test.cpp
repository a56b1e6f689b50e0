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

std::string refusal_of(const std::string& members) {
  return message_of([&] { study_of(members); });
}

std::string refusal_of_method(const std::string& members) {
  return refusal_of(R"("methods": [{"method": "mean"}, {)" + members + "}]");
}

TEST(Study, ErrorsNameTheJsonPointerAndWhatWouldBeRight) {
  const std::string good = R"("methods": [{"method": "mean"}])";
  EXPECT_EQ(refusal_of(good), "no error");
  const std::pair<std::string, const char*> cases[] = {
      {good + R"(, "metods": [])", "study.json /metods: is an unknown key; known are: "},
      {good + R"(, "rate_hz": 30, "rate_hz": 60)", "study.json: has the key \"rate_hz\" twice"},
      {good + R"(, "rate_hz": 0)", "study.json /rate_hz: must be greater than 0"},
      {good + R"(, "rate_hz": 5000)", "study.json /rate_hz: must not be above 1000"},
      {good + R"(, "rate_hz": "30")", "study.json /rate_hz: must be a number, is the text \"30\""},
      {good + R"(, "alignments": ["sideways"])",
       "study.json /alignments: has \"sideways\"; known are: none, first, mean, rigid"},
      {good + R"(, "alignments": [])", "study.json /alignments: must name at least one alignment"},
      {good + R"(, "alignments": ["mean", "none", "mean"])", "study.json /alignments: has \"mean\" twice"},
      {good + R"(, "joints": ["nose"])", "study.json /joints: has \"nose\", which is no joint"},
      {good + R"(, "sensors": ["k1", "k2", "k1"])", "study.json /sensors: has \"k1\" twice"},
      {R"("methods": [])", "study.json /methods: must hold at least one method"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(refusal_of(members), HasSubstr(message)) << members;
}

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

TEST(Study, SetsThatCannotBeAreRefused) {
  EXPECT_THAT(refusal_of_method(R"("method": "geometric", "each": 4)"), HasSubstr("/each: must be 3"));
  EXPECT_THAT(refusal_of_method(R"("method": "single", "each": 2)"), HasSubstr("/each: must be 1"));
  EXPECT_THAT(message_of([&] {
                names_on({"k1", "k2"}, R"("method": "mean", "each": 3)");
              }),
              HasSubstr("asks for sets of 3 of 2 sensors"));
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
  const Json once =
      resolved_json(study_of(R"("alignments": ["held_out", "none"], "methods": [)" + methods + "]"));
  const Json twice =
      resolved_json(parse_study(parse_json(json_text(once, -1), "study.json"), "study.json", {}));
  EXPECT_EQ(json_text(once, -1), json_text(twice, -1));
}

TEST(Study, ErrorsOfAMethodNameItsPlaceInTheList) {
  const std::pair<const char*, const char*> cases[] = {
      {R"("method": "psychic")",
       "study.json /methods/1/method: is \"psychic\", which is unknown; known are: linear, geometric"},
      {R"("name": "x")", "study.json /methods/1/method: is missing"},
      {R"("method": "mean")", "study.json /methods/1/name: is \"mean\", which an earlier method has"},
      {R"("method": "linear", "gradient": "printed")", "study.json /methods/1/gradient: is an unknown key"},
      {R"("method": "nonlinear", "gradient": "printed", "damping": "lm")",
       "study.json /methods/1/damping: lm needs the corrected gradient"},
      {R"("method": "nonlinear", "gradient": "printed")",
       "study.json /methods/1/damping: lm needs the corrected gradient"},
      {R"("method": "nonlinear", "threshold_cm2": 0)",
       "study.json /methods/1/threshold_cm2: must be greater than 0, is 0"},
      {R"("method": "nonlinear", "max_iterations": 1.7)",
       "study.json /methods/1/max_iterations: must be an integer"},
      {R"("method": "nonlinear", "max_iterations": 0)",
       "study.json /methods/1/max_iterations: must be 1 to 1000000"},
      {R"("method": "nonlinear", "start": "point")", "study.json /methods/1/start: is \"point\", which is"},
      {R"("method": "geometric", "sensors": ["k1", "k2"])",
       "study.json /methods/1/sensors: must name the 3 sensors that geometric uses"},
      {R"("method": "geometric", "sensors": ["k1", "k2", "k1"])",
       "study.json /methods/1/sensors: has \"k1\" twice"},
      {R"("method": "window", "window_s": 0.01)", "study.json /methods/1/window_s: must lie between "},
      {R"("method": "window", "bone_sigma_m": 0)", "study.json /methods/1/bone_sigma_m: must lie between "},
      {R"("method": "window", "loss_scale_m": 100)", "study.json /methods/1/loss_scale_m: must lie between "},
      {R"("method": "window", "sigma_m": -1)", "study.json /methods/1/sigma_m: must lie between "},
      {R"("method": "window", "gate_sigma": 5)", "study.json /methods/1/gate_sigma: is an unknown key"},
      {R"("method": "rts", "window_s": 2)", "study.json /methods/1/window_s: is an unknown key"},
      {R"("method": "linear", "name": "")", "study.json /methods/1/name: must have 1 to 60 characters"}};
  for (const auto& [members, message] : cases)
    EXPECT_THAT(refusal_of_method(members), HasSubstr(message)) << members;
}

TEST(Study, TheResolvedSettingsReadBackAsTheSameStudy) {
  const StudySpec study = study_of(R"("alignments": ["none", "rigid"], "rate_hz": 60, "methods": [
      {"method": "linear", "reference": "all_pairs"}, {"method": "geometric", "sensors": ["k1", "k2", "k4"]},
      {"method": "nonlinear", "gradient": "printed", "damping": "none", "stop": "objective",
       "threshold_cm2": 1e-4}, {"method": "single"}, {"method": "ceres"}, {"method": "kalman"},
      {"method": "window", "window_s": 3, "bone_sigma_m": 0.02, "loss_scale_m": 0.2, "occlusion": "printed"}])");
  const Json resolved = parse_json(resolved_json(study).dump(), "resolved.json");
  EXPECT_EQ(resolved_json(parse_study(resolved, "resolved.json", {})).dump(), resolved.dump());
  EXPECT_NEAR(study.methods[2].nonlinear.threshold_m2, 1e-8, 1e-22);  // 1e-4 cm^2
}

TEST(Study, ItsCampaignIsRelativeToItsFile) {
  const Json study = parse_json(R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "x",
      "campaign": "takes", "methods": [{"method": "mean"}]})",
                                "study.json");
  EXPECT_EQ(parse_study(study, "study.json", "folder").campaign, std::filesystem::path("folder/takes"));
}

TEST(Methods, SingleWithoutSensorsBecomesOneMethodASensor) {
  const auto methods = resolve_methods(study_of(R"("methods": [{"method": "single"}])"), {"left", "right"});
  ASSERT_EQ(methods.size(), 2u);
  EXPECT_EQ(methods[0].spec.name, "single left");
  EXPECT_EQ(methods[1].spec.name, "single right");
  EXPECT_EQ(methods[1].sensors, std::vector{1});
}

TEST(Methods, ASensorTheRigDoesNotHaveIsNamedWithThoseItHas) {
  const auto resolve = [](const std::string& methods) {
    return message_of([&] { resolve_methods(study_of(R"("methods": [)" + methods + "]"), {"k1", "k2"}); });
  };
  EXPECT_THAT(resolve(R"({"method": "mean", "sensors": ["k9"]})"),
              HasSubstr("method \"mean k9\": names the sensor \"k9\"; the rig has k1, k2"));
  EXPECT_THAT(resolve(R"({"method": "linear", "reference": "k9"})"), HasSubstr("names the sensor \"k9\""));
  EXPECT_THAT(resolve(R"({"method": "single", "sensors": ["k1", "k2"]})"), HasSubstr("uses one sensor"));
  EXPECT_THAT(resolve(R"({"method": "single"}, {"method": "mean", "name": "single k2"})"),
              HasSubstr("method \"single k2\": stands twice"));
}

TEST(StudySpec, SettingsOfTheIntervalsAreChecked) {
  const auto with = [](const std::string& member) {
    return study_of(member + R"(, "methods": [{"method": "mean"}])");
  };
  EXPECT_EQ(with(R"("resamples": 0)").resamples, 0u);
  EXPECT_EQ(with(R"("block_s": 0.5)").block_s, 0.5);
  EXPECT_EQ(with(R"("clock_error_s": 0)").clock_error_s, 0.0);
  EXPECT_EQ(resolved_json(with(R"("resamples": 500)"))["resamples"], 500u);
  EXPECT_THAT(message_of([&] { with(R"("resamples": 50)"); }),
              testing::HasSubstr("/resamples: must be 0, for no intervals, or at least 200"));
  EXPECT_THAT(message_of([&] { with(R"("resamples": 1000000)"); }), testing::HasSubstr("/resamples: "));
  EXPECT_THAT(message_of([&] { with(R"("block_s": 0)"); }), testing::HasSubstr("/block_s: "));
}

}  // namespace
}  // namespace trilat
