// SPDX-License-Identifier: MIT
// One body of laws, held against every method that solves a RangeProblem.
#include <cmath>
#include <functional>
#include <limits>
#include <ostream>

#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "datasets/rig/rigid_transform.h"
#include "evaluators/ceres/ceres_trilateration.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

using Eigen::Vector3d;

struct Method {
  const char* name;
  std::function<PointEstimate(const RangeProblem&)> solve;
  bool needs_hint = false;    // has a mirror solution whatever the number of sensors
  bool needs_volume = false;  // has no answer when the sensors are in one plane
  double exact_to_m = 1e-9;   // without noise
  double same_to_m = 1e-9;    // in another unit
};
void PrintTo(const Method& method, std::ostream* out) { *out << method.name; }

NonlinearOptions undamped(Gradient gradient, StopRule stop) {
  NonlinearOptions options;
  options.gradient = gradient;
  options.damping = Damping::none;
  options.stop = stop;
  options.threshold_m2 = 1e-26;
  options.max_iterations = 20'000;
  return options;
}

Method nonlinear(const char* name, const NonlinearOptions& options, double exact_to_m) {
  return {name, [options](const RangeProblem& p) { return solve_nonlinear(p, options); }, false, false,
          exact_to_m};
}

std::vector<Method> methods() {
  const LinearOptions all_pairs{LinearReference::all_pairs, 0, 1e-6};
  const auto undamped_step = undamped(Gradient::corrected, StopRule::step);
  const auto printed = undamped(Gradient::printed, StopRule::step);
  return {
      {"linear", [](const RangeProblem& p) { return solve_linear(p, {}); }, false, true},
      {"linear_all_pairs", [=](const RangeProblem& p) { return solve_linear(p, all_pairs); }, false, true},
      {"geometric", [](const RangeProblem& p) { return solve_geometric(p, {}); }, true, false},
      nonlinear("nonlinear", {}, 1e-9),
      nonlinear("nonlinear_undamped", undamped_step, 1e-9),
      nonlinear("nonlinear_printed", printed, 1e-7),
      {"ceres", [](const RangeProblem& p) { return solve_ceres(p, {}); }, false, false, 1e-9,
       1e-8},  // takes steps by the cost, which near the minimum drowns in rounding
  };
}

class EveryMethod : public testing::TestWithParam<Method> {
 protected:
  PointEstimate solve(const RangeProblem& problem) const { return GetParam().solve(problem); }
};
INSTANTIATE_TEST_SUITE_P(Laws, EveryMethod, testing::ValuesIn(methods()),
                         [](const auto& method) { return std::string(method.param.name); });

RangeProblem hinted(const std::vector<Vector3d>& sensors_m, const Vector3d& joint_m) {
  RangeProblem problem = problem_of(sensors_m, joint_m);
  problem.guess_m = joint_m + Vector3d(0.03, -0.02, 0.01);
  return problem;
}

TEST_P(EveryMethod, IsExactWithoutNoise) {
  const RandomStream random{3, Purpose::test, 0};
  for (std::uint32_t i = 0; i < 200; ++i) {
    Vector3d joint_m = random_joint_m(random, i);
    // away from the plane of the first three sensors, where three ranges do not fix a point
    const double above_m = joint_m.y() - (0.3 + joint_m.z());
    if (GetParam().needs_hint && std::abs(above_m) < 0.2) continue;
    const RangeProblem problem = hinted(well_posed_sensors_m(), joint_m);
    const PointEstimate estimate = solve(problem);
    ASSERT_TRUE(is_usable(estimate.status)) << i << " " << name_of(estimate.status);
    EXPECT_LT((estimate.position_m - joint_m).norm(), GetParam().exact_to_m) << i;
    EXPECT_LT(estimate.cost_m2, 1e-12);
    EXPECT_TRUE(std::isfinite(estimate.gdop));
  }
}

TEST_P(EveryMethod, MovesWithTheSensors) {
  const RigidTransform moved{Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Vector3d(1, -2, 0.5).normalized())),
                             {30, -4, 8}};
  RangeProblem problem = hinted(well_posed_sensors_m(), {0.1, 0.8, -0.2});
  add_noise(problem, RandomStream{4, Purpose::test, 0}, 0.02);
  RangeProblem other = problem;
  for (int i = 0; i < other.count; ++i) other.sensor_m[i] = moved * problem.sensor_m[i];
  other.guess_m = moved * *problem.guess_m;
  const PointEstimate here = solve(problem);
  const PointEstimate there = solve(other);
  EXPECT_EQ(here.status, there.status);
  EXPECT_LT((moved * here.position_m - there.position_m).norm(), 1e-7);
  EXPECT_NEAR(here.gdop, there.gdop, 1e-6 * here.gdop);
}

