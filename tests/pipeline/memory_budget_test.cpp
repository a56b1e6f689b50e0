// SPDX-License-Identifier: MIT
#include "pipeline/accuracy/memory_budget.h"

#include <gmock/gmock.h>

#include "datasets/base/files.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "tests/pipeline/campaigns.h"
#include "tests/pipeline/program.h"
#include "tests/pipeline/same_results.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kManyMethods =
    R"("methods": [{"method": "nonlinear"}, {"method": "rts"}, {"method": "mean"}])";

PlannedTake take_of(std::uint64_t instants) {
  PlannedTake take;
  take.ok = true;
  take.instants = instants;
  return take;
}

// Takes that need 1, 5 and 2 parts of memory beside what any take needs.
Plan three_takes() {
  Plan plan;
  plan.rig = {"k1", "k2"};
  plan.joints = {Joint::head};
  for (const std::uint64_t parts : {1, 5, 2}) plan.takes.push_back(take_of(parts * 100'000));
  return plan;
}

TEST(MemoryBudget, ATakesNeedGrowsWithItsInstantsSensorsAndJoints) {
  Plan plan = three_takes();
  const auto need = [&] { return memory_needed_bytes(plan, plan.takes[0]); };
  const std::uint64_t before = need();
  EXPECT_GT(memory_needed_bytes(plan, plan.takes[1]), 2 * before - before / 2);
  plan.rig.push_back("k3");
  const std::uint64_t with_another = need();
  EXPECT_GT(with_another, before);
  plan.joints.push_back(Joint::wrist_left);
  EXPECT_GT(need(), with_another);
}

TEST(MemoryBudget, AsManyTakesGoAtOnceAsFitWhicheverTheyAre) {
  const Plan plan = three_takes();
  const std::uint64_t small = memory_needed_bytes(plan, plan.takes[0]),
                      large = memory_needed_bytes(plan, plan.takes[1]),
                      middle = memory_needed_bytes(plan, plan.takes[2]);
  EXPECT_EQ(takes_at_once(plan, small + middle + large), 3u);
  EXPECT_EQ(takes_at_once(plan, small + middle + large - 1), 2u);
  EXPECT_EQ(takes_at_once(plan, middle + large - 1), 1u);
  EXPECT_EQ(takes_at_once(plan, middle + small), 2u) << "the large one is refused and takes nothing";
  EXPECT_EQ(takes_at_once(plan, 1), 1u);
}

TEST(MemoryBudget, ATakeThatNeedsMoreThanThereIsIsRefusedWithTheOption) {
  const Plan plan = three_takes();
  const std::uint64_t need = memory_needed_bytes(plan, plan.takes[1]);
  EXPECT_EQ(message_of([&] { check_memory(plan, plan.takes[1], need); }), "no error");
  EXPECT_THAT(message_of([&] { check_memory(plan, plan.takes[1], need - 1); }), HasSubstr("--memory-mb "));
}

TEST(MemoryBudget, TheMachineHasSome) { EXPECT_GT(half_of_memory_bytes(), 1'000'000u); }

TEST(MemoryBudget, OnlyTheTakeThatIsTooLongFails) {
  const ScratchFolder folder;
  SimulationSpec spec = walking_spec(1);
  spec.activities.push_back({Activity::arm_swing, 20.0, {Joint::wrist_left}});
  const Campaign campaign = simulate_into(folder / "campaign", spec);
  const StudySpec study = study_of(kManyMethods);
  const Plan plan = make_plan(study, campaign);
  ASSERT_EQ(plan.takes.size(), 2u);
  const std::uint64_t enough = memory_needed_bytes(plan, plan.takes[0]);
  ASSERT_LT(enough, memory_needed_bytes(plan, plan.takes[1]));
  const ResultsSummary summary = execute_study(study, campaign, folder / "results", {.memory_bytes = enough});
  EXPECT_EQ(summary.takes_failed, 1u);
  ASSERT_FALSE(summary.notes.empty());
  EXPECT_TRUE(summary.notes.back().failed);
  EXPECT_THAT(summary.notes.back().text, HasSubstr("of memory to evaluate"));
}

TEST(MemoryBudget, TheVerbsTakeTheLimitInMegabytes) {
  const ScratchFolder folder;
  simulate_into(folder / "campaign", walking_spec(1));
  const std::string study = file_with(
      folder, "study.json",
      std::string(R"({"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "mine", )") +
          kManyMethods + "}");
  const auto run = [&](const std::string& output, const std::string& megabytes,
                       std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", study, "--campaign", (folder / "campaign").string(), "-o",
                               (folder / output).string(), "--memory-mb", megabytes});
    return run_trilat(folder, more);
  };
  const Ended refused = run("results", "1");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("more than the 1 MB allowed"), HasSubstr("--memory-mb")));
  EXPECT_EQ(run("results", "2000").code, 0);
}

}  // namespace
}  // namespace trilat
