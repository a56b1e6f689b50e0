// SPDX-License-Identifier: MIT
#include "pipeline/gate/measure_speed.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <string>
#include <thread>

#include "datasets/base/check.h"
#include "datasets/base/error.h"
#include "datasets/synthetic/range_trials.h"
#include "evaluators/solvers/geometric.h"
#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "pipeline/gate/other_work.h"
#include "pipeline/gate/reference_kernel.h"
#include "pipeline/manifest.h"

namespace trilat {
namespace {

constexpr int kSensors = 4;
constexpr std::size_t kWarmUpRounds = 2;

double thread_ns() {
  timespec now{};
  TRILAT_CHECK(clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0, "a thread has a clock");
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

struct Problems {
  std::vector<RangeProblem> ranges;
  std::vector<ReferenceProblem> plain;
};

Problems make_problems(std::size_t count) {
  RangeTrialModel model;
  model.seed = 1;
  model.sensors = kSensors;
  constexpr double kRadius_m = 2.0, kHeights_m[kSensors] = {0.6, 2.2, 0.9, 1.9};
  constexpr double kAcross[kSensors][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  for (std::size_t s = 0; s < kSensors; ++s)
    model.sensor_m[s] = {kRadius_m * kAcross[s][0], kHeights_m[s], kRadius_m * kAcross[s][1]};
  model.error = TrialError::gaussian;
  model.low_m = model.high_m = 0.02;  // mean magnitude: 2.5 cm standard deviation
  const std::size_t stride = (count + kTrialBlock - 1) / kTrialBlock * kTrialBlock;
  std::vector<double> truth_m(3 * stride), range_m(kSensors * stride), mean_m(3 * stride);
  make_range_trials(model, 0, count, {stride, truth_m.data(), range_m.data(), mean_m.data(), nullptr});
  Problems problems;
  for (std::size_t i = 0; i < count; ++i) {
    RangeProblem ranges;
    ReferenceProblem plain{};
    ranges.count = kSensors;
    for (std::size_t s = 0; s < kSensors; ++s) {
      ranges.sensor_m[s] = Eigen::Vector3d(model.sensor_m[s].data());
      ranges.range_m[s] = plain.range_m[s] = range_m[s * stride + i];
      std::copy(model.sensor_m[s].begin(), model.sensor_m[s].end(), plain.sensor_m[s]);
    }
    ranges.hint_m = Eigen::Vector3d(mean_m[i], mean_m[stride + i], mean_m[2 * stride + i]);
    problems.ranges.push_back(ranges);
    problems.plain.push_back(plain);
  }
  return problems;
}

struct Contestant {
  std::string name;
  std::function<void()> solve;  // all problems once
};

NonlinearOptions newton_options() {
  NonlinearOptions options;
  options.curvature = Curvature::newton;
  return options;
}

std::vector<Contestant> contestants(const Problems& problems, std::vector<PointEstimate>& estimates) {
  const auto each = [&](auto solve) {
    return [&problems, &estimates, solve] {
      for (std::size_t i = 0; i < problems.ranges.size(); ++i) estimates[i] = solve(problems.ranges[i]);
    };
  };
  const auto batch = [&](const NonlinearOptions& options) {
    return [&problems, &estimates, options] { solve_nonlinear(problems.ranges, options, estimates); };
  };
  const NonlinearOptions plain, newton = newton_options();
  LinearOptions all_pairs;
  all_pairs.reference = LinearReference::all_pairs;
  return {{"linear", each([](const RangeProblem& p) { return solve_linear(p, {}); })},
          {"linear all pairs", each([=](const RangeProblem& p) { return solve_linear(p, all_pairs); })},
          {"geometric", each([](const RangeProblem& p) { return solve_geometric(p, {}); })},
          {"nonlinear", each([=](const RangeProblem& p) { return solve_nonlinear(p, plain); })},
          {"nonlinear, batch", batch(plain)},
          {"newton", each([=](const RangeProblem& p) { return solve_nonlinear(p, newton); })},
          {"newton, batch", batch(newton)}};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Times {
  std::vector<double> ratios, solver_ns, reference_ns;
  void add(double here_ns, double before_ns, double after_ns) {
    ratios.push_back(2.0 * here_ns / (before_ns + after_ns));
    solver_ns.push_back(here_ns);
    reference_ns.push_back(before_ns);
  }
};

}  // namespace

SpeedFile measure_speed(const MeasureOptions& options) {
  const OtherWork others;
  const Problems problems = make_problems(options.problems);
  std::vector<PointEstimate> estimates(options.problems);
  const std::vector<Contestant> solvers = contestants(problems, estimates);
  volatile double kept = 0.0;
  const auto time_of = [](const auto& work) {
    const double start = thread_ns();
    work();
    return std::max(1.0, thread_ns() - start);
  };
  const auto time_reference = [&] { return time_of([&] { kept = solve_reference(problems.plain); }); };
  std::vector<Times> times(solvers.size());
  const std::size_t tenth = std::max<std::size_t>(1, options.rounds / 10);
  for (std::size_t round = 0; round < kWarmUpRounds + options.rounds; ++round) {
    if (options.stop_requested && options.stop_requested()) throw Interrupted();
    double before_ns = time_reference();
    for (std::size_t k = 0; k < solvers.size(); ++k) {
      const std::size_t s = (k + round) % solvers.size();
      const double here_ns = time_of(solvers[s].solve);
      const double after_ns = time_reference();
      if (round >= kWarmUpRounds) times[s].add(here_ns, before_ns, after_ns);
      before_ns = after_ns;
    }
    if (options.progress)
      options.progress(static_cast<double>(round + 1) / static_cast<double>(kWarmUpRounds + options.rounds));
    if (round % tenth == 0) std::this_thread::sleep_for(std::chrono::duration<double>(options.pause_s));
  }
  const auto n = static_cast<double>(options.problems);
  SpeedFile speed{processor_name(),    kReferenceKernel,
                  options.problems,    median(times[0].reference_ns) / n,
                  others.processors(), {}};
  for (std::size_t s = 0; s < solvers.size(); ++s)
    speed.solvers.push_back({solvers[s].name, times[s].ratios, median(times[s].solver_ns) / n});
  return speed;
}

SpeedFile joined_speed(const std::vector<SpeedFile>& runs) {
  TRILAT_CHECK(!runs.empty(), "there is something to join");
  SpeedFile joined = runs.front();
  std::vector<double> reference_ns;
  for (const SpeedFile& run : runs) {
    reference_ns.push_back(run.reference_ns);
    joined.others_busy = std::max(joined.others_busy, run.others_busy);
  }
  joined.reference_ns = median(reference_ns);
  for (std::size_t s = 0; s < joined.solvers.size(); ++s) {
    std::vector<double> solver_ns;
    joined.solvers[s].ratios.clear();
    for (const SpeedFile& run : runs) {
      const SolverSpeed& solver = run.solvers.at(s);
      joined.solvers[s].ratios.insert(joined.solvers[s].ratios.end(), solver.ratios.begin(),
                                      solver.ratios.end());
      solver_ns.push_back(solver.median_ns);
    }
    joined.solvers[s].median_ns = median(solver_ns);
  }
  return joined;
}

}  // namespace trilat
