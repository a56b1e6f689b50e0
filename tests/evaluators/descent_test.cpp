// SPDX-License-Identifier: MIT
// One descent, and many by vectors: the same bits by every instruction set, every width and every way in, and
// what the settings promise.
#include "evaluators/solvers/descent.h"

#include <cmath>
#include <cstring>
#include <map>

#include <gmock/gmock.h>
#include <hwy/targets.h>

#include "datasets/base/error.h"
#include "evaluators/solvers/nonlinear.h"
#include "evaluators/solvers/range_lanes.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

struct Setting {
  const char* name;
  NonlinearOptions options;
};
void PrintTo(const Setting& setting, std::ostream* out) { *out << setting.name; }

NonlinearOptions with(Gradient gradient, Damping damping, StopRule stop, Curvature curvature) {
  NonlinearOptions options;
  options.gradient = gradient;
  options.damping = damping;
  options.stop = stop;
  options.curvature = curvature;
  return options;
}

std::vector<Setting> settings() {
  using enum Gradient;
  using enum Curvature;
  return {{"printed", with(printed, Damping::none, StopRule::objective, gauss_newton)},
          {"as_printed", with(printed, Damping::none, StopRule::printed, gauss_newton)},
          {"undamped", with(corrected, Damping::none, StopRule::step, gauss_newton)},
          {"lm", with(corrected, Damping::lm, StopRule::step, gauss_newton)},
          {"lm_objective", with(corrected, Damping::lm, StopRule::objective, gauss_newton)},
          {"newton", with(corrected, Damping::lm, StopRule::step, newton)}};
}

std::vector<Setting> undamped_settings() {
  std::vector<Setting> undamped = settings();
  std::erase_if(undamped, [](const Setting& s) { return s.options.damping != Damping::none; });
  return undamped;
}

// Three to eight sensors, level, nearly level or not, errors up to 30 cm,
// and some that are refused.
RangeProblem mixed_problem(std::uint32_t item) {
  const RandomStream random{11, Purpose::test, item};
  const int count = 3 + static_cast<int>(item % 6);
  const double spread_m = std::array{0.0, 1e-3, 0.05, 1.0}[item % 4];
  std::vector<Vector3d> sensors_m;
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283 * (i + 0.5 * random.uniform(10 + i)) / count;
    sensors_m.emplace_back(2 * std::cos(angle), 1.0 + spread_m * random.uniform(20 + i), 2 * std::sin(angle));
  }
  RangeProblem problem = problem_of(sensors_m, random_joint_m(random, 0));
  for (int i = 0; i < count; ++i) {
    problem.range_m[i] = std::abs(problem.range_m[i] + random.uniform(30 + i, -0.3, 0.3));
  }
  if (item % 97 == 0) problem.range_m[1] = kNaN;
  if (item % 89 == 0) problem.count = 2;
  return problem;
}

// Problems of one rig, whose ranges are 10 cm too long and too short in turn.
std::vector<RangeProblem> sharing_a_rig(int sensors, std::size_t count) {
  RangeProblem rig;
  rig.count = sensors;
  for (int k = 0; k < sensors; ++k) {
    const double angle = 6.283 * k / sensors;
    rig.sensor_m[k] = {2 * std::cos(angle), k % 2 == 0 ? 0.3 : 2.3, 2 * std::sin(angle)};
  }
  std::vector<RangeProblem> problems;
  for (std::uint32_t i = 0; i < count; ++i) {
    RangeProblem& problem = problems.emplace_back(rig);
    const Vector3d truth_m = random_joint_m({29, Purpose::test, 0}, i);
    for (int k = 0; k < sensors; ++k)
      problem.range_m[k] = std::max(0.0, (truth_m - problem.sensor_m[k]).norm() + (k % 2 == 0 ? 0.1 : -0.1));
  }
  return problems;
}

std::vector<RangeProblem> mixed_problems(std::uint32_t count) {
  std::vector<RangeProblem> problems;
  for (std::uint32_t i = 0; i < count; ++i) problems.push_back(mixed_problem(i));
  return problems;
}

// Equal bits, where two NaN count as equal.
bool is_same_number(double x, double y) {
  return std::memcmp(&x, &y, sizeof x) == 0 || (std::isnan(x) && std::isnan(y));
}

