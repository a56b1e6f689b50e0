// SPDX-License-Identifier: MIT
// What is particular to sweeps as studies; what holds for every kind is in every_kind_test.cpp.
#include "pipeline/sweep/sweep_study.h"

#include <set>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/base/files.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"
#include "tests/pipeline/swept_folders.h"

namespace trilat {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
namespace fs = std::filesystem;

SweepPlan plan_with(const std::string& thresholds, const std::string& members = "") {
  return sweep_plan_of(kOneRig + R"(, "trials": 70000, "stops": ["objective"], "gradients": ["corrected"],
      "error_ranges_cm": [[5, 15], [0, 5]], "thresholds": )" +
                       thresholds + members);
}

std::string key_of_first(const SweepPlan& plan) { return key_of_item(plan, items_of(plan).front()); }

// However long the sweep is, its items have each cell once, and none is too long unless a cell alone is.
TEST(SweepStudy, ItemsShareAllCellsOut) {
  for (const char* trials : {"1", "8193", "70000", "1000000", "9000000", "1000000000000"}) {
    const SweepPlan plan =
        sweep_plan_of(kOneRig + R"(, "error_ranges_cm": [[5, 15], [0, 5]], "trials": )" + trials);
    std::size_t next_cell = 0;
    std::set<std::string> ids;
    for (const SweepItem& item : items_of(plan)) {
      EXPECT_EQ(item.first_cell, next_cell) << trials;
      next_cell += item.cells;
      EXPECT_TRUE(item.cells == 1 || trials_in(plan, item) <= kItemTrials) << trials;
      EXPECT_TRUE(ids.insert(item.id).second) << item.id;
    }
    EXPECT_EQ(next_cell, plan.cells()) << trials;
  }
}

TEST(SweepStudy, ANewThresholdIsAllThatIsComputed) {
  const ScratchFolder folder;
  sweep_into(folder / "results", plan_with("[1, 1e-4]"));
  const SweepPlan longer = plan_with("[1, 1e-2, 1e-4]");
  sweep_into(folder / "one", longer);
  const ItemTally tally = sweep_into(folder / "results", longer, {.reuse = {folder / "results"}}).tally;
  EXPECT_THAT(tally.computed, SizeIs(1));
  EXPECT_THAT(tally.reused, SizeIs(2));
  expect_same_results(folder / "one", folder / "results");
}

TEST(SweepStudy, AnItemThatWasWrittenByHandIsRefused) {
  const ScratchFolder folder;
  const SweepPlan plan = plan_with("[1e-2]");
  sweep_into(folder / "part", plan, {.shard = {1, 1}});
  const fs::path item = item_folder(folder / "part", items_of(plan)[0].id) / kItemFile;
  const Json good = read_json(item);
  const auto said = [&](const char* pointer, const Json& value) {
    Json json = good;
    json[Json::json_pointer(pointer)] = value;
    write_file(item, json_text(json, -1));
    return message_of([&] {
      merge_parts(sweep_study(plan), read_parts(std::vector{folder / "part"}), folder / "merged", {});
    });
  };
  EXPECT_THAT(said("/outcome", Json::array()), HasSubstr("item.json outcome: must be a list of 2 cells"));
  EXPECT_THAT(said("/outcome/1/asked", 3), HasSubstr("item.json outcome /1/asked: must be 70000"));
  EXPECT_THAT(said("/outcome/0/more", 3), HasSubstr("item.json outcome /0"));
  EXPECT_EQ(said("/key", "another"), "no error");
}

TEST(SweepStudy, WhateverDecidesAnOutcomeIsInTheKey) {
  const auto key = [](const std::string& thresholds, const std::string& members) {
    return key_of_first(plan_with(thresholds, members));
  };
  const std::string base = key("[1]", "");
  EXPECT_EQ(key("[1, 2]", R"(, "time_problems": 5)"), base);
  for (const char* members :
       {R"(, "seed": 2)", R"(, "max_iterations": 77)", R"(, "digits_trials": 5)", R"(, "joints": ["centre"])",
        R"(, "error_models": ["gaussian"])", R"(, "threshold_units": ["m2"])", R"(, "dampings": ["lm"])",
        R"(, "curvatures": ["newton"], "dampings": ["lm"])", R"(, "starts": ["mean"])"})
    EXPECT_NE(key("[1]", members), base) << members;
  EXPECT_NE(key("[2]", ""), base);
}

