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

// File names and asset names come from outside and need not be UTF-8.
TEST(Summary, ANoteThatIsNotUtf8IsStillWritten) {
  const ScratchFolder folder;
  ResultsSummary summary;
  summary.alignments = {"mean"};
  summary.notes = {{"a", true, "a.csv", "it holds marker:T\xeate"}};
  write_summary(folder.path(), summary);
  EXPECT_THAT(read_summary(folder.path()).notes.at(0).text, HasSubstr("marker:T"));
}

SamplesHeader small_header() {
  return {{"head", "neck"},         {"mean", "nonlinear", "linear"}, {"a", "b"}, "mean", 0.5,
          {{"one", 10}, {"two", 5}}};
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
  EXPECT_EQ(samples.header().training_share, 0.5);
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
