// SPDX-License-Identifier: MIT
#include "datasets/results/stored_take.h"

#include <cmath>

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "datasets/hdf5/hdf5_file.h"
#include "datasets/results/summary.h"
#include "datasets/rig/skeleton.h"
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
  write_results(folder.path(), summary);
  EXPECT_THAT(read_results<ResultsSummary>(folder.path()).notes.at(0).text, HasSubstr("marker:T"));
}

TakeHead small_head() {
  return {"one",
          "walking",
          10,
          {"head", "neck"},
          {"mean", "nonlinear", "linear"},
          {"k1", "k2"},
          {"a", "b"},
          true,
          {{0.1, 0.2, 0.3}, {1.0, 2.0, 3.0}}};
}

SampleBlock block_of(std::uint64_t first, std::uint64_t count) {
  SampleBlock block;
  block.reset(first, count, 2, 3);
  for (std::uint64_t i = 0; i < count; ++i) block.time_ns[i] = static_cast<std::int64_t>(first + i);
  for (std::size_t i = 0; i < block.estimate_m.size(); ++i)
    block.estimate_m[i] = static_cast<float>(first * 18 + i) / 7.0F;
  for (std::size_t i = 0; i < block.status.size(); ++i) block.status[i] = static_cast<std::uint8_t>(i % 2);
  return block;
}

// A row of which every number is another.
template <class Row>
Row filled_row() {
  Row row;
  std::uint32_t count = 0;
  double sum = 0.5;
  const auto fill = [&](auto& number) {
    if constexpr (std::is_same_v<std::decay_t<decltype(number)>, double>)
      number = sum++;
    else
      number = ++count;
  };
  Row::fields(row, EachField{[&](const char*, auto& member) {
                if constexpr (requires { member.size(); })
                  for (auto& number : member) fill(number);
                else
                  fill(member);
              }});
  return row;
}

// The places that a row names are those of small_head().
template <class Row>
Row placed_row() {
  Row row = filled_row<Row>();
  if constexpr (requires { row.quantity; }) row.quantity = 3;
  if constexpr (requires { row.method; }) row.method = 2;
  if constexpr (requires { row.alignment; }) row.alignment = 0;
  if constexpr (requires { row.subset; }) row.subset = 1;
  if constexpr (requires { row.measure; }) row.measure = 1;
  if constexpr (requires { row.test; }) row.test = 1;
  return row;
}

TakeErrors small_table() {
  TakeErrors table;
  table.settings_sha256 = "00ff";
  table.alignments = {"mean"};
  table.quantities = {"head", "neck", "head", "neck", "body"};
  table.laid_over = {placed_row<AlignmentRow>(), {}};
  table.sums = {placed_row<ErrorSums>()};
  table.sums[0].method = 3;     // the truth
  table.sums[0].alignment = 1;  // before any
  table.ended = {};             // an empty table comes back empty
  table.histograms = {placed_row<HistogramRow>()};
  table.bins.resize(table.histograms[0].bins, placed_row<BinRow>());
  return table;
}

void write_all(const std::filesystem::path& path, const std::vector<std::uint64_t>& order,
               const TakeErrors& table = small_table()) {
  StoredTake take = StoredTake::create(path, small_head());
  for (std::uint64_t first : order)
    for (std::size_t track = 0; track < 2; ++track) take.write(track, block_of(first, 2));
  take.write_errors(table);
  take.finish();
}

template <class Row>
std::string text_of(const std::vector<Row>& rows) {
  return json_of(rows).dump();
}

TEST(StoredTake, WhatIsWrittenIsReadBack) {
  const ScratchFolder folder;
  write_all(folder / "take.h5", {0, 2, 4, 6, 8});
  const StoredTake take = StoredTake::open(folder / "take.h5");
  EXPECT_EQ(take.head().joints, small_head().joints);
  EXPECT_EQ(take.head().methods, small_head().methods);
  EXPECT_EQ(take.head().condition, "walking");
  EXPECT_EQ(take.head().instants, 10u);
  const SampleBlock block = take.read(0, 3, 4, SampleColumns::all);
  EXPECT_EQ(block.time_ns, (std::vector<std::int64_t>{3, 4, 5, 6}));
  EXPECT_EQ(block.estimate_m[18], block_of(4, 2).estimate_m[0]);
  EXPECT_TRUE(std::isnan(block.truth_m[0]));
  const TakeErrors there = take.read_errors(), wanted = small_table();
  EXPECT_EQ(there.settings_sha256, wanted.settings_sha256);
  EXPECT_EQ(there.alignments, wanted.alignments);
  EXPECT_EQ(text_of(there.laid_over), text_of(wanted.laid_over));
  EXPECT_EQ(there.quantities, wanted.quantities);
  EXPECT_EQ(text_of(there.sums), text_of(wanted.sums));
  EXPECT_EQ(text_of(there.histograms), text_of(wanted.histograms));
  EXPECT_EQ(text_of(there.bins), text_of(wanted.bins));
  EXPECT_TRUE(there.ended.empty());
  EXPECT_EQ(take.head().track_position_m, small_head().track_position_m);
  EXPECT_TRUE(take.head().is_upright);
}

