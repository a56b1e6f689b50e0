// SPDX-License-Identifier: MIT
#include <algorithm>

#include <gmock/gmock.h>

#include "pipeline/sweep/sweep_part.h"
#include "pipeline/sweep/sweep_stripe.h"
#include "tests/pipeline/swept_folders.h"

namespace trilat {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

// 24 cells of three chunks, the last one not full; searched, timed, and with digits in two chunks of three.
SweepPlan searched_plan() {
  return sweep_plan_of(kOneRig + R"(, "stops": ["objective"], "trials": 17000, "max_iterations": 20,
      "search": true, "time_problems": 5, "time_repeats": 1)");
}

SweepPlan small_plan(const std::string& members = R"("seed": 1)") {
  const std::string thresholds =
      members.find("thresholds") == std::string::npos ? R"("thresholds": [1e-2, 1e-4], )" : "";
  return sweep_plan_of(kOneRig + ", " + thresholds + R"("trials": 30000, "stops": ["objective"],
      "error_ranges_cm": [[5, 15], [0, 5]], "gradients": ["corrected"], )" +
                       members);
}

SweepOutcome merge(const std::vector<fs::path>& parts, const fs::path& output) {
  return merge_sweep(read_parts(parts), output, {});
}

TEST(SweepStripe, EveryChunkIsOneShardsAndSharesOfACellDifferByOneAtMost) {
  for (const std::uint64_t shards : {1u, 2u, 7u, 12u, 64u})
    for (const std::uint64_t chunks : {0u, 1u, 5u, 64u, 1000u}) {
      std::vector<std::uint64_t> owner(chunks, 0);
      for (std::uint64_t number = 1; number <= shards; ++number) {
        const SweepStripe stripe{{number, shards}, chunks};
        for (std::uint64_t turn = 0; turn < stripe.turns(); ++turn) {
          const std::uint64_t chunk = stripe.chunk(turn);
          ASSERT_LT(chunk, chunks);
          ASSERT_EQ(owner[chunk], 0u);
          owner[chunk] = number;
          ASSERT_EQ(stripe.turns_before(chunk), turn);
          ASSERT_EQ(stripe.turns_before(chunk + 1), turn + 1);
        }
      }
      EXPECT_EQ(std::count(owner.begin(), owner.end(), 0u), 0);
      for (std::uint64_t begin = 0; begin + shards <= chunks; begin += shards)
        for (std::uint64_t number = 1; number <= shards; ++number)
          ASSERT_EQ(std::count(owner.begin() + static_cast<std::ptrdiff_t>(begin),
                               owner.begin() + static_cast<std::ptrdiff_t>(begin + shards), number),
                    1);
    }
}

// Cells of one chunk each, a thousand times dearer at every twelfth: no shard gets only those.
TEST(SweepStripe, SharesEvenlyWhatRepeatsAsOftenAsThereAreShards) {
  std::vector<std::uint64_t> dear(12, 0);
  for (std::uint64_t number = 1; number <= 12; ++number) {
    const SweepStripe stripe{{number, 12}, 12 * 120};
    for (std::uint64_t turn = 0; turn < stripe.turns(); ++turn)
      dear[number - 1] += stripe.chunk(turn) % 12 == 11;
  }
  EXPECT_LE(*std::max_element(dear.begin(), dear.end()), 12u);  // 10 are fair
  EXPECT_GE(*std::min_element(dear.begin(), dear.end()), 8u);
}

TEST(SweepShards, MergedAreTheBytesOfOneRun) {
  const ScratchFolder folder;
  const SweepPlan plan = searched_plan();
  execute_sweep(plan, folder / "one", {});
  for (const std::uint64_t shards : {1u, 2u, 7u, 64u}) {
    std::vector<fs::path> parts = run_shards(plan, folder, shards);
    std::reverse(parts.begin(), parts.end());
    const fs::path merged = folder / ("merged" + std::to_string(shards));
    const SweepOutcome outcome = merge(parts, merged);
    expect_same_sweeps(folder / "one", merged);
    EXPECT_TRUE(outcome.summary.search);
    EXPECT_EQ(read_file(merged / "timings.json"), read_file(parts.back() / "timings.json"));
    EXPECT_EQ(fs::exists(parts.front() / "timings.json"), shards == 1);
    EXPECT_FALSE(fs::exists(merged / SweepLog::kFinished));
  }
}

TEST(SweepShards, AShardThatWasKilledGoesOnToTheSameBytes) {
  const ScratchFolder folder;
  const SweepPlan plan = searched_plan();
  execute_sweep(plan, folder / "one", {});
  const fs::path second = part_folder(folder, {2, 2});
  ExecuteSweepOptions options{.threads = 2, .work = {{2, 2}, {}}, .save_every_s = 0.0};
  run_and_drop(plan, second, options, 0.8);
  EXPECT_FALSE(fs::exists(second));
  EXPECT_THAT(message_of([&] { read_parts(std::vector{second}); }), HasSubstr("is not finished yet"));
  run_and_drop(plan, second, options, 0.9);
  const SweepOutcome outcome = execute_sweep(plan, second, options);
  EXPECT_FALSE(outcome.tally.continued.empty());
  EXPECT_FALSE(outcome.tally.computed.empty());
  EXPECT_EQ(outcome.tally.all(), 24u);
  merge(run_shards(plan, folder, 2), folder / "merged");  // the second finds its part done
  expect_same_sweeps(folder / "one", folder / "merged");
}