bool same(const PointEstimate& a, const PointEstimate& b) {
  bool result = a.status == b.status && a.iterations == b.iterations &&
                is_same_number(a.cost_m2, b.cost_m2) && is_same_number(a.gdop, b.gdop);
  for (int axis = 0; axis < 3; ++axis)
    result = result && is_same_number(a.position_m[axis], b.position_m[axis]);
  return result;
}

// Allows one instruction set only while it lives.
class OnlyTarget {
 public:
  explicit OnlyTarget(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
  }
  OnlyTarget(const OnlyTarget&) = delete;
  OnlyTarget& operator=(const OnlyTarget&) = delete;
  ~OnlyTarget() {
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
};

class EverySetting : public testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Descent, EverySetting, testing::ValuesIn(settings()),
                         [](const auto& setting) { return std::string(setting.param.name); });

class EveryUndampedSetting : public testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Descent, EveryUndampedSetting, testing::ValuesIn(undamped_settings()),
                         [](const auto& setting) { return std::string(setting.param.name); });

TEST_P(EverySetting, ManyProblemsGiveTheBitsOfOneAtATime) {
  const std::vector<RangeProblem> problems = mixed_problems(1500);
  std::vector<PointEstimate> together(problems.size());
  solve_nonlinear(problems, GetParam().options, together);
  int usable = 0;
  for (std::size_t i = 0; i < problems.size(); ++i) {
    const PointEstimate alone = solve_nonlinear(problems[i], GetParam().options);
    ASSERT_TRUE(same(alone, together[i]))
        << i << ": " << name_of(alone.status) << " " << alone.position_m.transpose() << " against "
        << name_of(together[i].status) << " " << together[i].position_m.transpose();
    usable += is_usable(alone.status);
  }
  EXPECT_GT(usable, 200);
}

TEST_P(EverySetting, EveryInstructionSetGivesTheSameBits) {
  const std::vector<RangeProblem> problems = mixed_problems(600);
  std::vector<PointEstimate> expected(problems.size()), found(problems.size());
  solve_nonlinear(problems, GetParam().options, expected);
  int targets = 0;
  for (std::int64_t left = hwy::SupportedTargets() & (HWY_SSE4 | HWY_AVX2 | HWY_AVX3 | HWY_SCALAR); left != 0;
       left &= left - 1) {
    const std::int64_t target = left & -left;
    const OnlyTarget only(target);
    solve_nonlinear(problems, GetParam().options, found);
    for (std::size_t i = 0; i < problems.size(); ++i)
      ASSERT_TRUE(same(expected[i], found[i])) << hwy::TargetName(target) << " problem " << i;
    ++targets;
  }
  if (targets < 2) GTEST_SKIP() << "this processor has one instruction set only";
}

Descent lane_of(const RangeLanes& lanes, std::size_t lane) {
  return {lanes.position_m.position(lane), lanes.status[lane],
          static_cast<int>(lanes.iterations.row(0)[lane]), kNaN};
}

// Lanes that end take other problems, or wait; ends of all kinds, one after the other and beside each other.
TEST_P(EveryUndampedSetting, EachLaneEndsAsTheScalarDescent) {
  NonlinearOptions options = GetParam().options;
  std::map<SolveStatus, int> seen;
  for (const int sensors : {3, 4, 5, 8}) {
    for (const std::size_t count : {1u, 7u, 8u, 61u}) {
      options.max_iterations = count == 61 ? 200 : 3000;
      std::vector<RangeProblem> problems = sharing_a_rig(sensors, count);
      if (count == 61) problems[17].range_m[1] = kNaN;
      RangeLanes lanes({problems[0].sensor_m.data(), static_cast<std::size_t>(sensors)}, count);
      std::vector<Vector3d> start_m;
      for (std::size_t lane = 0; lane < count; ++lane) {
        const RandomStream random{31, Purpose::test, static_cast<std::uint32_t>(lane)};
        const double far = lane % 9 == 4 ? 1e160 : 1.0;  // whose square is infinite
        start_m.push_back(far * random_joint_m({29, Purpose::test, 0}, static_cast<std::uint32_t>(lane)));
        start_m.back().x() += random.uniform(0, 0.0, 0.05);
        if (lane % 11 == 3) start_m.back() = problems[0].sensor_m[0] + Vector3d(0.5, 0.0, 0.5);
        lanes.position_m.set_position(lane, start_m.back());
        for (std::size_t i = 0; i < static_cast<std::size_t>(sensors); ++i)
          lanes.range_m.row(i)[lane] = problems[lane].range_m[i];
      }
      descend(lanes, options);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Descent expected = descend(problems[lane], start_m[lane], options);
        const Descent found = lane_of(lanes, lane);
        ASSERT_EQ(found.status, expected.status) << sensors << " sensors, lane " << lane << " of " << count;
        ASSERT_EQ(found.iterations, expected.iterations) << sensors << " sensors, lane " << lane;
        for (int axis = 0; axis < 3; ++axis)
          ASSERT_TRUE(is_same_number(found.position_m[axis], expected.position_m[axis])) << lane;
        ++seen[found.status];
      }
    }
  }
  EXPECT_GT(seen[SolveStatus::converged], 20);
  EXPECT_GT(seen[SolveStatus::diverged], 20);
}

