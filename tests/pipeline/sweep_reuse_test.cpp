// SPDX-License-Identifier: MIT
#include <array>

#include <gmock/gmock.h>

#include "pipeline/sweep/earlier_cells.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/swept_folders.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

SweepPlan plan_with(const std::string& thresholds, const std::string& members = "") {
  return sweep_plan_of(kOneRig + R"(, "trials": 9000, "stops": ["objective"], "gradients": ["corrected"],
      "error_ranges_cm": [[5, 15], [0, 5]], "thresholds": )" +
                       thresholds + members);
}

TEST(SweepReuse, WithNothingChangedNothingIsWritten) {
  const ScratchFolder folder;
  const SweepPlan plan = plan_with("[1, 1e-4]", R"(, "time_problems": 3, "time_repeats": 1)");
  const SweepOutcome first = execute_sweep(plan, folder / "results", {});
  EXPECT_FALSE(first.unchanged);
  const std::string record = read_file(folder / "results/run.json");
  const SweepOutcome second = execute_sweep(plan, folder / "results/", {});
  EXPECT_TRUE(second.unchanged);
  EXPECT_EQ(second.tally.reused_count(), 4u);
  EXPECT_EQ(second.summary.cells.at(3).mae_m, first.summary.cells[3].mae_m);
  EXPECT_TRUE(second.timings);
  EXPECT_EQ(second.folder, folder / "results");
  EXPECT_EQ(read_file(folder / "results/run.json"), record);
  EXPECT_FALSE(fs::exists(folder / "results.partial"));
}

TEST(SweepReuse, WithNothingChangedWhatAnotherSweepLeftUnfinishedStays) {
  const ScratchFolder folder;
  const SweepPlan plan = plan_with("[1, 1e-4]");
  execute_sweep(plan, folder / "results", {});
  make_folder(folder / "results.partial");
  write_file(folder / "results.partial" / SweepLog::kFinished, "cells of another sweep\n");
  EXPECT_TRUE(execute_sweep(plan, folder / "results", {}).unchanged);
  EXPECT_TRUE(fs::exists(folder / "results.partial" / SweepLog::kFinished));
}

TEST(SweepReuse, ResultsThatAreReplacedWhileTheyAreReadAreRefused) {
  const ScratchFolder folder;
  const SweepPlan plan = plan_with("[1]");
  execute_sweep(plan, folder / "results", {});
  execute_sweep(plan_with("[1e-4]"), folder / "other", {});
  EarlierCells earlier(std::array{folder / "results"});
  fs::rename(folder / "results", folder / "aside");
  fs::rename(folder / "other", folder / "results");
  EXPECT_THAT(message_of([&] { earlier.find(items_of(plan).front().key); }),
              HasSubstr("results: was replaced while its results were used again"));
}

TEST(SweepReuse, FreshComputesAllAgain) {
  const ScratchFolder folder;
  const SweepPlan plan = plan_with("[1, 1e-4]");
  execute_sweep(plan, folder / "results", {});
  const SweepOutcome again = execute_sweep(plan, folder / "results", {.fresh = true});
  EXPECT_FALSE(again.unchanged);
  EXPECT_EQ(again.tally.computed.size(), 4u);
}

TEST(SweepReuse, ANewThresholdIsAllThatIsComputed) {
  const ScratchFolder folder;
  execute_sweep(plan_with("[1, 1e-4]"), folder / "results", {});
  const SweepPlan longer = plan_with("[1, 1e-2, 1e-4]");
  execute_sweep(longer, folder / "one", {});
  const SweepOutcome outcome = execute_sweep(longer, folder / "results", {});
  EXPECT_THAT(outcome.tally.computed, ElementsAre(2u, 3u));
  EXPECT_EQ(outcome.tally.reused_count(), 4u);
  expect_same_sweeps(folder / "one", folder / "results");
  const Json reused = read_json(folder / "results/run.json")["reused"];
  ASSERT_EQ(reused.size(), 1u);
  EXPECT_EQ(reused[0]["from"], (folder / "results").string());
  EXPECT_EQ(reused[0]["items"].size(), 4u);
  EXPECT_THAT(reused[0]["items"][1].get<std::string>(), HasSubstr("/linear/C 1/0 to 0.05 m"));
}