TEST(SweepShards, AShardThatIsDoneIsLeftAlone) {
  const ScratchFolder folder;
  const SweepPlan plan = small_plan();
  const ExecuteSweepOptions options{.work = {{2, 3}, {}}};
  EXPECT_FALSE(execute_sweep(plan, folder / "part", options).unchanged);
  EXPECT_TRUE(execute_sweep(plan, folder / "part", options).unchanged);
  EXPECT_FALSE(execute_sweep(plan, folder / "part", {.work = {{1, 3}, {}}}).unchanged);
  EXPECT_FALSE(execute_sweep(small_plan(R"("seed": 2)"), folder / "part", options).unchanged);
}

// Each refusal is one line that names the folder.
TEST(SweepShards, PartsThatDoNotMakeOneSweepAreRefused) {
  const ScratchFolder folder;
  const std::vector<fs::path> parts = run_shards(small_plan(), folder, 3);
  const auto refusal = [&](std::vector<fs::path> given) {
    return message_of([&] { merge(given, folder / "merged"); });
  };
  EXPECT_THAT(refusal({parts[0], parts[2]}), HasSubstr("missing: shard 2/3"));
  EXPECT_THAT(refusal({parts[0], parts[1], parts[1], parts[2]}), HasSubstr("is shard 2/3, which"));
  const auto other = [&](const std::string& name, const SweepPlan& plan, std::uint64_t of) {
    execute_sweep(plan, folder / name, {.work = {{2, of}, {}}});
    return refusal({parts[0], folder / name, parts[2]});
  };
  EXPECT_THAT(other("seed", small_plan(R"("seed": 2)"), 3),
              HasSubstr("/study/seed is 1 in the first and 2 here"));
  EXPECT_THAT(other("study", small_plan(R"("max_iterations": 5)"), 3), HasSubstr("/study/max_iterations"));
  EXPECT_THAT(other("of", small_plan(), 4), HasSubstr("it is shard 2/4, the first is 1/3"));
  EXPECT_FALSE(fs::exists(folder / "merged"));
}

TEST(SweepShards, AnotherProgramsOrADamagedPartIsRefused) {
  const ScratchFolder folder;
  const std::vector<fs::path> parts = run_shards(small_plan(), folder, 2);
  const std::string text = read_file(parts[1] / SweepLog::kFinished);
  const auto refusal_of = [&](const std::string& sums) {
    write_file(parts[1] / SweepLog::kFinished, sums);
    return message_of([&] { merge(parts, folder / "merged"); });
  };
  std::string damaged = text;
  damaged[text.size() / 2] = '~';
  EXPECT_THAT(refusal_of(damaged), HasSubstr("is damaged; remove this part and run its shard again"));
  EXPECT_THAT(refusal_of(text.substr(0, text.size() - 1)), HasSubstr("is damaged"));
  const std::size_t last = text.rfind('\n', text.size() - 2) + 1;
  EXPECT_THAT(refusal_of(text.substr(0, last)), HasSubstr("0 to 0.05 m is missing"));
  EXPECT_THAT(refusal_of(text.substr(last) + text), HasSubstr("is missing"));
  EXPECT_THAT(refusal_of(text + text.substr(last)), HasSubstr("holds more than the cells of its shard"));
  EXPECT_THAT(refusal_of(read_file(parts[0] / SweepLog::kFinished)), HasSubstr("is missing"));
  EXPECT_THAT(refusal_of(""), HasSubstr("is missing"));
  EXPECT_FALSE(fs::exists(folder / "merged"));
  EXPECT_EQ(refusal_of(text), "no error");
}

TEST(SweepShards, ThePlanSurvivesThePartToTheBit) {
  const SweepPlan plan = sweep_plan_of(R"("rigs": [{"name": "a", "sensors_m": [[0.1, 0.30000000000000004, 0],
      [3.3333333333333335, 1.5, 1e-17], [0, 2, 3], [3, 0.5, 3.1]]}], "thresholds": [0.1234567890123456789],
      "error_ranges_cm": [[7, 12.345678901234567]], "trials": 10, "seed": 18446744073709551615)");
  const SweepPlan again = plan_of(part_of(plan, {1, 2}), "part.json");
  EXPECT_EQ(part_of(again, {1, 2}).work, part_of(plan, {1, 2}).work);
  EXPECT_EQ(again.spec.ranges[0].high_m, plan.spec.ranges[0].high_m);
  EXPECT_EQ(again.spec.rigs[0].sensors_m, plan.spec.rigs[0].sensors_m);
  EXPECT_EQ(again.spec.seed, plan.spec.seed);
}

TEST(SweepShards, TakeOverEarlierCellsTogetherOrNotAtAll) {
  const ScratchFolder folder;
  execute_sweep(small_plan(R"("thresholds": [1e-2])"), folder / "earlier", {});
  execute_sweep(small_plan(), folder / "one", {});
  ExecuteSweepOptions options;
  options.work.reuse = {folder / "earlier"};
  const std::vector<fs::path> parts = run_shards(small_plan(), folder, 3, options);
  merge(parts, folder / "merged");
  expect_same_sweeps(folder / "one", folder / "merged");
  execute_sweep(small_plan(), parts[1], {.work = {{2, 3}, {}}, .fresh = true});
  EXPECT_THAT(message_of([&] { merge(parts, folder / "mixed"); }),
              HasSubstr("give all shards the same --reuse"));
}

}  // namespace
}  // namespace trilat