TEST_P(EveryMethod, AgreesWithItselfInCentimetres) {
  const bool printed = std::string(GetParam().name) == "nonlinear_printed";
  int different = 0;
  for (std::uint64_t item = 0; item < 100; ++item) {
    RangeProblem problem = hinted(well_posed_sensors_m(),
                                  random_joint_m({5, Purpose::test, 0}, static_cast<std::uint32_t>(item)));
    add_noise(problem, RandomStream{4, Purpose::test, item}, 0.02);
    RangeProblem in_cm = problem;
    for (int i = 0; i < in_cm.count; ++i) {
      in_cm.sensor_m[i] *= 100.0;
      in_cm.range_m[i] *= 100.0;
    }
    in_cm.guess_m = 100.0 * *problem.guess_m;
    const PointEstimate metres = solve(problem), centimetres = solve(in_cm);
    const double apart_m = (metres.position_m - centimetres.position_m / 100.0).norm();
    const bool usable = is_usable(metres.status) || is_usable(centimetres.status);
    if (metres.status != centimetres.status || (usable && !(apart_m < GetParam().same_to_m))) ++different;
  }
  if (printed) {
    EXPECT_GT(different, 90);  // not even its step is the same (erratum E7)
  } else {
    EXPECT_EQ(different, 0);
  }
}

TEST_P(EveryMethod, DoesNotCareForTheOrderOfTheList) {
  RangeProblem problem = hinted(well_posed_sensors_m(), {0.1, 0.8, -0.2});
  add_noise(problem, RandomStream{4, Purpose::test, 2}, 0.02);
  RangeProblem turned = problem;
  for (int i = 0; i < 4; ++i) {
    const int from = (i + 3) % 4;
    turned.sensor_m[i] = problem.sensor_m[from];
    turned.range_m[i] = problem.range_m[from];
    turned.rig_index[i] = problem.rig_index[from];
  }
  EXPECT_LT((solve(problem).position_m - solve(turned).position_m).norm(), 1e-7);
}

TEST_P(EveryMethod, RefusesWhatIsNotANumber) {
  const double nan = kNaN;
  const double inf = std::numeric_limits<double>::infinity();
  const RangeProblem good = hinted(well_posed_sensors_m(), {0.1, 0.8, -0.2});
  for (const double bad : {nan, inf, -inf}) {
    std::array<RangeProblem, 3> problems{good, good, good};
    problems[0].range_m[2] = bad;
    problems[1].sensor_m[1].y() = bad;
    problems[2].guess_m->x() = bad;
    for (const RangeProblem& problem : problems) {
      const PointEstimate estimate = solve(problem);
      EXPECT_EQ(estimate.status, SolveStatus::non_finite_input);
      EXPECT_TRUE(estimate.position_m.array().isNaN().all());
    }
  }
}

TEST_P(EveryMethod, RefusesNegativeRanges) {
  RangeProblem problem = hinted(well_posed_sensors_m(), {0.1, 0.8, -0.2});
  problem.range_m[1] = -0.5;
  EXPECT_EQ(solve(problem).status, SolveStatus::invalid_input);
}

TEST_P(EveryMethod, RefusesFewerThanThreeRanges) {
  const auto sensors_m = well_posed_sensors_m();
  for (std::size_t n : {0, 1, 2}) {
    const PointEstimate estimate =
        solve(hinted({sensors_m.begin(), sensors_m.begin() + n}, {0.1, 0.8, -0.2}));
    EXPECT_EQ(estimate.status, SolveStatus::too_few_ranges);
    EXPECT_TRUE(estimate.position_m.array().isNaN().all());
  }
  RangeProblem beyond;
  beyond.count = kMaxSensors + 1;
  EXPECT_THROW(solve(beyond), InternalError);
}

TEST_P(EveryMethod, CallsSensorsOnALineOrAPointRankDeficient) {
  const Vector3d joint_m(0.3, 0.5, 0.7);
  const Vector3d step_m(0.5, 0.2, -0.1);
  for (const Vector3d& along_m : {step_m, Vector3d(0, 0, 0)}) {
    const Vector3d a(1, 1, 1);
    const PointEstimate estimate =
        solve(hinted({a, a + along_m, a + 2.5 * along_m, a + 4.0 * along_m}, joint_m));
    EXPECT_EQ(estimate.status, SolveStatus::rank_deficient);
    EXPECT_TRUE(estimate.position_m.array().isNaN().all());
  }
}

TEST_P(EveryMethod, CallsAJointInThePlaneOfTheSensorsRankDeficient) {
  const PointEstimate estimate = solve(hinted(ring_m(0.9, 0.9, 0.9, 0.9), {0.2, 0.9, -0.3}));
  EXPECT_EQ(estimate.status, SolveStatus::rank_deficient) << name_of(estimate.status);
  EXPECT_FALSE(is_usable(estimate.status));
  EXPECT_FALSE(std::isfinite(estimate.gdop));
}

