// SPDX-License-Identifier: MIT
#include "pipeline/sweep/sweep_totals.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "datasets/base/philox.h"
#include "datasets/results/studies/sweep_summary.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// A chunk with sums that no other has.
SweepSums chunk_of(std::uint64_t number) {
  const RandomStream random{1, Purpose::test, number};
  SweepSums sums;
  for (std::uint32_t term = 0; term < SweepSums::kTerms; ++term)
    sums.sum[term] = std::pow(10.0, random.uniform(term, -8.0, 8.0));
  SweepCounts& counts = sums.counts;
  counts.asked = 3;
  counts.statuses[static_cast<std::size_t>(SolveStatus::converged)] = 2;
  counts.statuses[static_cast<std::size_t>(SolveStatus::iteration_limit)] = 1;
  counts.starts = 2;
  counts.max_m = random.uniform(20, 0.0, 9.0);
  for (std::uint32_t i = 0; i < 2; ++i) {
    counts.distance_bins.add(distance_bin(random.uniform(30 + i, 0.0, 9.0)));
    counts.iteration_counts.add(static_cast<std::size_t>(random.uniform(40 + i, 0.0, 20'000.0)));
    sums.add_digits(random.uniform(50 + i, 0.0, 15.0));
  }
  return sums;
}

std::string text_of(const SweepTotals& totals) { return json_of(totals.cell()).dump(); }

SweepTotals read_back(const Json& json) { return read_sweep_totals(JsonObject(json, "sums", "")); }

TEST(SweepTotals, AreTheSameInWhateverOrderAndGroupsChunksAreAdded) {
  constexpr std::uint64_t kChunks = 1000;
  SweepTotals in_order;
  for (std::uint64_t i = 0; i < kChunks; ++i) in_order.add(chunk_of(i));
  for (const std::uint64_t parts : {1u, 3u, 7u, 64u}) {
    std::vector<SweepTotals> groups(parts);
    for (std::uint64_t i = 0; i < kChunks; ++i)
      groups[i * 7 % parts].add(chunk_of(i * 37 % kChunks));  // 37 has no factor in common
    SweepTotals all;
    for (const SweepTotals& group : groups) all.add(read_back(json_of(group)));
    EXPECT_EQ(text_of(all), text_of(in_order)) << parts;
  }
}

TEST(SweepTotals, WhatIsNotFiniteSurvivesTheFile) {
  SweepTotals totals;
  SweepSums sums = chunk_of(1);
  sums.sum[SweepSums::x] = std::numeric_limits<double>::infinity();
  sums.sum[SweepSums::y] = std::nan("");
  sums.counts.max_m = std::numeric_limits<double>::infinity();
  totals.add(sums);
  const SweepTotals again = read_back(json_of(totals));
  EXPECT_TRUE(std::isinf(again.sum[SweepSums::x].value()));
  EXPECT_TRUE(std::isnan(again.sum[SweepSums::y].value()));
  EXPECT_TRUE(std::isinf(again.counts.max_m));
}

TEST(SweepTotals, AFileThatIsNotOursIsRefused) {
  SweepTotals totals;
  totals.add(chunk_of(1));
  const auto refusal = [&](const char* key, const char* value) {
    Json json = json_of(totals);
    json[key] = Json::parse(value);
    return message_of([&] { read_back(json); });
  };
  EXPECT_THAT(refusal("statuses", "[1]"), HasSubstr("/statuses: must be one count a status"));
  EXPECT_THAT(refusal("asked", "4"), HasSubstr("must sum to the trials asked"));
  EXPECT_THAT(refusal("iterations", "[1000000000000, 1]"), HasSubstr("has a value that is too large"));
  EXPECT_THAT(refusal("iterations", "[20000, 1, 1, 1]"), HasSubstr("has a value that is too large"));
  EXPECT_THAT(refusal("distance_bins", "[1, 2, 3]"), HasSubstr("must hold pairs of counts"));
  EXPECT_THAT(refusal("digit_bins", "[-1, 2]"), HasSubstr("must hold pairs of counts"));
  EXPECT_THAT(refusal("sums", "[1.0]"), HasSubstr("must be one list a term"));
  EXPECT_THAT(refusal("max_m", R"("large")"), HasSubstr("must be a number"));
}

}  // namespace
}  // namespace trilat
