// SPDX-License-Identifier: MIT
// What a position costs with our solvers and with those one would take instead: the same problems, the same
// starts and the same accuracy in one process, repetitions interleaved. Every contestant gets the stop rule
// and the loosest tolerance with which it is fastest and reaches the accuracy for every problem. Solvers that
// only take steps which lower the cost end about root(rounding of F / curvature) from the minimum, a few
// nanometres here: hence a table for 1 nm and one for 10 nm.
// One at a time takes a RangeProblem and gives a position. Batched, ranges and starts lie in rows already and
// the answers stay in rows; copying the starts is counted. Nothing is compiled for a newer processor than
// x86-64 but our kernel, which chooses at run time.
// Options are those of Google Benchmark.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>

#include <Eigen/LU>
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/targets.h>

#include "evaluators/solvers/linear.h"
#include "evaluators/solvers/nonlinear.h"
#include "tests/benchmarks/contestants.h"
#include "tests/evaluators/range_problems.h"

namespace trilat {
namespace {

constexpr std::size_t kProblems = 512;  // a multiple of the lanes of two threads
constexpr double kRangeNoise_m = 0.025;
constexpr double kWanted_m[] = {1e-9, 1e-8};
constexpr double kLoosest = 1e-2;
constexpr int kTolerances = 15;  // down to 1e-16, by tens
constexpr int kTrialRuns = 3;
constexpr int kThreadRuns = 600;

// Newton's method on F in long double, from the minimum that the default finds.
Eigen::Vector3d optimum_m(const RangeProblem& problem) {
  using Vector = Eigen::Matrix<long double, 3, 1>;
  using Matrix = Eigen::Matrix<long double, 3, 3>;
  Vector x = solve_nonlinear(problem, {}).position_m.cast<long double>();
  for (int step = 0; step < 5; ++step) {
    Vector gradient = Vector::Zero();
    Matrix hessian = Matrix::Zero();
    for (int i = 0; i < problem.count; ++i) {
      const Vector from_sensor = x - problem.sensor_m[i].cast<long double>();
      const long double distance = from_sensor.norm();
      const Vector u = from_sensor / distance;
      const long double bend = 1.0L - problem.range_m[i] / distance;
      gradient += (distance - problem.range_m[i]) * u;
      hessian += u * u.transpose() + bend * (Matrix::Identity() - u * u.transpose());
    }
    x -= hessian.inverse() * gradient;
  }
  return x.cast<double>();
}

ComparisonProblems comparison_problems() {
  ComparisonProblems all;
  const RandomStream joints{1, Purpose::test, 0};
  for (std::uint32_t i = 0; i < kProblems; ++i) {
    RangeProblem problem = problem_of(well_posed_sensors_m(), random_joint_m(joints, i));
    add_noise(problem, RandomStream{2, Purpose::test, i}, kRangeNoise_m);
    all.start_m.push_back(solve_linear(problem, {}).position_m);
    all.optimum_m.push_back(optimum_m(problem));
    all.problem.push_back(problem);
  }
  return all;
}

struct Accuracy {
  double worst_m = 0.0;
  std::size_t not_reached = 0;
  double iterations = 0.0;  // of a solve

  bool reached() const { return not_reached == 0; }
};

// Runs the contestant's code for its instruction set.
double solve_all(const Contestant& contestant, const ComparisonProblems& problems, Tolerance tolerance,
                 Positions& positions_m) {
  hwy::SetSupportedTargetsForTest(contestant.vector_target);
  const double iterations = contestant.solve_all(problems, tolerance, positions_m);
  hwy::SetSupportedTargetsForTest(0);
  return iterations;
}

Accuracy accuracy_of(const Contestant& contestant, const ComparisonProblems& problems, Tolerance tolerance,
                     double wanted_m) {
  Positions positions_m(kProblems);
  Accuracy result;
  result.iterations = solve_all(contestant, problems, tolerance, positions_m) / kProblems;
  for (std::size_t i = 0; i < kProblems; ++i) {
    const double off_m = (positions_m[i] - problems.optimum_m[i]).norm();
    if (!(off_m <= wanted_m)) ++result.not_reached;
    if (!(off_m <= result.worst_m)) result.worst_m = off_m;
  }
  return result;
}

double lowest_s(const Contestant& contestant, const ComparisonProblems& problems, Tolerance tolerance,
                int runs) {
  Positions positions_m(kProblems);
  double lowest = 1e300;
  for (int run = 0; run < runs; ++run) {
    const auto start = std::chrono::steady_clock::now();
    solve_all(contestant, problems, tolerance, positions_m);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    lowest = std::min(lowest, spent.count());
  }
  return lowest;
}

struct Entry {
  Contestant contestant;
  double wanted_m = 0.0;
  Tolerance tolerance;
  Accuracy accuracy;
  std::vector<double> ns_per_solve;  // one a repetition

