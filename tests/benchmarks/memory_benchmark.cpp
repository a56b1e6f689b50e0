// SPDX-License-Identifier: MIT
// What evaluating takes keeps in memory at most: one by one, and beside each other on several threads.
// Usage: memory_benchmark [MINUTES [SENSORS…]]
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
};

void evaluate(const Load& load, const std::filesystem::path& folder, const char* methods) {
  const Campaign campaign = read_campaign(folder);
  const StudySpec study = study_of(methods);
  const double before_mb = peak_mb();
  execute_study(study, campaign, folder / "results", {.threads = load.threads});
  fmt::print("{:7.1f} {:7} {:5} {:7} {:>9} {:8.0f} {:9.0f}\n", load.minutes, load.sensors, load.takes,
             load.threads, methods == kPlain ? "plain" : "over time", peak_mb(), before_mb);
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
  fmt::print("{:>7} {:>7} {:>5} {:>7} {:>9} {:>8} {:>9}\n", "minutes", "sensors", "takes", "threads",
             "methods", "peak MB", "before MB");
  for (const std::size_t sensors : rigs) trilat::measure({minutes, sensors, 1, 1});
  for (const int threads : {1, 2, 4}) trilat::measure({minutes / 4.0, 4, 6, threads});
}