std::vector<RangeProblem> ring_problems(std::size_t count) {
  std::vector<RangeProblem> problems;
  for (std::uint32_t i = 0; i < count; ++i) {
    problems.push_back(problem_of(well_posed_sensors_m(), random_joint_m({7, Purpose::test, 0}, i)));
    add_noise(problems.back(), RandomStream{8, Purpose::test, i}, 0.05);
  }
  return problems;
}

struct HardCase {
  const char* name;
  RangeProblem problem;
  SolveStatus damped;  // how the default ends
};

std::vector<HardCase> hard_cases() {
  const Vector3d joint_m(0.2, 1.1, -0.3);
  const auto four = [&](const std::vector<Vector3d>& sensors_m) { return problem_of(sensors_m, joint_m); };
  const auto with = [](RangeProblem problem, const auto& change) {
    change(problem);
    return problem;
  };
  const RangeProblem good = four(well_posed_sensors_m());
  const RangeProblem level = four({{2, 1, 0}, {-2, 1, 0}, {0, 1, 2}, {0, 1, -2}});
  return {
      {"one_place", four(std::vector<Vector3d>(4, {1, 1, 1})), SolveStatus::rank_deficient},
      {"on_a_line", four({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {4, 4, 4}}), SolveStatus::rank_deficient},
      {"in_a_plane_both_sides_right", level, SolveStatus::mirror_ambiguous},
      {"in_a_plane_with_a_hint", with(level, [&](RangeProblem& p) { p.guess_m = joint_m; }),
       SolveStatus::converged},
      {"ranges_of_zero", with(good, [](RangeProblem& p) { p.range_m.fill(0.0); }), SolveStatus::converged},
      {"one_gross_outlier", with(good, [](RangeProblem& p) { p.range_m[2] *= 4.0; }), SolveStatus::converged},
      {"nan", with(good, [](RangeProblem& p) { p.range_m[1] = kNaN; }), SolveStatus::non_finite_input},
      {"negative", with(good, [](RangeProblem& p) { p.range_m[1] = -1.0; }), SolveStatus::invalid_input},
      {"two_sensors", with(good, [](RangeProblem& p) { p.count = 2; }), SolveStatus::too_few_ranges},
      {"good", good, SolveStatus::converged}};
}

TEST(HardCases, EndInTheirStatus) {
  for (const HardCase& hard : hard_cases())
    EXPECT_EQ(solve_nonlinear(hard.problem, {}).status, hard.damped) << hard.name;
}

// All of them side by side, so that each lane has neighbours that end otherwise.
TEST_P(EverySetting, EndsHardCasesAlikeAloneAndTogether) {
  std::vector<RangeProblem> problems;
  for (const HardCase& hard : hard_cases()) problems.push_back(hard.problem);
  std::vector<PointEstimate> together(problems.size());
  for (const int max_iterations : {1, 50}) {
    NonlinearOptions options = GetParam().options;
    options.max_iterations = max_iterations;
    solve_nonlinear(problems, options, together);
    for (std::size_t i = 0; i < problems.size(); ++i) {
      const PointEstimate alone = solve_nonlinear(problems[i], options);
      EXPECT_TRUE(same(alone, together[i]))
          << hard_cases()[i].name << ": " << name_of(alone.status) << " and " << name_of(together[i].status);
      EXPECT_LE(alone.iterations, 2 * max_iterations);
      EXPECT_TRUE(alone.position_m.allFinite() || !is_usable(alone.status)) << hard_cases()[i].name;
    }
  }
}