  std::string title() const { return fmt::format("{} to {:.0e} m", contestant.name, wanted_m); }
};

// The loosest tolerance of a stop rule that reaches the accuracy, or the one that comes nearest.
Entry with_rule(const Contestant& contestant, const ComparisonProblems& problems, double wanted_m, int rule) {
  Entry best{contestant, wanted_m, {}, {}, {}};
  best.accuracy.not_reached = kProblems + 1;
  for (int k = 0; k < kTolerances && !best.accuracy.reached(); ++k) {
    const Tolerance tolerance{rule, kLoosest * std::pow(10.0, -k)};
    const Accuracy accuracy = accuracy_of(contestant, problems, tolerance, wanted_m);
    if (accuracy.not_reached >= best.accuracy.not_reached) continue;
    best.tolerance = tolerance;
    best.accuracy = accuracy;
  }
  return best;
}

Entry with_best_rule(const Contestant& contestant, const ComparisonProblems& problems, double wanted_m) {
  Entry best;
  double best_s = 0.0;
  for (int rule = 0; rule < static_cast<int>(contestant.stop_rules.size()); ++rule) {
    const Entry entry = with_rule(contestant, problems, wanted_m, rule);
    const double spent_s = lowest_s(contestant, problems, entry.tolerance, kTrialRuns);
    const bool more = rule > 0 && entry.accuracy.not_reached != best.accuracy.not_reached;
    if (rule > 0 && (more ? entry.accuracy.not_reached > best.accuracy.not_reached : spent_s >= best_s))
      continue;
    best = entry;
    best_s = spent_s;
  }
  return best;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

double lowest(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

// Time of the processor for one thread, of the clock for more.
class Collector final : public benchmark::BenchmarkReporter {
 public:
  explicit Collector(std::map<std::string, Entry*> entries) : entries_(std::move(entries)) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
      Entry& entry = *entries_.at(run.run_name.function_name);
      const double spent_ns =
          entry.contestant.threads == 1 ? run.GetAdjustedCPUTime() : run.GetAdjustedRealTime();
      entry.ns_per_solve.push_back(spent_ns / (static_cast<double>(kProblems) * entry.contestant.rounds));
    }
  }

 private:
  std::map<std::string, Entry*> entries_;
};

void measure(std::vector<Entry>& entries, const ComparisonProblems& problems) {
  std::map<std::string, Entry*> by_name;
  for (Entry& entry : entries) {
    by_name[entry.title()] = &entry;
    benchmark::RegisterBenchmark(entry.title().c_str(), [&](benchmark::State& state) {
      Positions positions_m(kProblems);
      for (auto _ : state) {
        solve_all(entry.contestant, problems, entry.tolerance, positions_m);
        benchmark::DoNotOptimize(positions_m.data());
        benchmark::ClobberMemory();
      }
    })->UseRealTime();
  }
  Collector collector(by_name);
  benchmark::RunSpecifiedBenchmarks(&collector);
}

double lowest_ns_of(const std::vector<Entry>& entries, const std::string& name, double wanted_m) {
  for (const Entry& entry : entries)
    if (entry.contestant.name == name && entry.wanted_m == wanted_m && !entry.ns_per_solve.empty())
      return lowest(entry.ns_per_solve);
  return std::nan("");
}

void print_row(const Entry& entry, double ceres_ns, double tiny_ns) {
  const Accuracy& accuracy = entry.accuracy;
  const double ns = lowest(entry.ns_per_solve);
  const std::string iterations =
      std::isnan(accuracy.iterations) ? "not told" : fmt::format("{:.2f}", accuracy.iterations);
  const std::string& rule = entry.contestant.stop_rules[static_cast<std::size_t>(entry.tolerance.rule)];
  fmt::print("| {}{} | {} {:.0e} | {:.1f} | {:.1f} | {:.1e} | {} | {} | {:.1f} | {:.2f} |\n",
             entry.contestant.name, accuracy.reached() ? "" : " (**not reached**)", rule,
             entry.tolerance.value, median(entry.ns_per_solve), ns, accuracy.worst_m, accuracy.not_reached,
             iterations, ceres_ns / ns, tiny_ns / ns);
}

// Ratios are those of the lowest times: others on the machine slow a solver down, but never speed it up.
void print_table(const std::vector<Entry>& entries, double wanted_m) {
  const double ceres_ns = lowest_ns_of(entries, "ceres::Solve", wanted_m);
  const double tiny_ns = lowest_ns_of(entries, "ceres::TinySolver", wanted_m);
  fmt::print("\nTo {:.0e} m:\n\n", wanted_m);
  fmt::print(
      "| solver | stop rule | ns/solve (median) | ns/solve (lowest) | worst error (m) | not reached "
      "| iterations | x ceres::Solve | x TinySolver |\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n");
  for (const Entry& entry : entries)
    if (entry.wanted_m == wanted_m && !entry.ns_per_solve.empty()) print_row(entry, ceres_ns, tiny_ns);
}

// Both lowest times of many short runs, in turn: on a busy machine a median would count the others.
void print_speed_up(const std::vector<Entry>& entries, const ComparisonProblems& problems) {
  for (const Entry& many : entries) {
    if (many.contestant.threads == 1 || many.wanted_m != kWanted_m[0]) continue;
    const auto one = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
      return many.contestant.name.starts_with(entry.contestant.name + ", ");
    });
    if (one == entries.end()) continue;
    double one_s = 1e300, many_s = 1e300;
    for (int run = 0; run < kThreadRuns; ++run) {
      one_s = std::min(one_s, lowest_s(one->contestant, problems, one->tolerance, 1));
      many_s = std::min(many_s, lowest_s(many.contestant, problems, many.tolerance, 1));
    }
    fmt::print("\n{} threads against one, lowest of {} runs in turn: x {:.2f}\n", many.contestant.threads,
               kThreadRuns, one_s / one->contestant.rounds * many.contestant.rounds / many_s);
  }
}

