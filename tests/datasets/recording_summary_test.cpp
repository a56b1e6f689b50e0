// SPDX-License-Identifier: MIT
#include "datasets/results/studies/recording_summary.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/paper/printed_tables.h"
#include "datasets/results/studies/stage_timings.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

TimeSpread small_spread() {
  TimeSpread spread;
  spread.n = 6;
  spread.bins = {1, 2, 0, 0, 0, 3};
  spread.median_s = 1.0 / 3.0;
  spread.max_s = 0.5;
  return spread;
}

RecordingSummary small_summary() {
  constexpr double kNone = TimeSpread::kNone;
  RecordingSummary s{"table4", 18'000'000'000'000'000'000u, 6, 2, 1, {}, {}, 0.02, {}};
  s.clocks = {{"lan", "corrected", 7, small_spread(), 1.0 / 6.0, 0.1, 0.2, {{3, 2, 0, 1}, {4, 4, 1, 2}}},
              {"lan", "none", 6, {}, kNone, kNone, kNone, {{6, 0, 0, 0}, {}}}};
  s.fits = {{"lan", 1e-5, 2e-4, 1.0, 0.25}, {"cut"}};
  s.queues = {{"lan", "corrected", "as they come", {10, 1, 2, 3, 4}, 0.3, kNone}};
  return s;
}

TEST(RecordingSummary, IsReadAsItWasWritten) {
  const ScratchFolder folder;
  write_recording_summary(folder.path(), small_summary());
  const RecordingSummary read = read_recording_summary(folder.path());
  EXPECT_EQ(read.seed, 18'000'000'000'000'000'000u);
  ASSERT_EQ(read.clocks.size(), 2u);
  EXPECT_EQ(read.clocks[0].asked, 7u);
  EXPECT_EQ(read.clocks[0].error.bins[5], 3u);
  EXPECT_EQ(read.clocks[0].error.median_s, 1.0 / 3.0);
  EXPECT_EQ(read.clocks[0].units, small_summary().clocks[0].units);
  EXPECT_TRUE(std::isnan(read.clocks[0].error.p95_s) && std::isnan(read.clocks[1].below_2ms));
  EXPECT_EQ(read.fits[0].offset_bound_s, 2e-4);
  EXPECT_EQ(read.late_s, 0.02);
  EXPECT_EQ(read.queues.at(0).counts, (QueueCounts{10, 1, 2, 3, 4}));
  EXPECT_EQ(read.queues[0].server, "as they come");
  EXPECT_TRUE(std::isnan(read.fits[1].offset_sigma_s));
  const std::string once = read_file(folder / "summary.json");
  write_recording_summary(folder.path(), read);
  EXPECT_EQ(read_file(folder / "summary.json"), once);
}

// What the reader says of a summary.json in which one thing was changed.
std::string recording_refusal(const std::function<void(Json&)>& change) {
  const ScratchFolder folder;
  write_recording_summary(folder.path(), small_summary());
  Json json = parse_json(read_file(folder / "summary.json"), "summary.json");
  change(json);
  write_file(folder / "summary.json", json.dump());
  return message_of([&] { read_recording_summary(folder.path()); });
}

TEST(RecordingSummary, WhatIsNotOneIsRefusedWithItsPlace) {
  EXPECT_EQ(recording_refusal([](Json&) {}), "no error");
  EXPECT_THAT(recording_refusal([](Json& j) { j["version"] = 1; }),
              HasSubstr("/version: is another version"));
  EXPECT_THAT(recording_refusal([](Json& j) { j["kind"] = "calibration"; }),
              HasSubstr("/kind: is \"calibration\"; results of kind \"recording\" are needed here"));
  EXPECT_THAT(recording_refusal([](Json& j) { j["surprise"] = 1; }),
              HasSubstr("/surprise: is an unknown key"));
  EXPECT_THAT(recording_refusal([](Json& j) { j["clocks"][0]["error"]["n"] = 5; }),
              HasSubstr("/clocks/0/error/bins: must add up to n"));
  EXPECT_THAT(recording_refusal([](Json& j) {
                j["clocks"][0]["error"]["bins"] = {1, 2, 3};
              }),
              HasSubstr("/clocks/0/error/bins: must hold one count for each of the table's ranges"));
  EXPECT_THAT(recording_refusal([](Json& j) { j["clocks"][0]["error"]["bins"][1] = -2; }),
              HasSubstr("/clocks/0/error/bins: must hold counts"));
  EXPECT_THAT(recording_refusal([](Json& j) { j["fits"][0].erase("offset_sigma_s"); }),
              HasSubstr("/fits/0/offset_sigma_s"));
}