TEST(SweepStudy, TheProgramSaysWhatItTookOver) {
  const ScratchFolder folder;
  const auto study = [&](const std::string& thresholds) {
    return file_with(folder, "sweep.json",
                     R"({"format": "trilat.study", "version": 1, "name": "short",
        "kind": "threshold_sweep", "trials": 140000, "error_ranges_cm": [[0, 5]], "stops": ["objective"],
        "gradients": ["corrected"], "thresholds": )" +
                         thresholds + ", " + kOneRig + "}");
  };
  const std::string results = (folder / "results").string();
  EXPECT_EQ(run_trilat(folder, {"run", study("[1]"), "-o", results}).err, "");
  const Ended same = run_trilat(folder, {"run", study("[1]"), "-o", results, "--json"});
  EXPECT_EQ(same.err, "nothing changed: the results are there already\n");
  EXPECT_EQ(only_json(same)["unchanged"], true);
  EXPECT_EQ(only_json(same)["cells"], 1);
  const Ended longer = run_trilat(folder, {"run", study("[1, 0.1, 0.01]"), "-o", results, "--json"});
  EXPECT_THAT(longer.err, HasSubstr("1 items did not change and are taken from earlier results: trials/"));
  const Json json = only_json(longer);
  EXPECT_EQ(json["items"], 3);
  EXPECT_EQ(json["items_computed"], 2);
  EXPECT_EQ(json["items_reused"], 1);
  EXPECT_EQ(json["items_continued"], 0);
}

TEST(SweepStudy, TheProgramRunsAndMergesShards) {
  const ScratchFolder folder;
  const std::string study = file_with(folder, "sweep.json",
                                      R"({"format": "trilat.study", "version": 1,
      "kind": "threshold_sweep", "name": "short", "trials": 20000, "error_ranges_cm": [[0, 5]], )" +
                                          kOneRig + "}");
  const auto path = [&](const char* name) { return (folder / name).string(); };
  const Ended plan = run_trilat(folder, {"run", study, "--dry-run", "--shard", "2/2", "--json"});
  const Ended rest = run_trilat(folder, {"run", study, "--dry-run", "--shard", "1/2", "--json"});
  EXPECT_EQ(only_json(plan)["shard"], "2/2");
  EXPECT_EQ(only_json(plan)["shard_trials"].get<int>() + only_json(rest)["shard_trials"].get<int>(),
            only_json(plan)["trials"].get<int>());
  EXPECT_EQ(run_trilat(folder, {"run", study, "-o", path("one")}).code, 0);
  const Ended part = run_trilat(folder, {"run", study, "--shard", "1/2", "-o", path("a"), "--json"});
  EXPECT_EQ(only_json(part)["shard"], "1/2");
  EXPECT_EQ(only_json(part)["items"], only_json(rest)["shard_items"]);
  expect_refused(run_trilat(folder, {"merge", path("a"), "-o", path("merged")}), "missing: shard 2/2");
  run_trilat(folder, {"run", study, "--shard", "2/2", "-o", path("b")});
  EXPECT_EQ(run_trilat(folder, {"merge", path("b"), path("a"), "-o", path("merged")}).code, 0);
  expect_same_results(path("one"), path("merged"));
  expect_refused(run_trilat(folder, {"run", study, "--shard", "3/2", "-o", path("c")}),
                 "--shard: is \"3/2\"");
}

TEST(SweepStudy, ThePlanSurvivesThePartToTheBit) {
  const SweepPlan plan = sweep_plan_of(R"("rigs": [{"name": "a", "sensors_m": [[0.1, 0.30000000000000004, 0],
      [3.3333333333333335, 1.5, 1e-17], [0, 2, 3], [3, 0.5, 3.1]]}], "thresholds": [0.1234567890123456789],
      "error_ranges_cm": [[7, 12.345678901234567]], "trials": 10, "seed": 18446744073709551615)");
  const SweepPlan again = plan_of_work(sweep_work(plan), "part.json");
  EXPECT_EQ(sweep_work(again), sweep_work(plan));
  EXPECT_EQ(again.spec.ranges[0].high_m, plan.spec.ranges[0].high_m);
  EXPECT_EQ(again.spec.rigs[0].sensors_m, plan.spec.rigs[0].sensors_m);
  EXPECT_EQ(again.spec.seed, plan.spec.seed);
}

}  // namespace
}  // namespace trilat
