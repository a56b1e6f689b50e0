// SPDX-License-Identifier: MIT
#include <cmath>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/files.h"
#include "datasets/results/samples.h"
#include "datasets/results/summary.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

SummaryCell full_summary_cell() {
  SummaryCell cell;
  cell.method = "nonlinear";
  cell.condition = "walking";
  cell.group = "head";
  cell.alignment = "mean";
  cell.asked = 100;
  cell.answered = 93;
  cell.statuses = {{"converged", 93}, {"too_few_ranges", 7}};
  cell.mae_m = 0.1 + 0.2;  // no short decimal
  cell.axis_mae_m = {1.0 / 3.0, 0.0, 1e-17};
  cell.rmse_m = 0.4;
  cell.p05_m = 0.1;
  cell.p25_m = 0.2;
  cell.median_m = 0.25;
  cell.p75_m = 0.5;
  cell.p90_m = 0.6;
  cell.p95_m = 0.7;
  cell.max_m = 1e3;
  cell.mean_iterations = 4.25;
  cell.mae_low_m = 0.27;
  cell.mae_high_m = 0.34;
  cell.clusters = 16;
  return cell;
}

SummaryCell unanswered_cell() {
  SummaryCell cell;
  cell.method = "geometric";
  cell.condition = "walking";
  cell.group = "head";
  cell.alignment = "mean";
  cell.asked = 100;
  cell.statuses = {{"too_few_ranges", 100}};
  return cell;
}

ResultsSummary summary_of(std::vector<SummaryCell> cells) {
  ResultsSummary summary;
  summary.study = "table3";
  summary.campaign = "two takes";
  summary.simulated = true;
  summary.takes = 2;
  summary.takes_failed = 1;
  summary.participants = 2;
  summary.methods = {"nonlinear", "geometric"};
  summary.conditions = {"walking"};
  summary.groups = {"head"};
  summary.alignments = {"mean"};
  summary.reference = "nonlinear";
  summary.resamples = 2000;
  summary.block_s = 1.0;
  summary.cells = std::move(cells);
  summary.by_take = {{"a",
                      "p01",
                      "walking",
                      "wrist",
                      "wrist_left",
                      "nonlinear",
                      50,
                      40,
                      0.1 + 0.2,
                      {30, 0.2, 0.3},
                      {45, 0.4, kNoNumber}}};
  summary.families = {{"single", 1, {"single k1", "single k2"}}};
  summary.notes = {{"b", true, "b/mocap.csv:17", "is cut"}};
  summary.cross_checks = {{"nonlinear", 93, 1, 3e-8, 1e-7, "a instant 3 head"}};
  return summary;
}

void expect_equal(const SummaryCell& a, const SummaryCell& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.condition, b.condition);
  EXPECT_EQ(a.group, b.group);
  EXPECT_EQ(a.alignment, b.alignment);
  EXPECT_EQ(a.asked, b.asked);
  EXPECT_EQ(a.answered, b.answered);
  EXPECT_EQ(a.statuses, b.statuses);
  EXPECT_EQ(a.clusters, b.clusters);
  const std::pair<double, double> numbers[] = {{a.mae_m, b.mae_m},
                                               {a.axis_mae_m[0], b.axis_mae_m[0]},
                                               {a.axis_mae_m[1], b.axis_mae_m[1]},
                                               {a.axis_mae_m[2], b.axis_mae_m[2]},
                                               {a.rmse_m, b.rmse_m},
                                               {a.p05_m, b.p05_m},
                                               {a.p25_m, b.p25_m},
                                               {a.median_m, b.median_m},
                                               {a.p75_m, b.p75_m},
                                               {a.p90_m, b.p90_m},
                                               {a.p95_m, b.p95_m},
                                               {a.max_m, b.max_m},
                                               {a.mean_iterations, b.mean_iterations},
                                               {a.mae_low_m, b.mae_low_m},
                                               {a.mae_high_m, b.mae_high_m}};
  for (const auto& [x, y] : numbers)
    if (!std::isnan(x) || !std::isnan(y)) {
      EXPECT_EQ(x, y);
    }
}