int run(int argc, char** argv) {
  std::vector<std::string> words{argv[0], "--benchmark_enable_random_interleaving=true",
                                 "--benchmark_repetitions=21", "--benchmark_min_time=0.02"};
  words.insert(words.end(), argv + 1, argv + argc);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;

  const ComparisonProblems problems = comparison_problems();
  std::vector<Entry> entries;
  for (const double wanted_m : kWanted_m)
    for (const auto& contestants : {ceres_contestants(), own_contestants(problems)})
      for (const Contestant& contestant : contestants)
        entries.push_back(with_best_rule(contestant, problems, wanted_m));
  double load[1] = {std::nan("")};
  getloadavg(load, 1);
  measure(entries, problems);
  std::size_t repetitions = 0;
  for (const Entry& entry : entries) repetitions = std::max(repetitions, entry.ns_per_solve.size());
  fmt::print(
      "{} problems, 4 sensors at 0.3 and 2.3 m, range noise {} cm, start solve_linear(); {} repetitions, "
      "time of the processor (of the clock for several threads); load average before {:.1f}\n",
      kProblems, 100.0 * kRangeNoise_m, repetitions, load[0]);
  for (const double wanted_m : kWanted_m) print_table(entries, wanted_m);
  print_speed_up(entries, problems);
  benchmark::Shutdown();
  return 0;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) { return trilat::run(argc, argv); }
