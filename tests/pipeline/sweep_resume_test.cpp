// SPDX-License-Identifier: MIT
// A sweep that was stopped, however it was, goes on and ends with the bytes of one that was not.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include <gmock/gmock.h>

#include "tests/pipeline/program.h"
#include "tests/pipeline/swept_folders.h"

namespace trilat {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

// Four cells of 20 chunks.
constexpr const char* kMembers = R"(, "thresholds": [1e-2, 1e-4], "trials": 160000, "stops": ["objective"],
    "error_ranges_cm": [[5, 15], [0, 5]], "gradients": ["corrected"], "digits_trials": 20000)";

SweepPlan resumed_plan(const std::string& members = R"(, "seed": 1)") {
  return sweep_plan_of(kOneRig + kMembers + members);
}

TEST(SweepResume, AfterEveryInterruptionItGoesOn) {
  const ScratchFolder folder;
  const SweepPlan plan = resumed_plan();
  execute_sweep(plan, folder / "one", {});
  int interruptions = 0;
  SweepOutcome outcome;
  do {
    std::atomic<int> asked{0};
    outcome = execute_sweep(plan, folder / "results", {.threads = 2, .stop_requested = [&] {
                                                         return ++asked > 500;
                                                       }});  // less than half of it
    if (!outcome.summary.interrupted) break;
    ++interruptions;
    EXPECT_EQ(outcome.folder, folder / "results.partial");
    EXPECT_TRUE(read_sweep_summary(outcome.folder).interrupted);
    EXPECT_FALSE(fs::exists(folder / "results"));
    ASSERT_LT(interruptions, 50);
  } while (true);
  EXPECT_GT(interruptions, 1);
  EXPECT_FALSE(outcome.tally.continued.empty());
  expect_same_sweeps(folder / "one", folder / "results");
  for (const char* file : {SweepLog::kFinished, SweepLog::kOpen})
    EXPECT_FALSE(fs::exists(folder / "results" / file));
}

TEST(SweepResume, WhatWasSavedBeforeItWasKilledIsNotComputedAgain) {
  const ScratchFolder folder;
  const SweepPlan plan = resumed_plan();
  execute_sweep(plan, folder / "one", {});
  run_and_drop(plan, folder / "results", {.threads = 2, .save_every_s = 0.0}, 0.9);
  const SweepOutcome outcome = execute_sweep(plan, folder / "results", {});
  EXPECT_GE(outcome.tally.continued.size(), 2u);
  EXPECT_LE(outcome.tally.computed.size(), 2u);
  EXPECT_EQ(outcome.tally.all(), 4u);
  expect_same_sweeps(folder / "one", folder / "results");
}

TEST(SweepResume, FreshForgetsWhatAnInterruptedRunLeft) {
  const ScratchFolder folder;
  const SweepPlan plan = resumed_plan();
  run_and_drop(plan, folder / "results", {.threads = 2, .save_every_s = 0.0}, 0.9);
  const SweepOutcome outcome = execute_sweep(plan, folder / "results", {.fresh = true});
  EXPECT_TRUE(outcome.tally.continued.empty());
  EXPECT_EQ(outcome.tally.computed.size(), 4u);
}

