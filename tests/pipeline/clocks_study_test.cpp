// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clocks_study.h"

#include <set>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/results/table.h"
#include "pipeline/clocks/clock_trial.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/rewritten_session.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

const char* const kStudy = R"({"format": "trilat.study", "version": 1, "kind": "clocks", "name": "clocks"})";

ClocksSummary summary_of(const std::filesystem::path& folder, const Campaign& campaign,
                         double late_s = 1.0 / 30.0) {
  ClocksSpec spec = read_as<ClocksSpec>(parse_json(kStudy, "study.json"), {"study.json", {}});
  spec.late_s = late_s;
  run_clocks(spec, campaign, folder, {});
  return read_results<ClocksSummary>(folder);
}

double error_s(const ClocksSummary& summary, const char* method, const char* statistic) {
  return summary.numbers.value({.method = method, .measure = "clock_error", .statistic = statistic});
}

// Take and sensor of every computer's clock.
std::vector<NumberKey> computers(const ClocksSummary& summary) {
  std::vector<NumberKey> keys;
  for (const Number& number : summary.numbers.all())
    if (number.measure == "clock_fit" && number.statistic == "sigma")
      keys.push_back({.group = number.group, .take = number.take});
  return keys;
}

TEST(ClocksStudy, SaysOfEveryComputerHowGoodItsClockWas) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", walking_spec(2, 12.0));
  const ClocksSummary summary = summary_of(folder / "out", campaign);
  EXPECT_TRUE(summary.simulated);
  EXPECT_EQ(summary.recordings, 2u);
  ASSERT_EQ(computers(summary).size(), 8u);
  for (const NumberKey& computer : computers(summary)) {
    const auto value = [&](const char* measure, const char* statistic) {
      return summary.numbers.value(computer.with({.measure = measure, .statistic = statistic}));
    };
    EXPECT_GE(summary.numbers.n(computer.with({.measure = "clock_fit", .statistic = "sigma"})), 47u);
    EXPECT_GT(value("clock_fit", "share_used"), 0.1);
    EXPECT_LT(value("clock_fit", "sigma"), 1e-3);
    EXPECT_LT(value("clock_fit", "bound"), 0.01);
    EXPECT_LT(value("clock_fit", "bend"), 0.01);
    EXPECT_GT(value("clock_fit", "share_within_bound"), 0.99);
    EXPECT_NEAR(value("latency", "median"), 0.0212, 0.001);  // 20 ms, 0.7 of jitter, the way
    EXPECT_GT(value("latency", "p99"), value("latency", "median"));
    EXPECT_GT(value("latency", "share_in_time"), 0.99);
  }
  EXPECT_LT(error_s(summary, "corrected, offline", "p99"), error_s(summary, "corrected, causal", "p99"));
  EXPECT_LT(error_s(summary, "corrected, causal", "p99"), 0.002);
  EXPECT_GT(error_s(summary, "as printed, for the server's clock", "median"), 1.0);
  EXPECT_LT(error_s(summary, "as printed, on the client's clock", "median"), 0.004);
  Campaign renamed = campaign;  // its item is found, and the summary names it as it is called now
  renamed.name = "renamed";
  const ClocksSummary again = summary_of(folder / "out", renamed);
  EXPECT_EQ(again.campaign, "renamed");
}

// Nothing comes from the future by right clocks; a computer's clock that is taken for the recorder's is off
// by up to a thousand seconds, and its frames are dropped for it. Nothing is taken that may not be late at
// all.
TEST(ClocksStudy, AWrongClockMakesTheQueueDropFramesThatCameInTime) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", walking_spec(1, 12.0));
  const auto taken = [&](const ClocksSummary& summary, const char* method, const char* server) {
    const NumberKey key{.condition = server, .method = method, .measure = "queue"};
    double sum = 0.0;
    for (const char* fate : {"untimed", "too_early", "too_late", "taken"})
      sum += summary.numbers.value(key.with({.statistic = fate}));
    EXPECT_NEAR(sum, 1.0, 1e-12) << method;
    return summary.numbers.value(key.with({.statistic = "taken"}));
  };
  const ClocksSummary summary = summary_of(folder / "out", campaign);
  EXPECT_EQ(taken(summary, "corrected, causal", "as they come"), 1.0);
  EXPECT_EQ(taken(summary, "none", "as they come"), 0.0);
  EXPECT_LE(taken(summary, "corrected, causal", "once a frame of its own"), 1.0);
  EXPECT_EQ(taken(summary_of(folder / "none", campaign, 0.0), "corrected, offline", "as they come"), 0.0);
}

