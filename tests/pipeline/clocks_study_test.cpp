// SPDX-License-Identifier: MIT
#include "pipeline/clocks/clocks_study.h"

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
  ClocksSpec spec = parse_clocks_spec(parse_json(kStudy, "study.json"), "study.json", {});
  spec.late_s = late_s;
  run_clocks(spec, campaign, folder, {});
  return read_results<ClocksSummary>(folder);
}

const ClockErrorRow& row_of(const ClocksSummary& summary, const std::string& method) {
  return *std::ranges::find(summary.clocks, method, &ClockErrorRow::method);
}

TEST(ClocksStudy, SaysOfEveryComputerHowGoodItsClockWas) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", walking_spec(2, 12.0));
  const ClocksSummary summary = summary_of(folder / "out", campaign);
  EXPECT_TRUE(summary.simulated);
  EXPECT_EQ(summary.recordings, 2u);
  ASSERT_EQ(summary.machines.size(), 8u);
  for (const MachineRow& machine : summary.machines) {
    EXPECT_GE(machine.exchanges, 47u);
    EXPECT_LT(machine.offset_sigma_s, 1e-3);
    EXPECT_GT(machine.within_bound_share, 0.99);
    EXPECT_NEAR(machine.latency_median_s, 0.0212, 0.001);  // 20 ms, 0.7 of jitter, the way
    EXPECT_GT(machine.latency_p99_s, machine.latency_median_s);
    EXPECT_GT(machine.in_time_share, 0.99);
  }
  EXPECT_LT(row_of(summary, "corrected, offline").error.p99_s,
            row_of(summary, "corrected, causal").error.p99_s);
  EXPECT_LT(row_of(summary, "corrected, causal").error.p99_s, 0.002);
  EXPECT_GT(row_of(summary, "as printed, for the server's clock").error.median_s, 1.0);
  EXPECT_LT(row_of(summary, "as printed, on the client's clock").error.median_s, 0.004);
  Campaign renamed = campaign;  // its item is found, and the summary names it as it is called now
  renamed.name = "renamed";
  const ClocksSummary again = summary_of(folder / "out", renamed);
  EXPECT_EQ(again.campaign, "renamed");
  for (const ClaimNumber& number : again.claims) EXPECT_TRUE(number.what.empty() || number.what == "renamed");
}

// Nothing comes from the future by right clocks; a computer's clock that is taken for the recorder's is off
// by up to a thousand seconds, and its frames are dropped for it. Nothing is taken that may not be late at
// all.
TEST(ClocksStudy, AWrongClockMakesTheQueueDropFramesThatCameInTime) {
  const ScratchFolder folder;
  const Campaign campaign = simulate_into(folder / "c", walking_spec(1, 12.0));
  const auto taken = [&](const ClocksSummary& summary, const std::string& method, const std::string& server) {
    for (const QueueRow& row : summary.queues)
      if (row.method == method && row.server == server)
        return static_cast<double>(row.counts.taken) / static_cast<double>(row.counts.came);
    return kNoNumber;
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
  EXPECT_EQ(summary.machines.size(), 4u);
  ASSERT_EQ(summary.left_out.size(), 4u);
  EXPECT_THAT(summary.left_out[0],
              HasSubstr("p02-walking, k1: has no clock exchanges: it was recorded on the recorder's own"));
  campaign.takes.erase(campaign.takes.begin());
  EXPECT_THAT(message_of([&] { summary_of(folder / "other", campaign); }),
              HasSubstr("has no clock exchanges"));
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
