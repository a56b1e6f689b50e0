// SPDX-License-Identifier: MIT
// How long `trilat run` takes on the paper's campaign.
// Usage: run_benchmark [PARTICIPANTS [DURATION_S [REPEATS]]]
#include <chrono>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include "datasets/base/json.h"
#include "pipeline/accuracy/accuracy_study.h"
#include "pipeline/simulate/campaign_study.h"
#include "pipeline/study/study.h"

namespace trilat {
namespace {

constexpr const char* kStudy = R"({
  "format": "trilat.study", "version": 1, "kind": "accuracy", "name": "benchmark", "alignments": ["mean"],
  "methods": [
    {"method": "linear"}, {"name": "linear all pairs", "method": "linear", "reference": "all_pairs"},
    {"method": "geometric"},
    {"name": "nonlinear printed gradient", "method": "nonlinear", "gradient": "printed", "damping": "none",
     "stop": "objective", "threshold_cm2": 1e-4},
    {"name": "nonlinear printed stop", "method": "nonlinear", "damping": "none", "stop": "printed"},
    {"method": "nonlinear"}, {"method": "single"}, {"method": "mean"}, {"method": "tracked_mean"}
  ]
})";

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

int run(std::uint64_t participants, double duration_s, int repeats) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("trilat-benchmark-{}", getpid());
  SimulationSpec spec;
  spec.participants = participants;
  spec.activities = {{Activity::walking, duration_s, {}}};
  for (const JointGroup& group : joint_groups().first(4))
    spec.activities[0].marker_joints.insert(spec.activities[0].marker_joints.end(), group.joints.begin(),
                                            group.joints.end());
  fmt::print("simulating {} takes x {} s x {} sensors x {} joints\n", participants, duration_s,
             spec.rig.heights_m.size(), spec.activities[0].marker_joints.size());
  const Campaign campaign = simulate_campaign(spec, folder, {});
  const StudySpec study = parse_study(parse_json(kStudy, "benchmark"), "benchmark", {});
  for (int i = 0; i < repeats; ++i) {
    std::filesystem::remove_all(folder / "results");  // else nothing is computed again
    const auto start = std::chrono::steady_clock::now();
    execute_study(study, campaign, folder / "results", {});
    fmt::print("run {}: {:.2f} s\n", i + 1, seconds_since(start));
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("peak memory of this process (simulation included): {} MB\n", usage.ru_maxrss / 1024);
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace trilat

int main(int argc, char** argv) {
  return trilat::run(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 16,
                     argc > 2 ? std::atof(argv[2]) : 35.0, argc > 3 ? std::atoi(argv[3]) : 3);
}
