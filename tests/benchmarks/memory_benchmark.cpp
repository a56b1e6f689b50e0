// SPDX-License-Identifier: MIT
// What evaluating one take keeps in memory at most, against the estimate that `--memory-mb` goes by, and how
// far that limit is kept when there are many takes. Usage: memory_benchmark [MINUTES [SENSORS…]]
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <vector>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/accuracy/memory_budget.h"
#include "pipeline/accuracy/take/plan.h"
#include "tests/pipeline/campaigns.h"

namespace trilat {
namespace {

constexpr const char* kPlain = R"("resamples": 0, "methods": [{"method": "nonlinear"}, {"method": "mean"}])";
constexpr const char* kOverTime =
    R"("resamples": 0, "clock": "motion", "methods": [{"method": "nonlinear"}, {"method": "kalman"},
       {"method": "rts"}, {"name": "printed", "method": "mean", "occlusion": "printed"}])";

// A process of its own has a peak of its own, and threads of its own.
void in_a_child(const std::function<void()>& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    work();
    std::fflush(stdout);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0) fmt::print("a process ended with status {}\n", status);
}

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1.024e-3;
}

struct Load {
  double minutes = 10.0;
  std::size_t sensors = 4;
  std::uint64_t takes = 1;
  int threads = 1;
  std::uint64_t at_once = 1;
};

void evaluate(const Load& load, const std::filesystem::path& folder, const char* methods) {
  const Campaign campaign = read_campaign(folder);
  const StudySpec study = study_of(methods);
  const Plan plan = make_plan(study, campaign);
  const double before_mb = peak_mb();
  const std::uint64_t limit_bytes = load.at_once * memory_needed_bytes(plan, plan.takes[0]);
  execute_study(study, campaign, folder / "results", {.threads = load.threads, .memory_bytes = limit_bytes});
  fmt::print("{:7.1f} {:7} {:5} {:7} {:7} {:>9} {:8.0f} {:8.0f} {:9.0f}\n", load.minutes, load.sensors,
             load.takes, load.threads, takes_at_once(plan, limit_bytes),
             methods == kPlain ? "plain" : "over time", static_cast<double>(limit_bytes) * 1e-6, peak_mb(),
             before_mb);
}

void measure(const Load& load) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("trilat-memory-{}", getpid());
  SimulationSpec spec = walking_spec(load.takes, 60.0 * load.minutes);
  spec.rig.heights_m.assign(load.sensors, 1.0);
  for (std::size_t s = 0; s < load.sensors; ++s) spec.rig.heights_m[s] += 0.2 * static_cast<double>(s % 4);
  in_a_child([&] { simulate_into(folder, spec); });
  for (const char* methods : {kPlain, kOverTime}) in_a_child([&] { evaluate(load, folder, methods); });
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  const double minutes = argc > 1 ? std::atof(argv[1]) : 10.0;
  std::vector<std::size_t> rigs;
  for (int i = 2; i < argc; ++i) rigs.push_back(std::strtoull(argv[i], nullptr, 10));
  if (rigs.empty()) rigs = {1, 4, 8};
  fmt::print("{:>7} {:>7} {:>5} {:>7} {:>7} {:>9} {:>8} {:>8} {:>9}\n", "minutes", "sensors", "takes",
             "threads", "at once", "methods", "limit MB", "peak MB", "before MB");
  for (const std::size_t sensors : rigs) trilat::measure({minutes, sensors, 1, 1, 1});
  for (const std::uint64_t at_once : {1, 2, 4}) trilat::measure({minutes / 4.0, 4, 6, 4, at_once});
}
