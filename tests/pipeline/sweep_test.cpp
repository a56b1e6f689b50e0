// SPDX-License-Identifier: MIT
#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "datasets/base/error.h"
#include "pipeline/sweep/sweep_cell.h"
#include "pipeline/sweep/sweep_spec.h"
#include "pipeline/sweep/sweep_summary.h"
#include "pipeline/sweep/sweep_tables.h"
#include "tests/pipeline/swept_folders.h"
#include "tests/support/scratch.h"

namespace trilat {
namespace {

using testing::HasSubstr;

// The trials of a cell, one problem at a time.
struct PlainLoop {
  std::uint64_t answered = 0;
  std::array<double, 3> axis_m{};
  double distance_m = 0.0, square_m2 = 0.0, largest_m = 0.0, iterations = 0.0;
};

PlainLoop plain_loop(const SweepSpec& spec, const SweepSetting& setting) {
  const SweepTrials trials = trials_of(spec, setting);
  const RangeTrialModel& model = trials.model;
  const auto n = static_cast<std::size_t>(spec.trials);
  const std::size_t stride = n + kTrialBlock;
  std::vector<double> truth(3 * stride), range(8 * stride), mean(3 * stride);
  make_range_trials(model, 0, n, {stride, truth.data(), range.data(), mean.data()});
  PlainLoop loop;
  for (std::size_t i = 0; i < n; ++i) {
    RangeProblem problem;
    problem.count = model.sensors;
    for (std::size_t s = 0; s < static_cast<std::size_t>(model.sensors); ++s) {
      problem.sensor_m[s] = {model.sensor_m[s][0], model.sensor_m[s][1], model.sensor_m[s][2]};
      problem.range_m[s] = range[s * stride + i];
    }
    if (trials.has_guess) problem.guess_m = Eigen::Vector3d(mean[i], mean[stride + i], mean[2 * stride + i]);
    const PointEstimate estimate = solve_nonlinear(problem, trials.options);
    loop.iterations += estimate.iterations;
    if (!is_usable(estimate.status)) continue;
    const Eigen::Vector3d error_m =
        estimate.position_m - Eigen::Vector3d(truth[i], truth[stride + i], truth[2 * stride + i]);
    ++loop.answered;
    for (int axis = 0; axis < 3; ++axis) loop.axis_m[axis] += std::abs(error_m[axis]);
    loop.distance_m += error_m.norm();
    loop.square_m2 += error_m.squaredNorm();
    loop.largest_m = std::max(loop.largest_m, error_m.norm());
  }
  return loop;
}

TEST(Sweep, ACellIsWhatAPlainLoopOverItsTrialsGives) {
  const SweepSpec spec = sweep_of(R"("rigs": [{"name": "high", "heights_m": [0.3, 2.3, 0.3, 2.3]},
      {"name": "nearly flat", "heights_m": [0.9, 0.9, 0.9, 1.4]}, {"name": "flat", "heights_m": [1, 1, 1, 1]},
      {"name": "three", "heights_m": [1, 2, 1.5]}, {"name": "five", "heights_m": [0.3, 2, 0.5, 1, 1.2]}],
      "solver": {"error_cm": [5, 15]},
      "vary": {"error_model": ["range_signed", "displacement"], "gradient": ["printed", "corrected"],
      "stop": ["printed", "objective", "step"], "damping": ["none", "lm"], "start": ["linear", "squared_ranges"],
      "threshold": [1, 1e-4]}, "trials": 60, "max_iterations": 200)");
  const SweepSummary run = swept(spec);
  ASSERT_EQ(run.cells.size(), spec.cells.size());
  std::uint64_t failed = 0;
  for (std::size_t c = 0; c < run.cells.size(); ++c) {
    const SweepCell& cell = run.cells[c];
    const PlainLoop loop = plain_loop(spec, spec.cells[c]);
    const std::string id = json_of(cell).dump();
    const auto value = [&](const char* measure, const char* statistic) {
      return run.value(cell, {.measure = measure, .statistic = statistic});
    };
    ASSERT_EQ(json_of<SweepSetting>(cell), json_of(spec.cells[c]));
    ASSERT_EQ(run.numbers.n(cell.key().with(kSweptAnswers)), 60u);
    ASSERT_EQ(run.numbers.n(cell.key().with(kSweptError)), loop.answered) << id;
    EXPECT_NEAR(value("answered", "share"), static_cast<double>(loop.answered) / 60.0, 1e-12);
    failed += 60 - loop.answered;
    EXPECT_NEAR(value("iterations", "mean"), loop.iterations / 60.0, 0.05) << id;  // the failed ones count
    if (loop.answered == 0) continue;
    const auto n = static_cast<double>(loop.answered);
    // Long undamped descents blow up the rounding of their start.
    const double same_m = value("iterations", "max") > 50 ? 1e-5 : 1e-10;
    EXPECT_NEAR(value("distance", "mean"), loop.distance_m / n, same_m) << id;
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(value(kAxisNames[axis], "mean_abs"), loop.axis_m[axis] / n, same_m) << id;
    EXPECT_NEAR(value("distance", "rms"), std::sqrt(loop.square_m2 / n), same_m) << id;
    EXPECT_NEAR(value("distance", "max"), loop.largest_m, 10.0 * same_m) << id;
  }
  EXPECT_GT(failed, 100u);  // the iteration limit and its stages are among what is compared
}

TEST(Sweep, WithoutErrorsTheTruthIsFoundToAllDigits) {
  const auto summary = swept(sweep_of(kOneRig + R"(, "solver": {"error_cm": [0, 0], "threshold": 1e-6},
      "vary": {"error_model": ["range_signed", "displacement", "gaussian"], "stop": ["objective", "step"],
      "start": ["linear", "squared_ranges"]}, "trials": 500)"));
  ASSERT_FALSE(summary.cells.empty());
  for (const SweepCell& cell : summary.cells) {
    EXPECT_EQ(summary.numbers.n(cell.key().with(kSweptError)), 500u);
    // the worst joints of the volume are known to a thousand roundings
    EXPECT_LT(summary.value(cell, {.measure = "distance", .statistic = "max"}), 1e-12);
    EXPECT_LT(summary.value(cell, {.measure = "distance", .statistic = "p95"}), 1e-14);
  }
}

// A damped descent starts off the sensors' middle plane, so a large threshold stops it early.
TEST(Sweep, DampedDescentsWithoutErrorsEndAtTheTruthByTheStepRule) {
  const auto summary = swept(
      sweep_of(kOneRig + R"(, "solver": {"error_cm": [0, 0], "threshold": 1, "stop": "step", "damping": "lm"},
      "vary": {"start": ["linear", "squared_ranges"]}, "trials": 500)"));
  ASSERT_FALSE(summary.cells.empty());
  for (const SweepCell& cell : summary.cells) {
    EXPECT_EQ(summary.numbers.n(cell.key().with(kSweptError)), 500u);
    EXPECT_LT(summary.value(cell, {.measure = "distance", .statistic = "max"}), 1e-9);
  }
}

TEST(Sweep, ASmallerThresholdTakesMoreIterations) {
  const SweepSummary run = swept(sweep_of(kOneRig + R"(, "solver": {"error_cm": [0, 5]}, "trials": 1000,
      "vary": {"gradient": ["printed", "corrected"], "threshold": [1, 1e-2, 1e-4, 1e-6]})"));
  const auto steps = [&](std::size_t cell) { return run.value(run.cells[cell], kSweptSteps); };
  for (std::size_t gradient = 0; gradient < 2; ++gradient)
    for (std::size_t t = 1; t < 4; ++t) EXPECT_GT(steps(gradient * 4 + t), steps(gradient * 4 + t - 1));
  EXPECT_GT(steps(3), 500.0);  // printed gradient, smallest threshold
  EXPECT_LT(steps(7), 5.0);    // corrected
}

// The share that is done grows from 0 to 1 in each stage.
TEST(Sweep, SaysHowFarItIs) {
  const ScratchFolder folder;
  StudyOptions options;
  std::map<std::string, std::vector<double>> shares;
  std::mutex mutex;
  options.progress = [&](const std::string& stage, double share) {
    const std::lock_guard lock(mutex);
    shares[stage].push_back(share);
  };
  run_sweep(sweep_of(kOneRig +
                     R"(, "trials": 500, "time_problems": 10, "vary": {"threshold": [1, 1e-2, 1e-4, 1e-6]})"),
            folder / "results", options);
  ASSERT_EQ(shares.count("timing"), 1u);
  EXPECT_THAT(shares["timing"], testing::SizeIs(12));  // three rounds of four cells
  for (const auto& [stage, all] : shares) {
    EXPECT_TRUE(std::ranges::is_sorted(all)) << stage;
    EXPECT_GE(all.front(), 0.0) << stage;
    EXPECT_NEAR(all.back(), 1.0, 1e-12) << stage;
  }
}

TEST(LinearStart, IsLinearTrilateration) {
  for (const char* rig :
       {"[0.3, 2.3, 0.3, 2.3]", "[0.9, 0.9, 0.9, 1.4]", "[1, 2, 0.4, 1.1, 2.2, 0.7, 1.9, 0.3]"}) {
    const SweepSpec spec =
        sweep_of(std::string(R"("rigs": [{"name": "a", "heights_m": )") + rig + R"(}], "trials": 1)");
    const RangeTrialModel model = trials_of(spec, spec.cells.front()).model;
    RangeProblem problem;
    problem.count = model.sensors;
    for (int i = 0; i < problem.count; ++i)
      problem.sensor_m[i] = Eigen::Vector3d(model.sensor_m[i][0], model.sensor_m[i][1], model.sensor_m[i][2]);
    const LinearStart start = linear_start(problem);
    AlignedRows truth_m(3, 64), range_m(8, 64), position_m(3, 64);
    make_range_trials(model, 0, 64, {truth_m.stride(), truth_m.row(0), range_m.row(0)});
    start.positions(problem.count, 64, range_m, position_m);
    for (std::size_t i = 0; i < 64; ++i) {
      for (std::size_t s = 0; s < static_cast<std::size_t>(problem.count); ++s)
        problem.range_m[s] = range_m.row(s)[i];
      const Eigen::Vector3d expected_m = solve_linear(problem, {}).position_m;
      EXPECT_LT((position_m.position(i) - expected_m).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(SweepSums, QuantilesComeFromTheCounts) {
  Counts counts;
  for (std::size_t value = 1; value <= 100; ++value) counts.add(value);
  EXPECT_EQ(counts.quantile(0.5), 50u);
  EXPECT_EQ(counts.quantile(0.99), 99u);
  EXPECT_EQ(counts.quantile(1.0), 100u);
  EXPECT_EQ(counts.quantile(0.0), 1u);
  for (const double distance_m : {1e-9, 0.001, 0.0437, 1.0, 123.0})
    EXPECT_NEAR(bin_distance_m(distance_bin(distance_m)) / distance_m, 1.0, 0.008);
  EXPECT_EQ(bin_distance_m(distance_bin(0.0)), 0.0);
  for (const double distance_m : {1e-300, 1e300}) EXPECT_LT(distance_bin(distance_m), kDistanceBins);
}

// Trials are solved by chunks; the last one may hold a single trial.
TEST(Sweep, EveryTrialIsOneOfItsCell) {
  const SweepSummary run = swept(sweep_of(
      kOneRig + fmt::format(R"(, "solver": {{"error_cm": [0, 5]}}, "trials": {})", kChunkTrials + 1)));
  ASSERT_FALSE(run.cells.empty());
  for (const SweepCell& cell : run.cells)
    EXPECT_EQ(run.numbers.n(cell.key().with(kSweptAnswers)), kChunkTrials + 1);
}

TEST(SweepSums, FollowFromTheTrialsByPencil) {
  const Eigen::Vector3d truth_m(1.0, 0.0, 0.0);
  SweepSums first, sums;
  for (SweepSums* s : {&first, &sums}) s->add_start({1.0, 2.0, 0.0}, truth_m);
  first.add_start({kNaN, 0.0, 0.0}, truth_m);
  first.add({4.0, 0.0, -4.0}, SolveStatus::converged, 2, truth_m);
  sums.add({2.0, 2.0, 2.0}, SolveStatus::converged, 4, truth_m);
  sums.add({9.0, 9.0, 9.0}, SolveStatus::iteration_limit, 9, truth_m);
  sums.add(first);
  const NumberKey cell{.condition = "c", .group = "g", .method = "m"};
  const Numbers numbers = numbers_of(sums, cell);
  const auto value = [&](const char* measure, const char* statistic) {
    return numbers.value(cell.with({.measure = measure, .statistic = statistic}));
  };
  EXPECT_EQ(value("start", "mean"), 2.0);
  EXPECT_EQ(numbers.n(cell.with(kSweptAnswers)), 3u);
  EXPECT_EQ(value("answered", "share"), 2.0 / 3.0);
  EXPECT_EQ(numbers.n(cell.with({.measure = "status", .statistic = "converged"})), 2u);
  EXPECT_EQ(numbers.n(cell.with({.measure = "status", .statistic = "iteration_limit"})), 1u);
  const Number* mean = numbers.find(cell.with(kSweptError));
  EXPECT_EQ(mean->value, 4.0);  // 5 and 3
  EXPECT_EQ(mean->n, 2u);
  EXPECT_NEAR(mean->high - mean->value, 12.7062047, 1e-6);  // t of one degree, sqrt(2) / sqrt(2)
  EXPECT_NEAR(mean->value - mean->low, 12.7062047, 1e-6);
  EXPECT_EQ(value("x", "mean_abs"), 2.0);
  EXPECT_EQ(value("y", "mean_abs"), 1.0);
  EXPECT_EQ(value("z", "mean_abs"), 3.0);
  EXPECT_DOUBLE_EQ(value("distance", "rms"), std::sqrt(17.0));
  EXPECT_EQ(value("distance", "max"), 5.0);
  EXPECT_EQ(value("iterations", "mean"), 5.0);
  EXPECT_EQ(value("iterations", "median"), 4.0);
  EXPECT_EQ(value("iterations", "max"), 9.0);
  EXPECT_TRUE(numbers_of({}, cell).all().empty());
}

}  // namespace
}  // namespace trilat
