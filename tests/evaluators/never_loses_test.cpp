// SPDX-License-Identifier: MIT
// Ceres, from our starts, never ends lower than we do.
#include <gmock/gmock.h>

#include "tests/evaluators/duel.h"
#include "tests/support/trials.h"

namespace trilat {
namespace {

constexpr std::uint64_t kSeed = 1;

class NeverLoses : public testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Quarter, NeverLoses, testing::Range<std::uint64_t>(0, 4));

TEST_P(NeverLoses, AgainstCeresFromTheSameStarts) {
  const std::uint64_t problems = trials(25'000), first = GetParam() * problems;
  const DuelTallies tallies = tally_duels(kSeed, first, first + problems);
  for (std::size_t kind = 0; kind < tallies.size(); ++kind) {
    tallies[kind].print(kDuelNames[kind]);
    EXPECT_THAT(tallies[kind].lost, testing::IsEmpty()) << kDuelNames[kind];
    EXPECT_THAT(tallies[kind].dishonest, testing::IsEmpty()) << kDuelNames[kind];
    EXPECT_GT(tallies[kind].statuses[static_cast<std::size_t>(SolveStatus::converged)], problems / 2);
  }
}

// 1e-7 m out of one plane, yet the two sides differ by more than rounding.
TEST(AlmostOnePlane, OfSensorsStillHasALowerSide) {
  const auto duel = duels(hard_problem(2, 426264));
  EXPECT_FALSE(duel[0].lost());
  EXPECT_FALSE(duel[1].lost());
}

TEST(NonlinearSpan, GivesTheBitsOfOneProblemAtATime) {
  std::vector<RangeProblem> problems;
  for (std::uint64_t i = 0; i < 5'000; ++i) problems.push_back(hard_problem(kSeed, i));
  std::vector<PointEstimate> estimates(problems.size());
  for (const Curvature curvature : {Curvature::gauss_newton, Curvature::newton}) {
    NonlinearOptions options;
    options.curvature = curvature;
    solve_nonlinear(problems, options, estimates);
    for (std::size_t i = 0; i < problems.size(); ++i) {
      const PointEstimate one = solve_nonlinear(problems[i], options);
      ASSERT_EQ(one.status, estimates[i].status) << i;
      ASSERT_EQ(one.iterations, estimates[i].iterations) << i;
      if (!one.position_m.allFinite()) continue;
      ASSERT_EQ(one.position_m, estimates[i].position_m) << i;
      ASSERT_EQ(one.cost_m2, estimates[i].cost_m2) << i;
    }
  }
}

}  // namespace
}  // namespace trilat
