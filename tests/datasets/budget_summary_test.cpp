// SPDX-License-Identifier: MIT
#include "datasets/results/studies/budget_summary.h"

#include <cmath>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/base/strict_json.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

BudgetSummary small_budget() {
  BudgetSummary s;
  s.study = "budget";
  s.campaign = "two persons";
  s.seed = 18'000'000'000'000'000'000u;
  s.participants = 2;
  s.calibration_sigma_m = 0.005;
  s.calibration_sigma_rad = 0.1 + 0.2;
  s.sources = {"none", "jitter", "all"};
  s.descriptions = {"nothing", "noise", "all"};
  s.rows = {{"none", "mean", "walking", "wrist", "none", 60, 1.0 / 3.0, 0.001},
            {"jitter", "mean", "walking", "wrist", "none", 0, kNoNumber, kNoNumber},
            {"all", "mean", "walking", "wrist", "none", 60, 0.02, 0.01}};
  return s;
}

TEST(BudgetSummary, IsReadAsItWasWritten) {
  const ScratchFolder folder;
  const BudgetSummary written = small_budget();
  write_budget_summary(folder.path(), written);
  const BudgetSummary read = read_budget_summary(folder.path());
  EXPECT_EQ(read.study, written.study);
  EXPECT_EQ(read.campaign, written.campaign);
  EXPECT_EQ(read.seed, written.seed);
  EXPECT_EQ(read.participants, written.participants);
  EXPECT_EQ(read.calibration_sigma_m, written.calibration_sigma_m);
  EXPECT_EQ(read.calibration_sigma_rad, written.calibration_sigma_rad);
  EXPECT_EQ(read.sources, written.sources);
  EXPECT_EQ(read.descriptions, written.descriptions);
  ASSERT_EQ(read.rows.size(), 3u);
  EXPECT_EQ(read.rows[0].rmse_m, 1.0 / 3.0);
  EXPECT_TRUE(std::isnan(read.rows[1].rmse_m) && std::isnan(read.rows[1].mae_m));
  EXPECT_EQ(read.rows[2].group, "wrist");
  EXPECT_EQ(read.rows[2].n, 60u);
  const std::string once = read_file(folder / "summary.json");
  write_budget_summary(folder.path(), read);
  EXPECT_EQ(read_file(folder / "summary.json"), once);
}

// What the reader says of a summary.json in which one thing was changed.
std::string refusal(const std::function<void(Json&)>& change) {
  const ScratchFolder folder;
  write_budget_summary(folder.path(), small_budget());
  Json json = parse_json(read_file(folder / "summary.json"), "summary.json");
  change(json);
  write_file(folder / "summary.json", json.dump());
  return message_of([&] { read_budget_summary(folder.path()); });
}

TEST(BudgetSummary, WhatIsNotOneIsRefusedWithItsPlace) {
  EXPECT_EQ(refusal([](Json&) {}), "no error");
  EXPECT_THAT(refusal([](Json& j) { j["kind"] = "accuracy"; }), HasSubstr("/version"));
  EXPECT_THAT(refusal([](Json& j) { j["kind"] = "threshold_sweep"; }),
              HasSubstr("/kind: is \"threshold_sweep\"; results of kind \"error_budget\" are needed here"));
  EXPECT_THAT(refusal([](Json& j) { j["version"] = 2; }), HasSubstr("/version: is another version"));
  EXPECT_THAT(refusal([](Json& j) { j["surprise"] = 1; }), HasSubstr("/surprise: is an unknown key"));
  EXPECT_THAT(refusal([](Json& j) { j["rows"][1]["surprise"] = 1; }), HasSubstr("/rows/1/surprise"));
  EXPECT_THAT(refusal([](Json& j) { j["rows"][2]["n"] = -1; }), HasSubstr("/rows/2/n"));
  EXPECT_THAT(refusal([](Json& j) { j["rows"][0].erase("mae_m"); }), HasSubstr("/rows/0/mae_m"));
  EXPECT_THAT(refusal([](Json& j) { j["rows"][0]["rmse_m"] = "small"; }), HasSubstr("/rows/0/rmse_m"));
  EXPECT_THAT(refusal([](Json& j) { j["descriptions"].erase(0); }),
              HasSubstr("/descriptions: must be as many as the sources"));
  EXPECT_THAT(refusal([](Json& j) { j["rows"][1]["source"] = "magic"; }),
              HasSubstr("/rows/1/source: is \"magic\", which is none of the sources"));
}

}  // namespace
}  // namespace trilat