TEST(StoredTake, TimesAndStatusesThatNobodyWritesAreRefused) {
  const ScratchFolder folder;
  SampleBlock block = block_of(0, 5);
  block.time_ns[3] = std::numeric_limits<std::int64_t>::min();
  StoredTake take = StoredTake::create(folder / "take.h5", small_head());
  take.write(1, block);
  const auto read = [&] { take.read(1, 0, 5, SampleColumns::errors); };
  EXPECT_THAT(message_of(read), HasSubstr("time_ns: holds a time beyond 73 years"));
  block.time_ns[3] = 3;
  block.status[2] = 7;
  take.write(1, block);
  EXPECT_THAT(message_of(read), HasSubstr("status: holds the status 7"));
}

TEST(StoredTake, RowsOfWhatTheTakeHasNotAreRefused) {
  const ScratchFolder folder;
  const auto refused = [&](const auto& change, const char* what) {
    TakeErrors table = small_table();
    change(table);
    write_all(folder / "wrong.h5", {0}, table);
    EXPECT_THAT(message_of([&] { StoredTake::open(folder / "wrong.h5").read_errors(); }), HasSubstr(what));
  };
  refused([](TakeErrors& t) { t.sums[0].method = 4; }, "sums: has a row of");
  refused([](TakeErrors& t) { t.sums[0].alignment = 2; }, "sums: has a row of");
  refused([](TakeErrors& t) { t.sums[0].measure = kMeasureNames.size(); }, "sums: has a row of");
  refused([](TakeErrors& t) { t.histograms[0].method = 3; }, "histograms: has a row of");
  refused([](TakeErrors& t) { t.laid_over[0].quantity = 5; }, "laid_over: has a row of");
  refused([](TakeErrors& t) { t.quantities.resize(3); }, "names fewer quantities");
  TakeErrors table = small_table();
  table.bins[0].bin = kLastBin + 1;
  write_all(folder / "bins.h5", {0}, table);
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "bins.h5").read_errors(); }), HasSubstr("bins"));
}

TEST(StoredTake, EqualTakesGiveEqualBytes) {
  const ScratchFolder folder;
  write_all(folder / "a.h5", {0, 2, 4, 6, 8});
  write_all(folder / "b.h5", {0, 2, 4, 6, 8});
  EXPECT_TRUE(read_file(folder / "a.h5") == read_file(folder / "b.h5"));
}

TEST(StoredTake, OtherFilesAreRefusedWithTheReason) {
  const ScratchFolder folder;
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "absent.h5"); }), HasSubstr("absent.h5"));
  write_file(folder / "text.h5", "not HDF5");
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "text.h5"); }), HasSubstr("text.h5"));
  H5File file = H5File::create(folder / "newer.h5");
  file.set_text("format", "trilat.take");
  file.set_integer("version", 99);
  file.close();
  EXPECT_THAT(message_of([&] { StoredTake::open(folder / "newer.h5"); }),
              HasSubstr("newer.h5: is another version; this program reads version 4"));
  write_all(folder / "whole.h5", {0, 2, 4, 6, 8});
  const std::string bytes = read_file(folder / "whole.h5");
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 23) {
    write_file(folder / "cut.h5", bytes.substr(0, size));
    EXPECT_THAT(message_of([&] {
                  const StoredTake take = StoredTake::open(folder / "cut.h5");
                  take.read(1, 0, 10, SampleColumns::all);
                  take.read_errors();
                }),
                HasSubstr("cut.h5"));
  }
}

}  // namespace
}  // namespace trilat