TEST(RecordingSummary, FramesOfAQueueMustAddUp) {
  const auto with = [](const char* key, const Json& count) {
    return recording_refusal([&](Json& j) { j["queues"][0][key] = count; });
  };
  EXPECT_EQ(with("came", 10), "no error");
  EXPECT_THAT(with("came", 11), HasSubstr("/queues/0/came: must be the sum"));
  EXPECT_THAT(with("taken", 5), HasSubstr("/queues/0/taken: makes more frames than came"));
  EXPECT_THAT(with("too_late", 18446744073709551615u),
              HasSubstr("/queues/0/too_late: makes more frames than came"));
  EXPECT_THAT(with("too_late", -1), HasSubstr("/queues/0/too_late"));
}

TEST(RecordingSummary, CountsOfRunsAndSensorsMustFitTheirRow) {
  const auto with_units = [](const Json& units) {
    return recording_refusal([&](Json& j) { j["clocks"][0]["units"] = units; });
  };
  const auto row = [](auto... counts) { return Json::array({counts...}); };
  EXPECT_EQ(with_units({row(3, 2, 0, 1), row(4, 4, 1, 2)}), "no error");
  EXPECT_THAT(with_units(Json::array({row(7, 6, 1, 3)})),
              HasSubstr("/clocks/0/units: must hold one row for each run and sensor"));
  EXPECT_THAT(with_units({row(3, 2, 0, 1), row(4, 4, 1)}),
              HasSubstr("/clocks/0/units/1: must hold 4 counts"));
  EXPECT_THAT(with_units({row(3, 2, 0, 1), row(4, 4, -1, 2)}),
              HasSubstr("/clocks/0/units/1: must hold 4 counts"));
  EXPECT_THAT(with_units({row(3, 2, 0, 1), row(4, 5, 1, 2)}),
              HasSubstr("/clocks/0/units/1: counts more answers than were asked for, or more good ones"));
  EXPECT_THAT(with_units({row(3, 2, 2, 1), row(4, 4, 1, 2)}), HasSubstr("/clocks/0/units/0: counts more"));
  EXPECT_THAT(with_units({row(3, 2, 1, 1), row(4, 4, 1, 2)}),
              HasSubstr("/clocks/0/units: must add up to the counts of the row"));
  EXPECT_THAT(with_units({row(8, 2, 0, 1), row(18446744073709551615u, 4, 1, 2)}),
              HasSubstr("/clocks/0/units: must add up to the counts of the row"));
  EXPECT_THAT(with_units(7), HasSubstr("/clocks/0/units: must be an array"));
}

TEST(StageTimings, AreReadAsTheyWereWrittenAndMayBeMissing) {
  const ScratchFolder folder;
  EXPECT_FALSE(read_stage_timings(folder.path()).has_value());
  write_stage_timings(folder.path(),
                      {"table4", "a processor", {{"trilateration", "linear", small_spread()}}});
  const auto read = read_stage_timings(folder.path());
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->processor, "a processor");
  ASSERT_EQ(read->stages.size(), 1u);
  EXPECT_EQ(read->stages[0].method, "linear");
  EXPECT_EQ(read->stages[0].time.n, 6u);
}

TEST(PrintedTable4, HasThePapersNumbers) {
  const PrintedTable4 paper = printed_table4();
  std::uint64_t frames = 0, samples = 0;
  for (const PrintedTable4::Row& row : paper.rows) {
    frames += row.frames;
    samples += row.clock_samples;
  }
  ASSERT_EQ(paper.rows.size(), 6u);
  EXPECT_EQ(paper.rows[0].to_ms, std::numeric_limits<double>::infinity());
  EXPECT_EQ(paper.rows[1].frames, 11926u);
  EXPECT_EQ(frames + paper.lost_frames, paper.frames);
  EXPECT_EQ(samples, 71998u);
  EXPECT_EQ(paper.frames * paper.clients, 72000u);
}

}  // namespace
}  // namespace trilat
