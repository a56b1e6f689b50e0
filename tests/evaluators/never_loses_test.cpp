// SPDX-License-Identifier: MIT
// Ceres, from our starts, never ends lower than we do. tests/benchmarks/never_loses runs ten times as many.
#include <gmock/gmock.h>

#include "tests/evaluators/duel.h"

namespace trilat {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::uint64_t kProblems = 25'000;

class NeverLoses : public testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Quarter, NeverLoses, testing::Range<std::uint64_t>(0, 4));

TEST_P(NeverLoses, AgainstCeresFromTheSameStarts) {
  const std::uint64_t first = GetParam() * kProblems;
  const DuelTallies tallies = tally_duels(kSeed, first, first + kProblems);
  for (std::size_t kind = 0; kind < tallies.size(); ++kind) {
    tallies[kind].print(kDuelNames[kind]);
    EXPECT_THAT(tallies[kind].lost, testing::IsEmpty()) << kDuelNames[kind];
    EXPECT_THAT(tallies[kind].dishonest, testing::IsEmpty()) << kDuelNames[kind];
    EXPECT_GT(tallies[kind].statuses[static_cast<std::size_t>(SolveStatus::converged)], kProblems / 2);
  }
}

}  // namespace
}  // namespace trilat