TEST(Summary, WhatIsWrittenIsReadBackToTheLastBitAndNaNStaysNaN) {
  const ScratchFolder folder;
  const ResultsSummary written = summary_of({full_summary_cell(), unanswered_cell()});
  write_summary(folder.path(), written);
  const ResultsSummary read = read_summary(folder.path());
  EXPECT_EQ(read.study, written.study);
  EXPECT_EQ(read.campaign, written.campaign);
  EXPECT_EQ(read.simulated, written.simulated);
  EXPECT_EQ(read.takes, 2u);
  EXPECT_EQ(read.takes_failed, 1u);
  EXPECT_EQ(read.participants, 2u);
  EXPECT_EQ(read.methods, written.methods);
  EXPECT_EQ(read.conditions, written.conditions);
  EXPECT_EQ(read.groups, written.groups);
  EXPECT_EQ(read.alignments, written.alignments);
  ASSERT_EQ(read.cells.size(), 2u);
  expect_equal(read.cells[0], written.cells[0]);
  expect_equal(read.cells[1], written.cells[1]);
  EXPECT_TRUE(std::isnan(read.cells[1].mae_m));
  EXPECT_TRUE(std::isnan(read.cells[1].axis_mae_m[2]));
  ASSERT_EQ(read.by_take.size(), 1u);
  EXPECT_EQ(read.by_take[0].joint, "wrist_left");
  EXPECT_EQ(read.by_take[0].answered, 40u);
  EXPECT_EQ(read.by_take[0].group, "wrist");
  EXPECT_EQ(read.by_take[0].mae_m, written.by_take[0].mae_m);
  EXPECT_EQ(read.by_take[0].both.n, 30u);
  EXPECT_EQ(read.by_take[0].both.reference_mae_m, 0.3);
  EXPECT_EQ(read.by_take[0].complete.n, 45u);
  EXPECT_TRUE(std::isnan(read.by_take[0].complete.reference_mae_m));
  ASSERT_EQ(read.families.size(), 1u);
  EXPECT_EQ(read.families[0].methods, written.families[0].methods);
  ASSERT_EQ(read.notes.size(), 1u);
  EXPECT_EQ(read.notes[0].place, "b/mocap.csv:17");
  EXPECT_TRUE(read.notes[0].failed);
  ASSERT_EQ(read.cross_checks.size(), 1u);
  EXPECT_EQ(read.cross_checks[0].worst_m, 3e-8);
  EXPECT_FALSE(read.cross_check_passed());
}

TEST(Summary, DifferencesBodiesAndSpeedsAreReadBackToTheLastBit) {
  const ScratchFolder folder;
  ResultsSummary written = summary_of({});
  written.differences = {
      {"mean", "walking", "head", "none", 93, 4, -0.1 / 3.0, -0.05, -0.01, -100.0 / 3.0, -50.0, -10.0, -50.0},
      {"linear", "walking", "average", "none"}};
  written.bodies = {{"mean",
                     "walking",
                     "none",
                     90,
                     4,
                     0.1,
                     0.09,
                     0.11,
                     0.05,
                     0.04,
                     0.06,
                     {0.5, 0.75, 1.0},
                     6,
                     0.01,
                     12.5,
                     3.25},
                    {"linear", "walking", "none"}};
  written.truth_speed = {{"walking", "head", 1.25}};
  write_summary(folder.path(), written);
  const std::string text = read_file(folder / "summary.json");
  EXPECT_THAT(text, HasSubstr("\"significant\": true"));
  const ResultsSummary read = read_summary(folder.path());
  EXPECT_EQ(read.reference, "nonlinear");
  EXPECT_EQ(read.resamples, 2000u);
  EXPECT_EQ(read.block_s, 1.0);
  ASSERT_EQ(read.differences.size(), 2u);
  EXPECT_EQ(read.differences[0].difference_m, -0.1 / 3.0);
  EXPECT_TRUE(read.differences[0].significant());
  EXPECT_FALSE(read.differences[1].significant());
  ASSERT_EQ(read.bodies.size(), 2u);
  EXPECT_EQ(read.bodies[0].pck, written.bodies[0].pck);
  EXPECT_TRUE(std::isnan(read.bodies[1].pck[2]));
  ASSERT_EQ(read.truth_speed.size(), 1u);
  EXPECT_EQ(read.truth_speed[0].mean_m_s, 1.25);
  write_summary(folder.path(), read);
  EXPECT_EQ(read_file(folder / "summary.json"), text);
}

TEST(Summary, OneWithoutAnyAlignmentIsRefused) {
  const ScratchFolder folder;
  ResultsSummary summary = summary_of({full_summary_cell()});
  summary.alignments.clear();
  write_summary(folder.path(), summary);
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }),
              HasSubstr("/alignments: must name at least one"));
}

// File names and asset names come from outside and need not be UTF-8.
TEST(Summary, ANoteThatIsNotUtf8IsStillWritten) {
  const ScratchFolder folder;
  ResultsSummary summary = summary_of({});
  summary.notes[0].text = "it holds marker:T\xeate";
  write_summary(folder.path(), summary);
  EXPECT_THAT(read_summary(folder.path()).notes.at(0).text, HasSubstr("marker:T"));
}