TEST(ClocksStudy, WhatHasNoExchangesIsNamedAndOneThatHasGoesOn) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "c", walking_spec(2, 3.0));
  change_session(campaign.takes[1], folder / "silent.h5", {.keeps_exchanges = false});
  const ClocksSummary summary = summary_of(folder / "out", campaign);
  EXPECT_EQ(computers(summary).size(), 4u);
  ASSERT_EQ(summary.failed.size(), 4u);
  EXPECT_THAT(summary.failed[0],
              HasSubstr("p02-walking, k1: has no clock exchanges: it was recorded on the recorder's own"));
  campaign.takes.erase(campaign.takes.begin());
  EXPECT_THAT(message_of([&] { summary_of(folder / "other", campaign); }),
              HasSubstr("has no clock exchanges"));
}

// One session that is a wand's and a ball's at stated distances, and a take that has its folder's name.
TEST(ClocksStudy, ASessionCountsOnceAndRecordingsOfOneNameAreToldApart) {
  const ScratchFolder folder;
  Campaign campaign = simulate_into(folder / "c", walking_spec(2, 3.0));
  Take& take = campaign.takes[1];
  std::filesystem::create_directories(folder / "c/wand");
  std::filesystem::copy(take.session.parent_path(), folder / "c/wand",
                        std::filesystem::copy_options::recursive);
  campaign.wand.emplace().session = folder / "c/wand/session.h5";
  campaign.stated_distances.emplace_back().session = folder / "c/wand/session.h5";
  take.id = "wand";
  const ClocksSummary summary = summary_of(folder / "out", campaign);
  EXPECT_EQ(summary.recordings, 3u);
  std::set<std::string> takes;
  for (const NumberKey& computer : computers(summary)) takes.insert(computer.take);
  EXPECT_THAT(takes, testing::ElementsAre("p01-walking", "wand", "wand (2)"));
}

TEST(ClocksVerb, RunsOnACampaignAndRefusesTheStudyItReplaces) {
  const ScratchFolder folder;
  simulate_into(folder / "c", walking_spec(1, 3.0));
  const Ended ended = run_trilat(folder, {"run", "clocks", "--campaign", folder / "c", "-o", folder / "out"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("Simulated: a live system puts frames"));
  // a folder of recordings, or one of them, without a campaign
  std::filesystem::remove(folder / "c/campaign.json");
  for (const char* what : {"c", "c/p01-walking/session.h5"}) {
    const Ended alone =
        run_trilat(folder, {"run", "clocks", "--campaign", folder / what, "-o", folder / "alone"});
    EXPECT_EQ(alone.code, 0) << alone.err;
    std::filesystem::remove_all(folder / "alone");
  }
  std::filesystem::create_directories(folder / "empty");
  expect_refused(run_trilat(folder, {"run", "clocks", "--campaign", folder / "empty", "-o", folder / "x"}),
                 "holds no campaign.json and no recording");
  expect_refused(run_trilat(folder, {"run", "table4", "-o", folder / "x"}), "is now the study clocks");
  expect_refused(run_trilat(folder, {"run", "clocks", "-o", folder / "x"}), "--campaign DIR");
  expect_refused(
      run_trilat(folder, {"run", "clocks", "--campaign", folder / "c", "--cross-check", "-o", folder / "x"}),
      "is for studies of kind accuracy");
}

}  // namespace
}  // namespace trilat