TEST(Descent, OneIterationThatDoesNotConvergeIsItsLimit) {
  for (const Damping damping : {Damping::none, Damping::lm}) {
    NonlinearOptions options;
    options.damping = damping;
    options.max_iterations = 1;
    EXPECT_EQ(solve_nonlinear(ring_problems(1)[0], options).status, SolveStatus::iteration_limit);
  }
}

TEST(Descent, OfOneThatDivergedNoPositionIsGiven) {
  RangeProblem problem;
  problem.count = 4;
  for (int i = 0; i < 4; ++i) {
    problem.sensor_m[i] = Eigen::Vector3d(i % 2, i / 2, i == 3 ? 1.0 : 0.0);
    problem.range_m[i] = 1.0;
  }
  const PointEstimate estimate =
      estimate_of(problem, {.position_m = {1.0, 2.0, 3.0}, .status = SolveStatus::diverged, .iterations = 4});
  EXPECT_EQ(estimate.status, SolveStatus::diverged);
  EXPECT_TRUE(estimate.position_m.array().isNaN().all());
  EXPECT_EQ(estimate.iterations, 4);
}

TEST(RangeLanes, RefuseDamping) {
  RangeLanes lanes(std::vector<Vector3d>(4, Vector3d::Zero()), 1);
  EXPECT_THROW(descend(lanes, {}), InternalError);
}

TEST(Newton, EndsWhereGaussNewtonEndsInFewerSteps) {
  double newton_steps = 0, gauss_newton_steps = 0;
  for (const RangeProblem& problem : ring_problems(200)) {
    NonlinearOptions options;
    const PointEstimate gauss_newton = solve_nonlinear(problem, options);
    options.curvature = Curvature::newton;
    const PointEstimate newton = solve_nonlinear(problem, options);
    ASSERT_EQ(newton.status, SolveStatus::converged);
    EXPECT_LT((newton.position_m - gauss_newton.position_m).norm(), 1e-9);
    newton_steps += newton.iterations;
    gauss_newton_steps += gauss_newton.iterations;
  }
  EXPECT_LT(newton_steps, 0.7 * gauss_newton_steps);
}

// At the exact minimum no step is taken, and F does not change: that is what the rule asks.
TEST(Descent, ExactDataThatStartAtTheTruthConvergeByTheObjectiveToo) {
  NonlinearOptions options;
  options.stop = StopRule::objective;
  options.start = Start::guess;
  int converged = 0;
  double worst_m = 0.0;
  constexpr int kProblems = 2000;
  for (std::uint32_t item = 0; item < kProblems; ++item) {
    const RandomStream random{23, Purpose::test, item};
    RangeProblem problem;
    problem.count = 4;
    const Vector3d truth(random.uniform(0, -0.6, 0.6), random.uniform(1, 0.1, 1.9),
                         random.uniform(2, -0.6, 0.6));
    for (int i = 0; i < problem.count; ++i) {
      const double angle = 1.5708 * i;
      problem.sensor_m[static_cast<std::size_t>(i)] = {2.0 * std::cos(angle), 0.3 + 0.6 * i,
                                                       2.0 * std::sin(angle)};
      problem.range_m[static_cast<std::size_t>(i)] =
          (truth - problem.sensor_m[static_cast<std::size_t>(i)]).norm();
    }
    problem.guess_m = truth;
    const PointEstimate estimate = solve_nonlinear(problem, options);
    converged += estimate.status == SolveStatus::converged && estimate.iterations < 100;
    worst_m = std::max(worst_m, (estimate.position_m - truth).norm());
  }
  EXPECT_EQ(converged, kProblems);
  EXPECT_LT(worst_m, 1e-3);  // the rule asks for 1e-8 m2 in F
}

}  // namespace
}  // namespace trilat