TEST(SweepReuse, EarlierResultsAreAskedInTheirOrder) {
  const ScratchFolder folder;
  execute_sweep(plan_with("[1]"), folder / "a", {});
  execute_sweep(plan_with("[1, 1e-4]"), folder / "b", {});
  const SweepPlan all = plan_with("[1e-6, 1e-4, 1]");
  execute_sweep(all, folder / "one", {});
  const SweepOutcome outcome =
      execute_sweep(all, folder / "results", {.work = {{}, {folder / "a", folder / "b"}}});
  EXPECT_THAT(outcome.tally.computed, ElementsAre(0u, 1u));
  EXPECT_THAT(outcome.tally.reused.at((folder / "b").string()), ElementsAre(2u, 3u));
  EXPECT_THAT(outcome.tally.reused.at((folder / "a").string()), ElementsAre(4u, 5u));
  expect_same_sweeps(folder / "one", folder / "results");
  EXPECT_THAT(message_of([&] {
                execute_sweep(all, folder / "other", {.work = {{}, {folder / "nowhere"}}});
              }),
              HasSubstr("nowhere: is no folder whose results could be used again"));
}

TEST(SweepReuse, WhateverDecidesAnOutcomeIsInTheKey) {
  const auto key = [](const std::string& thresholds, const std::string& members) {
    return items_of(plan_with(thresholds, members)).front().key;
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

TEST(SweepReuse, TheProgramSaysWhatItTookOver) {
  const ScratchFolder folder;
  const auto study = [&](const std::string& thresholds) {
    return file_with(folder, "sweep.json",
                     R"({"format": "trilat.study", "version": 1, "name": "short",
        "kind": "threshold_sweep", "trials": 500, "error_ranges_cm": [[0, 5]], "stops": ["objective"],
        "gradients": ["corrected"], "thresholds": )" +
                         thresholds + ", " + kOneRig + "}");
  };
  const std::string results = (folder / "results").string();
  EXPECT_EQ(run_trilat(folder, {"run", study("[1]"), "-o", results}).err, "");
  const Ended same = run_trilat(folder, {"run", study("[1]"), "-o", results, "--json"});
  EXPECT_EQ(same.err, "trilat: nothing changed; " + results + " holds all 1 cells already\n");
  EXPECT_EQ(only_json(same)["unchanged"], true);
  EXPECT_EQ(only_json(same)["cells"], 1);
  const Ended longer = run_trilat(folder, {"run", study("[1, 0.1, 0.01]"), "-o", results, "--json"});
  EXPECT_EQ(longer.err,
            "trilat: 1 cells of 3 are those of earlier results; " + results + "/run.json lists them\n");
  const Json json = only_json(longer);
  EXPECT_EQ(json["items"], 3);
  EXPECT_EQ(json["items_computed"], 2);
  EXPECT_EQ(json["items_reused"], 1);
  EXPECT_EQ(json["items_continued"], 0);
}

TEST(SweepReuse, TheProgramRunsAndMergesShards) {
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
  EXPECT_EQ(only_json(part)["trials"], only_json(rest)["shard_trials"]);
  expect_refused(run_trilat(folder, {"merge", path("a"), "-o", path("merged")}), "missing: shard 2/2");
  run_trilat(folder, {"run", study, "--shard", "2/2", "-o", path("b")});
  expect_refused(
      run_trilat(folder, {"merge", path("b"), path("a"), "-o", path("merged"), "--memory-mb", "500"}),
      "--memory-mb: is for parts of kind accuracy");
  EXPECT_EQ(run_trilat(folder, {"merge", path("b"), path("a"), "-o", path("merged")}).code, 0);
  expect_same_sweeps(path("one"), path("merged"));
  expect_refused(run_trilat(folder, {"run", study, "--shard", "3/2", "-o", path("c")}),
                 "--shard: is \"3/2\"");
}

}  // namespace
}  // namespace trilat
