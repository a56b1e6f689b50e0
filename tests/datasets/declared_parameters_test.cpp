// SPDX-License-Identifier: MIT
#include "datasets/results/declared_parameters.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/synthetic/simulation_spec.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(DeclaredParameters, AreReadAsTheyWereWritten) {
  const ScratchFolder folder;
  const std::vector<DeclaredParameter> parameters{{"rate", "30", "Hz", "the \"maker\""}, {"", "", "", ""}};
  write_declared_parameters(folder.path(), parameters);
  EXPECT_EQ(read_declared_parameters(folder.path()), parameters);
}

TEST(DeclaredParameters, WithoutAFileThereAreNoneAndAnotherFileIsRefused) {
  const ScratchFolder folder;
  EXPECT_TRUE(read_declared_parameters(folder.path()).empty());
  const auto refusal = [&](const std::string& text) {
    write_file(folder / "simulator.json", text);
    return message_of([&] { read_declared_parameters(folder.path()); });
  };
  EXPECT_THAT(refusal(R"({"format": "trilat.study"})"), HasSubstr("simulator.json /format: must be"));
  EXPECT_THAT(refusal(R"({"format": "trilat.simulator", "version": 2, "parameters": []})"),
              HasSubstr("/version"));
  EXPECT_THAT(refusal(R"({"format": "trilat.simulator", "version": 1, "parameters": [{"name": "a"}]})"),
              HasSubstr("/parameters/0/value"));
  EXPECT_THAT(refusal(R"({"format": "trilat.simulator", "version": 1, "parameters": [], "more": 1})"),
              HasSubstr("/more"));
  EXPECT_THAT(refusal("{"), HasSubstr("simulator.json"));
}

DeclaredParameter parameter(const SimulationSpec& spec, const std::string& name) {
  const auto all = simulation_parameters(spec);
  const auto found = std::ranges::find_if(all, [&](const auto& p) { return p.name == name; });
  EXPECT_NE(found, all.end()) << name;
  return found == all.end() ? DeclaredParameter{} : *found;
}

bool has(const SimulationSpec& spec, const std::string& name) {
  const auto all = simulation_parameters(spec);
  return std::ranges::any_of(all, [&](const auto& p) { return p.name == name; });
}

TEST(SimulationParameters, FollowTheSpec) {
  SimulationSpec spec;
  spec.participants = 3;
  spec.sensor.rate_hz = 15.0;
  spec.mocap.rate_hz = 240.0;
  spec.mocap.clock_error_s = 0.002;
  spec.rig.heights_m = {0.5, 1.25};
  EXPECT_EQ(parameter(spec, "participants").value, "3");
  EXPECT_EQ(parameter(spec, "frame rate").value, "15");
  EXPECT_EQ(parameter(spec, "mocap rate").value, "240");
  EXPECT_EQ(parameter(spec, "error of the stated start").value, "+-0.002");
  EXPECT_EQ(parameter(spec, "sensor heights").value, "0.5, 1.25");
  spec.sensor.free_running = false;
  EXPECT_EQ(parameter(spec, "clock drift").value, "+-0");
}

TEST(SimulationParameters, HaveAValueAndASourceAndADifferentNameEach) {
  SimulationSpec spec;
  spec.body_tracker = default_body_tracker();
  std::vector<std::string> names;
  for (const DeclaredParameter& p : simulation_parameters(spec)) {
    EXPECT_NE(p.value, "") << p.name;
    EXPECT_NE(p.source, "") << p.name;
    EXPECT_EQ(std::ranges::count(names, p.name), 0) << p.name;
    names.push_back(p.name);
  }
}

TEST(SimulationParameters, WhatWasSetSaysSo) {
  SimulationSpec spec;
  spec.body_tracker = default_body_tracker();
  const std::vector<DeclaredParameter> declared = simulation_parameters(spec);
  spec.body_tracker.lag_s = 0.0321;
  const std::vector<DeclaredParameter> set = simulation_parameters(spec);
  ASSERT_EQ(set.size(), declared.size());
  int changed = 0;
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (set[k].value == declared[k].value) {
      EXPECT_EQ(set[k].source, declared[k].source) << set[k].name;
      continue;
    }
    ++changed;
    EXPECT_THAT(set[k].value, HasSubstr("0.0321"));
    EXPECT_THAT(set[k].source, HasSubstr("set"));
    EXPECT_NE(set[k].source, declared[k].source);
  }
  EXPECT_EQ(changed, 1);
}

TEST(SimulationParameters, OfARecordedTakeNameItAndAssumeNoPersonAndNoMocap) {
  SimulationSpec spec;
  spec.recorded = RecordedSpec{"some/where/take.csv", "mapping.json"};
  spec.participants = 1;
  EXPECT_EQ(parameter(spec, "motion").source, "take.csv");
  EXPECT_EQ(parameter(spec, "participants").value, "1");
  for (const char* name : {"stature", "segments", "marker noise", "error of the stated start"})
    EXPECT_FALSE(has(spec, name)) << name;
}

}  // namespace
}  // namespace trilat