TEST(Summary, ErrorsNameThePlaceAndWhatWouldBeRight) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }),
              HasSubstr("holds no summary.json, so it is no results folder"));
  write_file(folder / "summary.json", R"({"format": "trilat.results", "version": 1})");
  EXPECT_THAT(
      message_of([&] { read_summary(folder.path()); }),
      HasSubstr("summary.json /version: is another version; this program reads version 7 of results of "
                "kind \"accuracy\""));
  write_file(folder / "summary.json", R"({"format": "coverage.py", "version": 1})");
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }),
              HasSubstr("summary.json /format: must be \"trilat.results\""));
  write_summary(folder.path(), summary_of({full_summary_cell()}));
  std::string text = read_file(folder / "summary.json");
  text.replace(text.find("\"asked\": 100"), 12, "\"asked\": -10");
  write_file(folder / "summary.json", text);
  EXPECT_THAT(message_of([&] { read_summary(folder.path()); }), HasSubstr("summary.json /cells/0/asked: "));
}

SamplesHeader small_header() {
  return {{"head", "neck"}, {"mean", "nonlinear", "linear"}, {"a", "b"}, "mean", {{"one", 10}, {"two", 5}}};
}

SampleBlock block_of(std::uint64_t first, std::uint64_t count) {
  SampleBlock block;
  block.reset(first, count, 2, 3);
  for (std::uint64_t i = 0; i < count; ++i) block.time_ns[i] = static_cast<std::int64_t>(first + i);
  for (std::size_t i = 0; i < block.estimate_m.size(); ++i)
    block.estimate_m[i] = static_cast<double>(first * 18 + i) / 7.0;
  for (std::size_t i = 0; i < block.status.size(); ++i) block.status[i] = static_cast<std::uint8_t>(i % 2);
  return block;
}

void write_all(const std::filesystem::path& path, const std::vector<std::uint64_t>& order) {
  SamplesFile samples = SamplesFile::create(path, small_header());
  for (std::uint64_t first : order) samples.write(0, block_of(first, 2));
  samples.write(1, block_of(0, 5));
  samples.write_errors(0, 0, std::vector<float>(10 * 18, 0.25f));
  samples.write_errors(1, 0, std::vector<float>(5 * 18, 0.5f));
}

TEST(Samples, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  write_all(folder / "samples.h5", {0, 2, 4, 6, 8});
  const SamplesFile samples = SamplesFile::open(folder / "samples.h5");
  EXPECT_EQ(samples.header().joints, small_header().joints);
  EXPECT_EQ(samples.header().methods, small_header().methods);
  EXPECT_EQ(samples.header().takes.at(1).id, "two");
  EXPECT_EQ(samples.header().takes.at(0).instants, 10u);
  const SampleBlock block = samples.read(0, 3, 4);
  EXPECT_EQ(block.time_ns, (std::vector<std::int64_t>{3, 4, 5, 6}));
  EXPECT_EQ(block.estimate_m[18], block_of(4, 2).estimate_m[0]);
  EXPECT_TRUE(std::isnan(block.truth_m[0]));
  EXPECT_EQ(samples.read_errors(1, 4, 1), std::vector<float>(18, 0.5f));
}

TEST(Samples, TimesAndStatusesThatNobodyWritesAreRefused) {
  const ScratchFolder folder;
  SampleBlock block = block_of(0, 5);
  block.time_ns[3] = std::numeric_limits<std::int64_t>::min();
  SamplesFile samples = SamplesFile::create(folder / "samples.h5", small_header());
  samples.write(1, block);
  EXPECT_THAT(message_of([&] { samples.read(1, 0, 5); }), HasSubstr("time_ns: holds a time beyond 73 years"));
  block.time_ns[3] = 3;
  block.status[2] = 7;
  samples.write(1, block);
  EXPECT_THAT(message_of([&] { samples.read(1, 0, 5); }), HasSubstr("status: holds the status 7"));
}

TEST(Samples, TheOrderOfWritingDoesNotChangeAByte) {
  const ScratchFolder folder;
  write_all(folder / "forward.h5", {0, 2, 4, 6, 8});
  write_all(folder / "shuffled.h5", {6, 0, 8, 2, 4});
  EXPECT_EQ(read_file(folder / "forward.h5"), read_file(folder / "shuffled.h5"));
}

TEST(Samples, OtherFilesAreRefusedWithTheReason) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { SamplesFile::open(folder / "absent.h5"); }), HasSubstr("absent.h5"));
  write_file(folder / "text.h5", "not HDF5");
  EXPECT_THAT(message_of([&] { SamplesFile::open(folder / "text.h5"); }), HasSubstr("text.h5"));
  write_all(folder / "whole.h5", {0, 2, 4, 6, 8});
  const std::string bytes = read_file(folder / "whole.h5");
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 23) {
    write_file(folder / "cut.h5", bytes.substr(0, size));
    EXPECT_THAT(message_of([&] { SamplesFile::open(folder / "cut.h5").read(0, 0, 10); }),
                HasSubstr("cut.h5"));
  }
}

}  // namespace
}  // namespace trilat