TEST(SweepResume, TornAndDamagedLinesAreComputedAgain) {
  const ScratchFolder folder;
  const SweepPlan plan = resumed_plan();
  execute_sweep(plan, folder / "one", {});
  run_and_drop(plan, folder / "results", {.threads = 2, .save_every_s = 0.0}, 0.9);
  const fs::path partial = folder / "results.partial";
  const std::string finished = read_file(partial / SweepLog::kFinished);
  const std::string open = read_file(partial / SweepLog::kOpen);
  ASSERT_GE(std::count(finished.begin(), finished.end(), '\n'), 2);
  std::string damaged = finished, damaged_open = open;
  damaged[finished.find('\n') + 100] ^= 1;
  damaged_open[80] ^= 1;
  const auto continued_with = [&](const std::string& finished_text, const std::string& open_text) {
    make_folder(partial);
    write_file(partial / SweepLog::kFinished, finished_text);
    write_file(partial / SweepLog::kOpen, open_text);
    const SweepOutcome outcome = execute_sweep(plan, folder / "results", {});
    expect_same_sweeps(folder / "one", folder / "results");
    fs::remove_all(folder / "results");
    return outcome.tally.continued;
  };
  EXPECT_THAT(continued_with(damaged, open), ElementsAre(0u));
  EXPECT_THAT(continued_with(finished.substr(0, finished.find('\n')), open), ElementsAre());
  EXPECT_THAT(continued_with("", damaged_open), ElementsAre());
  EXPECT_THAT(continued_with("what is this", "\n\n"), ElementsAre());
  EXPECT_GE(continued_with(finished, damaged_open).size(), 2u);
}

TEST(SweepResume, OnlyTheSharesOfTheSameShardAreContinued) {
  const ScratchFolder folder;
  const SweepPlan plan = resumed_plan();
  ExecuteSweepOptions options{.threads = 2, .work = {{1, 3}, {}}, .save_every_s = 0.0};
  run_and_drop(plan, folder / "part", options, 0.9);
  options.work.shard = {2, 3};
  EXPECT_TRUE(execute_sweep(plan, folder / "part", options).tally.continued.empty());
}

TEST(SweepResume, CellsThatStayedTheSameAreContinuedInAChangedStudy) {
  const ScratchFolder folder;
  run_and_drop(resumed_plan(), folder / "results", {.threads = 2, .save_every_s = 0.0}, 0.9);
  const SweepPlan longer =
      resumed_plan(R"(, "time_problems": 3, "time_repeats": 1, "joints": ["volume", "centre"])");
  const SweepOutcome outcome = execute_sweep(longer, folder / "results", {});
  EXPECT_GE(outcome.tally.continued.size(), 2u);
  EXPECT_EQ(outcome.tally.all(), 8u);
  execute_sweep(longer, folder / "one", {});
  expect_same_sweeps(folder / "one", folder / "results");
  run_and_drop(resumed_plan(), folder / "other", {.threads = 2, .save_every_s = 0.0}, 0.9);
  EXPECT_TRUE(execute_sweep(resumed_plan(R"(, "seed": 2)"), folder / "other", {}).tally.continued.empty());
}

// The real program, killed as soon as it has saved anything: long before it has computed everything.
TEST(SweepResume, AKilledProgramGoesOnToTheSameBytes) {
  const ScratchFolder folder;
  const std::string sweep = file_with(folder, "sweep.json",
                                      R"({"format": "trilat.study", "version": 1,
      "kind": "threshold_sweep", "name": "long", "thresholds": [1e-2, 1e-4], "stops": ["objective"],
      "gradients": ["corrected"], "error_ranges_cm": [[5, 15]], "trials": 12000000, )" +
                                          kOneRig + "}");
  const std::string results = (folder / "results").string();
  const fs::path open = folder / "results.partial" / SweepLog::kOpen;
  const Process killed(folder, {"run", sweep, "-o", results, "--threads", "1"}, "killed-");
  for (int i = 0; i < 60000 && !fs::exists(open); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ASSERT_TRUE(fs::exists(open));
  killed.kill_at_once();
  EXPECT_EQ(killed.wait().code, -1);
  EXPECT_FALSE(fs::exists(results));
  const Ended ended = run_trilat(folder, {"run", sweep, "-o", results, "--json"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("went on from a run that was stopped"));
  EXPECT_GE(only_json(ended)["items_continued"], 1);
  ASSERT_EQ(run_trilat(folder, {"run", sweep, "-o", (folder / "one").string()}).code, 0);
  expect_same_sweeps(folder / "one", results);
}

}  // namespace
}  // namespace trilat