TEST_P(EveryMethod, InOnePlaneOfSensorsAnswersOnlyWithAHint) {
  const Vector3d joint_m(0.2, 1.4, -0.3);
  const auto sensors_m = ring_m(0.9, 0.9, 0.9, 0.9);
  RangeProblem problem = hinted(sensors_m, joint_m);
  if (GetParam().needs_volume) {
    EXPECT_EQ(solve(problem).status, SolveStatus::rank_deficient);
    return;
  }
  PointEstimate estimate = solve(problem);
  EXPECT_TRUE(is_usable(estimate.status)) << name_of(estimate.status);
  EXPECT_LT((estimate.position_m - joint_m).norm(), GetParam().exact_to_m);
  problem.guess_m = Vector3d(0.2, 0.4, -0.3);
  EXPECT_LT((solve(problem).position_m - Vector3d(0.2, 0.4, -0.3)).norm(), GetParam().exact_to_m);
  problem.guess_m = Vector3d(0.2, 1.0, -0.3);  // 0.4 m from one, 0.6 m from the other
  EXPECT_EQ(solve(problem).status, SolveStatus::mirror_ambiguous);
  problem.guess_m.reset();
  estimate = solve(problem);
  EXPECT_EQ(estimate.status, SolveStatus::mirror_ambiguous);
  EXPECT_NEAR(std::abs(estimate.position_m.y() - 0.9), 0.5, 1e-6);
}

TEST_P(EveryMethod, WithThreeSensorsAnswersOnlyWithAHint) {
  const Vector3d joint_m(0.2, 1.7, -0.3);
  RangeProblem problem = hinted({{2, 0.9, 0}, {0, 1.1, 2}, {-2, 0.7, 0}}, joint_m);
  if (GetParam().needs_volume) {
    EXPECT_EQ(solve(problem).status, SolveStatus::rank_deficient);
    return;
  }
  const PointEstimate estimate = solve(problem);
  EXPECT_TRUE(is_usable(estimate.status)) << name_of(estimate.status);
  EXPECT_LT((estimate.position_m - joint_m).norm(), GetParam().exact_to_m);
  problem.guess_m.reset();
  EXPECT_EQ(solve(problem).status, SolveStatus::mirror_ambiguous);
}

// The paper compares geometric on three sensors with nonlinear on four; on the same three they are one
// method.
TEST(ThreeSensors, GeometricAndNonlinearGiveTheSamePointWhereverBothAnswer) {
  int both = 0;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const Vector3d joint_m = random_joint_m({61, Purpose::test, 0}, i);
    RangeProblem problem = hinted({{2, 0.6, 0}, {0, 2.2, 2}, {-2, 0.9, 0}}, joint_m);
    add_noise(problem, RandomStream{62, Purpose::test, i}, 0.03);
    const PointEstimate geometric = solve_geometric(problem, {}), nonlinear = solve_nonlinear(problem, {});
    if (!is_usable(geometric.status) || !is_usable(nonlinear.status)) continue;
    ++both;
    EXPECT_LT((geometric.position_m - nonlinear.position_m).norm(), 1e-7) << i;
  }
  EXPECT_GT(both, 350);
}

TEST_P(EveryMethod, FindsAJointOnASensor) {
  const auto sensors_m = well_posed_sensors_m();
  const RangeProblem problem = hinted(sensors_m, sensors_m[3]);
  const PointEstimate estimate = solve(problem);
  EXPECT_TRUE(estimate.position_m.allFinite());
  // f / d does not vanish there, so the printed step never does
  if (std::string(GetParam().name) == "nonlinear_printed") return;
  ASSERT_TRUE(is_usable(estimate.status)) << name_of(estimate.status);
  EXPECT_LT((estimate.position_m - sensors_m[3]).norm(), 1e-7);
  EXPECT_TRUE(std::isfinite(estimate.cost_m2));
}

TEST_P(EveryMethod, NeverCallsUsableWhatIsNotFinite) {
  const RandomStream random{9, Purpose::test, 0};
  for (std::uint32_t i = 0; i < 300; ++i) {
    RangeProblem problem =
        problem_of(ring_m(0.9, 0.9 + 0.001 * random.uniform(2 * i), 0.9, 0.9), random_joint_m(random, i));
    for (int k = 0; k < 4; ++k) problem.range_m[k] *= random.uniform(1000 + 4 * i + k, 0.0, 2.0);
    const PointEstimate estimate = solve(problem);
    EXPECT_NE(estimate.status, SolveStatus::not_solved);
    if (!is_usable(estimate.status)) continue;
    EXPECT_TRUE(estimate.position_m.allFinite());
    EXPECT_TRUE(std::isfinite(estimate.cost_m2));
  }
  RangeProblem huge = hinted(well_posed_sensors_m(), {0.1, 0.8, -0.2});
  huge.range_m[0] = 1e200;
  const PointEstimate estimate = solve(huge);
  EXPECT_FALSE(is_usable(estimate.status) && !std::isfinite(estimate.cost_m2));
}

}  // namespace
}  // namespace trilat
